"""What the lab costs, in CPU time of Chromium's main thread at 1440 x 900: python tests/lab/budgets.py.

Prints each figure beside its bound, and ends with 1 if one is exceeded. `--minutes 10` plays on for so long, and
compares the memory in the end with that after a tenth of the time. WebGL is off: without a graphics card it would be
measured as that is imitated. Motion is reduced, so that each move is drawn once: else the images' windows go on to fit.
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))
import browser as chromium
from playwright.sync_api import Page, sync_playwright
from viewimit.app.lab.page import lab_page

WITHOUT_WEBGL = """HTMLCanvasElement.prototype.getContext = new Proxy(HTMLCanvasElement.prototype.getContext,
    {apply: (f, it, given) => given[0] === "webgl2" ? null : Reflect.apply(f, it, given)})"""
MOVES, ROUNDS = 40, 5
MS = 1000
TENTHS, MEMORY_SHARE = 10, 1.3  # of the time of play; of the memory after its first tenth


class Meter:
    """Counts CPU time of a page's main thread."""

    def __init__(self, page: Page):
        self._page, self._session = page, page.context.new_cdp_session(page)
        self._session.send("Performance.enable", {"timeDomain": "threadTicks"})

    def spent(self) -> float:
        """ms until now, in tasks of the main thread."""
        metrics = self._session.send("Performance.getMetrics")["metrics"]
        return MS * next(metric["value"] for metric in metrics if metric["name"] == "TaskDuration")

    def memory(self) -> float:
        """MB of live objects."""
        self._session.send("HeapProfiler.collectGarbage")
        return self._session.send("Runtime.getHeapUsage")["usedSize"] / 1e6

    def each(self, count: int, move: Callable[[int], None]) -> float:
        """ms of one of `count` moves, each drawn before the next: the median of some rounds."""
        found = []
        for _ in range(ROUNDS):
            before = self.spent()
            for k in range(count):
                move(k)
                self._page.evaluate("new Promise(requestAnimationFrame)")
            found.append((self.spent() - before) / count)
        return statistics.median(found)


def opened(page: Page, path: Path, webgl: bool) -> float:
    """ms until the script had drawn first, of the main thread."""
    if not webgl:
        page.add_init_script(WITHOUT_WEBGL)
    meter = Meter(page)
    page.goto(path.as_uri())
    while not page.evaluate("typeof lab === 'object'"):
        time.sleep(0.02)
    return meter.spent()


def measure(page: Page, path: Path) -> dict[str, tuple[float, float]]:
    """Figures in ms, each with its bound."""
    found = {"until the first drawing": (opened(page, path, webgl=False), 500.0)}
    time.sleep(2)  # until the fine map stands
    meter = Meter(page)
    box = page.locator("#map").bounding_box()
    assert box is not None
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.4 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    found["learner dragged: images, residuals, E"] = meter.each(MOVES, lambda k: page.mouse.move(x + k, y + k % 7)), 8.0
    page.mouse.up()
    point = page.evaluate(
        "() => { const {x, y, scale} = lab.images.views[0].window, images = lab.session().now.views.demo;"
        "return [(images[36] - x) * scale * lab.images.unit, (images[37] - y) * scale * lab.images.unit]; }"
    )
    box = page.locator("#l").bounding_box()
    assert box is not None
    x, y = box["x"] + point[0], box["y"] + point[1]
    page.mouse.move(x, y)
    page.mouse.down()
    drag = lambda k: page.mouse.move(x + 0.4 * (k % 20), y + 0.4 * (k % 10) + 5)
    found["demonstrator dragged, with the map of 2°"] = meter.each(MOVES, drag), 17.0
    page.mouse.up()
    time.sleep(1)
    found["the map of 1°, at rest"] = meter.each(4, lambda k: page.evaluate("lab.fineMap()")), 40.0
    return found


def memory_of_play(page: Page, minutes: float) -> list[float]:
    """MB after each tenth of some minutes of play, while the demonstrator moves."""
    meter, found = Meter(page), []
    page.evaluate("document.querySelector('#play').click()")
    began = time.monotonic()
    for tenth in range(1, TENTHS + 1):
        while time.monotonic() - began < 60 * minutes * tenth / TENTHS:
            for k in range(30):
                page.evaluate("k => lab.pose([0.8 + 0.3 * Math.sin(k / 5), -1.6 + 0.4 * Math.cos(k / 7)])", k)
                time.sleep(0.1)
        found.append(meter.memory())
    return found


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=0.0, help="of play, whose memory is measured (0)")
    minutes = parser.parse_args().minutes
    exceeded = False
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = Path(folder) / "lab.html"
        path.write_text(lab_page(), "utf-8")
        launched = playwright.chromium.launch(executable_path=chromium.find(), args=chromium.FLAGS)
        page = launched.new_page(viewport={"width": 1440, "height": 900}, reduced_motion="reduce")
        for what, (found, most) in measure(page, path).items():
            exceeded |= found > most
            print(f"{what:<45} {found:6.1f} ms, at most {most:g}{'  EXCEEDED' if found > most else ''}")
        if minutes:
            memory = memory_of_play(page, minutes)
            exceeded |= memory[-1] > MEMORY_SHARE * memory[0]
            made = page.evaluate("lab.session().now.motion")
            print(
                f"MB after each tenth of {minutes:g} min of play, {made} steps: "
                + " ".join(f"{MB:.1f}" for MB in memory)
            )
        launched.close()
    return int(exceeded)


if __name__ == "__main__":
    sys.exit(main())
