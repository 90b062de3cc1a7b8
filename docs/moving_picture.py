"""Makes README's moving picture from the lab: python docs/moving_picture.py. It needs the browser of the tests.

The learner copies the demonstrator, which then moves, and follows it. Time is the picture's own, so that all machines
make the same frames, apart from how their browsers draw.
"""

import io
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright
from viewimit.app.lab.page import lab_page

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))
import browser as chromium  # noqa: E402

WINDOW, SHOWN = (1280, 800), (960, 600)  # px
FRAME_MS, PAUSE_FRAMES = 100, 12
QUALITY, MAX_BYTES = 68, 2_000_000
MOVES = 14  # frames in which the demonstrator goes
POSE = "share => lab.pose([0.785 - 0.35 * share, -1.571 - 0.45 * share])"


def frames(page: Page) -> list[Image.Image]:
    """The run, the demonstrator's move and what follows it."""
    found: list[Image.Image] = []

    def take(count: int) -> None:
        for _ in range(count):
            page.clock.run_for(FRAME_MS)
            picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            found.append(picture.resize(SHOWN, Image.Resampling.LANCZOS))

    take(4)
    page.evaluate("document.querySelector('#play').click()")
    take(58)
    for k in range(1, MOVES + 1):
        page.evaluate(POSE, k / MOVES)
        take(1)
    take(10 + PAUSE_FRAMES)
    return found


def main() -> int:
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(folder) / "lab.html"
        path.write_text(lab_page(), "utf-8")
        launched = playwright.chromium.launch(executable_path=chromium.find(), args=chromium.FLAGS)
        page = launched.new_page(viewport={"width": WINDOW[0], "height": WINDOW[1]}, color_scheme="light")
        page.clock.install(time=0)
        page.goto(path.as_uri())
        page.clock.pause_at(60_000)  # ms; from here on it goes by frames alone
        page.clock.run_for(4_000)
        first, *others = frames(page)
        launched.close()
    out = HERE / "lab.webp"
    options = {"quality": QUALITY, "method": 6, "duration": FRAME_MS, "loop": 0}
    first.save(out, save_all=True, append_images=others, **options)
    print(f"written to {out}, {out.stat().st_size / 1e6:.2f} MB")
    return int(out.stat().st_size > MAX_BYTES)


if __name__ == "__main__":
    sys.exit(main())
