"""Makes the documentation's pictures, in the tests' browser: python docs/pictures.py [stills] [moving] [gallery].

stills: the article's figures as they stand at first, in docs/stills. moving: README's picture of the lab, lab.webp.
gallery: how each replay of docs/gallery.toml ends, in docs/gallery. Without a name it makes all three.
"""

import io
import json
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright
from viewimit.app.lab.article.page import FIGURES, script, styles
from viewimit.app.lab.page import lab_page

from viewimit.drawing.theme import DRAWING_CSS, font_faces, variables

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests")]
import browser as chromium  # noqa: E402
from directives.gallery import build_gallery, entries  # noqa: E402

WINDOW, SHOWN, LISTED = (
    (1280, 800),
    (960, 600),
    (640, 400),
)  # px: of the browser, of the moving picture, of the gallery's
FRAME_MS, PAUSE_FRAMES = 100, 12
QUALITY, MAX_BYTES = 68, 2_000_000
MOVES = 14  # frames in which the demonstrator goes
POSE = "share => lab.pose([0.785 - 0.35 * share, -1.571 - 0.45 * share])"
ARTICLE_PX = 736  # width of the documentation's text, for which stills are drawn


def figures_page(inside: Callable[[str], str]) -> str:
    """Return a page of all figures of the article, with other HTML at first in the place of each, by its name."""
    places = "".join(
        f'<div class="live" data-live="{name}"><div class="still">{inside(name)}</div></div>' for name in FIGURES
    )
    dark = f"body[data-theme=dark]{{{variables(True)}}}"
    sheet = f"{font_faces()}body{{margin:0;background:var(--paper);{variables(False)}}}{dark}{DRAWING_CSS}{styles()}"
    head = (
        '<!DOCTYPE html><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>Figures</title>'
    )
    return f'{head}<style>{sheet}</style><body data-theme="light">{places}<script>{script()}</script>'


def stills(browser: Browser, folder: Path) -> list[Path]:
    """Draw each figure of the article as it stands at first, with its state in a comment."""
    path = folder / "figures.html"
    path.write_text(figures_page(lambda name: ""), "utf-8")
    page = browser.new_page(viewport={"width": ARTICLE_PX, "height": 900}, color_scheme="light", device_scale_factor=1)
    page.goto(path.as_uri())
    out = HERE / "stills"
    out.mkdir(exist_ok=True)
    written = []
    for name in FIGURES:
        html, state = page.evaluate(SHOW, name)
        written.append(out / f"{name}.html")
        written[-1].write_text(f"<!-- {json.dumps(state)} -->\n{html}\n", "utf-8")
    page.close()
    return written


SHOW = """name => {
    article.mount(document.querySelector(`[data-live=${name}]`));
    const frame = article.begun.get(name);
    return [article.stillOf(frame, name), frame.figure.state()];
}"""


def moving(browser: Browser, folder: Path) -> list[Path]:
    """Show the lab as it plays. Time is the picture's own, so that all machines make the same frames, apart from how
    their browsers draw."""
    path, out = folder / "lab.html", HERE / "lab.webp"
    path.write_text(lab_page(), "utf-8")
    page = browser.new_page(viewport={"width": WINDOW[0], "height": WINDOW[1]}, color_scheme="light")
    page.clock.install(time=0)
    page.goto(path.as_uri())
    page.clock.pause_at(60_000)  # ms; from here on it goes by frames alone
    page.clock.run_for(4_000)
    first, *others = _frames(page)
    page.close()
    options = {"quality": QUALITY, "method": 6, "duration": FRAME_MS, "loop": 0}
    first.save(out, save_all=True, append_images=others, **options)
    if out.stat().st_size > MAX_BYTES:
        sys.exit(f"{out} is larger than {MAX_BYTES / 1e6:.0f} MB")
    return [out]


def _frames(page: Page) -> list[Image.Image]:
    """The run, the demonstrator's move and what follows it."""
    found: list[Image.Image] = []

    def take(count: int) -> None:
        for _ in range(count):
            page.clock.run_for(FRAME_MS)
            found.append(_picture(page, SHOWN))

    take(4)
    page.evaluate("document.querySelector('#play').click()")
    take(58)
    for k in range(1, MOVES + 1):
        page.evaluate(POSE, k / MOVES)
        take(1)
    take(10 + PAUSE_FRAMES)
    return found


def gallery(browser: Browser, folder: Path) -> list[Path]:
    """Show the last moment of each replay."""
    build_gallery(folder)
    out = HERE / "gallery"
    out.mkdir(exist_ok=True)
    written = []
    for entry in entries():
        page = browser.new_page(viewport={"width": WINDOW[0], "height": WINDOW[1]}, color_scheme="light")
        page.goto((folder / f"{entry.name}.html").as_uri())
        page.wait_for_timeout(1500)
        page.keyboard.press("End")
        page.wait_for_timeout(1500)
        written.append(out / f"{entry.name}.webp")
        _picture(page, LISTED).save(written[-1], quality=QUALITY, method=6)
        page.close()
    return written


def _picture(page: Page, size: tuple[int, int]) -> Image.Image:
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    return picture.resize(size, Image.Resampling.LANCZOS)


PICTURES = {"stills": stills, "moving": moving, "gallery": gallery}


def main(names: list[str]) -> int:
    unknown = [name for name in names if name not in PICTURES]
    if unknown:
        sys.exit(f"docs/pictures.py: no pictures {', '.join(unknown)}; there are {', '.join(PICTURES)}")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        launched = playwright.chromium.launch(executable_path=chromium.find(), args=chromium.FLAGS)
        for name in names or PICTURES:
            for path in PICTURES[name](launched, Path(folder)):
                print(f"{path}  {path.stat().st_size / 1e3:.0f} kB")
        launched.close()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
