"""The page in a browser: how a visitor opens it, what one does with it, and what one sees."""

import io
import itertools
import re
from contextlib import contextmanager
from pathlib import Path

import drawn
import numpy as np
from drawn import css
from PIL import Image
from waiting import wait_until

SIZES = {"least": (1024, 640), "small": (1280, 720), "large": (1920, 1080)}
PAUSE = 0.12  # s between widgets: the browser throttles messages at 50 ms and keeps only the latest
PATIENCE_S = 90.0  # other tests may run beside
PATIENCE_MS = 1000 * PATIENCE_S

# Where on the page a visitor finds what
STATUS = "[role=status]"
FOUR_IMAGES = '[aria-label="The four images"]'
POSTURE = f"{css(drawn.BAR)} b"  # the learner's joint angles
LESSON = css(drawn.LESSON)
KEYS = css(drawn.KEYS)
VIEW_NAME = css(drawn.VIEW_NAME)
EPIPOLAR_LINE = css(drawn.EPIPOLAR_LINE)
HOW = f"{css(drawn.IMAGES)} {css(drawn.HOW)}"  # the chosen point is recovered
IMAGE_L = f"{css(drawn.IMAGES)} {css(drawn.IMAGE_L)}"
CHOSEN_POINT = f"circle{css(drawn.CHOSEN_POINT)}"
CONFLICT = f"{css(drawn.CONFLICT)} b"
LEVELS = css(drawn.LEVELS)
ALL_TRANSFERS = css(drawn.ALL_TRANSFERS)
DUEL = css(drawn.DUEL)
HELP = css(drawn.HELP)
PANEL = css(drawn.PANEL)
METRICS, LEGEND = css(drawn.METRICS), f"{css(drawn.IMAGES)} {css(drawn.LEGEND)}"
VIEW_TABS = f"{css(drawn.VIEW_TABS)} label"  # of a small window
CARD = css(drawn.CARD)  # the curves, beside the scene where there is room
EXPERIMENT = css(drawn.EXPERIMENT)
PROGRESS = css(drawn.PROGRESS)
VERDICT_ROW = f"{css(drawn.VERDICT)} tr"
MOTION = css(drawn.MOTION)
PHOTOGRAPH = f"image{css(drawn.PHOTOGRAPH)}"
DETECTED = f"{css(drawn.OWN_POINTS)}:not({css(drawn.NOT_DETECTED)})"

LAST_NODE = "/now/chosen_demonstrator"  # of the 3-D scene, as it is built

# A software renderer needs nearly a second of both cores for a frame of the 3-D scene. Everything but its triangles is
# as ever, three.js with its shaders, lights and meshes too, at as many frames a second as on a slow machine.
# `canvas_colours` has them drawn in the next frame, and no frame follow it until it has been looked at.
SPARING = """{
window.drawsTriangles = window.holds = false;
const nextFrame = window.requestAnimationFrame.bind(window), waiting = new Map(), period = 100;
let asked = 0, comes = false;
const next = () => {
  if (!comes) setTimeout(() => nextFrame(show), period - performance.now() % period);
  comes = true;
};
const show = time => {
  comes = false;
  if (window.holds) return;
  for (const [id, call] of [...waiting]) try {
    if (waiting.delete(id)) call(time);
  } catch (error) { reportError(error); }
};
window.requestAnimationFrame = call => { waiting.set(++asked, call); next(); return asked; };
window.cancelAnimationFrame = id => waiting.delete(id);
window.goOn = () => { window.drawsTriangles = window.holds = false; next(); };
for (const kind of [WebGLRenderingContext, WebGL2RenderingContext])
  for (const name of ["drawArrays", "drawElements", "drawArraysInstanced", "drawElementsInstanced"]) {
    const draw = kind.prototype[name];
    if (draw) kind.prototype[name] = function (...what) {
      if (!window.drawsTriangles) return;
      draw.apply(this, what);
      setTimeout(() => { window.holds = window.drawsTriangles; });
    };
  }
}"""


def sparing(tab):
    """Let a tab, or all of a window, spare what no test looks at, see `SPARING`; return it."""
    tab.add_init_script(SPARING)
    return tab


@contextmanager
def private_windows(*faulty: str, own: tuple[str, ...] = ("file:", "data:", "about:")):
    """Gives a function, context → page, whose windows must ask nobody and have no fault.

    faulty: kinds of messages; own: how addresses begin that are nobody's.
    """
    contexts, faults, requests = [], [], []

    def page_of(context):
        contexts.append(context)
        page = context.new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: faults.append(said.text) if said.type in faulty else None)
        page.on("request", lambda request: requests.append(request.url))
        return page

    yield page_of
    for context in contexts:
        context.close()
    assert faults == []
    assert [url for url in requests if not url.startswith(own)] == []


def open_page(browser, url: str, size: str = "least", **options):
    """A tab with the page, complete. options: of the tab, as its pixel ratio. `problems`: errors; `requested`:
    addresses; `frames_received` by its socket."""
    width, height = SIZES[size]
    page = sparing(browser.new_page(viewport={"width": width, "height": height}, **options))
    page.problems, page.requested, page.frames_received = [], [], []
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.on("console", lambda m: page.problems.append(m.text) if m.type == "error" else None)
    page.on("request", lambda request: page.requested.append(request.url))
    page.on("websocket", lambda ws: ws.on("framereceived", lambda data: page.frames_received.append(data)))
    page.goto(url)
    wait_until_complete(page)
    return page


def wait_until_complete(page) -> None:
    page.wait_for_selector(STATUS, timeout=PATIENCE_MS)
    wait_for_count(page, LEVELS, 1)
    page.wait_for_function(f"window.__viserMutable?.nodeRefFromName['{LAST_NODE}']", timeout=PATIENCE_MS)
    page.evaluate("document.documentElement.classList.add('vi-anyway')")  # in a small window, the lab is not wanted


def wait_for_count(page, selector: str, least: int, exactly: bool = False) -> None:
    """Until so many are on the page."""
    counted = f"document.querySelectorAll({selector!r}).length {'==' if exactly else '>='} {least}"
    page.wait_for_function(counted, timeout=PATIENCE_MS)


def wait_for_text(page, text: str) -> None:
    """Anywhere on the page."""
    page.wait_for_function("text => document.body.textContent.includes(text)", arg=text, timeout=PATIENCE_MS)


def status(page) -> str:
    return page.text_content(STATUS)


def wait_for_status(page, pattern: str, seconds: float = PATIENCE_S) -> str:
    """Its text, once it matches."""
    page.wait_for_function(
        "([where, pattern]) => new RegExp(pattern).test(document.querySelector(where)?.textContent ?? '')",
        arg=[STATUS, pattern],
        timeout=1000 * seconds,
    )
    return status(page)


def wait(page, condition, seconds: float = PATIENCE_S):
    """condition's first true value, while the page's events are heard; a look costs the browser more than a pause."""
    return wait_until(condition, seconds, lambda _: pause(page))


def pause(page) -> None:
    page.wait_for_timeout(1000 * PAUSE)


def posture(page) -> list[float]:
    """The learner's read-out, degrees."""
    return [float(text.replace("−", "-").rstrip("°")) for text in page.locator(POSTURE).all_text_contents()]


def chosen_point(page) -> str:
    """Its name, as the legend has it; "" while it has none."""
    found = re.search(r"point (\S+): ", page.text_content(FOUR_IMAGES))
    return found[1] if found else ""


def points_drawn(page) -> list[int]:
    """How many of the learner's own points there are in L and in R."""
    dots = "where => [...document.querySelectorAll(where)].map(path => path.getAttribute('d').split('M').length - 1)"
    return page.evaluate(dots, f"svg:is(.vi-at-L,.vi-at-R) {DETECTED}")


def stands(session) -> list[float]:
    """What the read-out of a session's learner is, degrees."""
    return [float(f"{angle:.1f}") for angle in np.degrees(session.snapshot.theta)]


def row(page, label: str):
    """The innermost row of the panel that carries this label."""
    rows = page.locator("div.mantine-Flex-root").filter(has=page.get_by_text(_named(label)))
    return rows.filter(has=page.locator("input")).last


OPEN = """(row, isFolder) => {  // the folders that it stands in
  const around = e => e?.closest("[data-with-border]"), closed = [], own = around(row);
  for (let p = isFolder ? around(own?.parentElement) : own; p; p = around(p.parentElement)) {
    const head = p.querySelector(":scope>[role=button]");
    if (head?.getAttribute("aria-expanded") === "false") closed.unshift(head);
  }
  closed.forEach(head => head.click());
  return closed.length;
}"""


def uncovered_row(page, label: str):
    """As `row`, with the folders open that it stands in."""
    found = row(page, label)
    if found.evaluate(OPEN, False):
        still(page, lambda: found.bounding_box())
    return found


def _named(label: str) -> re.Pattern:
    """A label, with the name of the joint before its symbol."""
    start, name = ("Start ", label.removeprefix("Start ")) if label.startswith("Start ") else ("", label)
    return re.compile(f"^{start}(?:{drawn.JOINT_NAME})?{re.escape(name)}$")


def set_number(page, label: str, value) -> None:
    """Type into the number box of a slider or of a number."""
    box = uncovered_row(page, label).locator("input[type=text]").last
    box.fill(str(value))
    box.press("Enter")
    box.blur()  # a key typed into a box is not a command
    pause(page)


def choose(page, label: str, option: str) -> None:
    """Take an option of a dropdown."""
    box = uncovered_row(page, label).locator("input:visible").first
    box.click()
    page.get_by_role("option", name=option, exact=True).click()
    box.blur()
    pause(page)


def switch(page, label: str) -> None:
    """Click a checkbox."""
    box = uncovered_row(page, label).locator("input[type=checkbox]")
    box.click()
    box.blur()
    pause(page)


def press(page, key: str) -> None:
    page.keyboard.press(key)
    pause(page)


def click(page, words: str) -> None:
    page.get_by_text(words, exact=True).last.click()  # after the ways to other pages
    pause(page)


def still(page, read, looks: int = 4):
    """What `read` gives, once it has given it in so many looks in a row: a press on what moves goes down on one thing,
    up on another, and so is no click."""
    found = [read()]

    def rests():
        found.append(read())
        return len(found) >= looks and all(one == found[-1] for one in found[-looks:])

    wait(page, rests)
    return found[-1]


def fold(page, folder: str) -> None:
    """Open it, or shut it, and wait until nothing moves. What it holds stands beside its name."""
    of_panels = "[...document.querySelectorAll('.mantine-ScrollArea-content')].map(e => e.offsetHeight).join()"
    heights = lambda: page.evaluate(of_panels)
    head = page.get_by_text(re.compile(f"^{re.escape(folder)}(: .*)?$"))
    if head.evaluate(OPEN, True):
        still(page, heights)
    before = heights()
    head.click()
    wait(page, lambda: heights() != before)
    still(page, heights)


def downloaded(page, button: str) -> tuple[str, bytes]:
    with page.expect_download() as download:
        click(page, button)
    return download.value.suggested_filename, Path(download.value.path()).read_bytes()


def demonstrator(page) -> float:
    """The slider of joint 2, degrees."""
    return float(row(page, "θ₂").get_by_role("slider").get_attribute("aria-valuenow"))


def progress(page) -> str:
    return page.text_content(f"{PROGRESS} span")


def wait_for_progress(page, pattern: str, seconds: float = PATIENCE_S) -> None:
    wait(page, lambda: re.search(pattern, progress(page)), seconds)


def canvas_colours(page) -> int:
    """How many there are where the 3-D scene is, with all of it drawn."""
    if page.locator(".vi-flat").count():  # a busy machine was slow, so the page has put a still picture there
        page.evaluate("act('flat', 0)")
        wait_for_count(page, ".vi-flat", 0, exactly=True)
    page.evaluate("window.drawsTriangles = true")
    box = page.locator("canvas").first.bounding_box()
    places = itertools.cycle((0.3, 0.31))  # viser draws a frame when the pointer moves

    def holds():
        place = next(places)
        page.mouse.move(box["x"] + place * box["width"], box["y"] + place * box["height"])
        return page.evaluate("window.holds")

    wait(page, holds)
    picture = Image.open(io.BytesIO(page.screenshot(clip=box, timeout=PATIENCE_MS))).convert("RGB")
    page.evaluate("window.goOn()")
    return len(picture.getcolors(picture.width * picture.height))
