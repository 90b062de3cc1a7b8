"""How soon the page is there, and how often it is updated: `python tests/measure_page.py`.

Time from the command to "listening"; then, in one browser, an empty page of viser and ours in turn, each from
navigation until it is complete: canvas drawn, and for ours the four images, the landscape and the status too.
Then the bytes of the first load, and the share of a window of 1440 x 900 that L and R take, against the two of
130 x 209 px that they once had. Last, how many times a second the arms are posed while the loop runs.
"""

import argparse
import statistics
import subprocess
import sys
import time

import browser as chromium
from drawn import LEVELS, STATUS, VIEW_NAME, css
from playwright.sync_api import sync_playwright
from serving import Server

ROUNDS = 5
BEFORE = 2 * 130 * 209  # px²
EMPTY = (
    "import viser, time; server = viser.ViserServer(host='127.0.0.1', port=0); "
    "print(server.get_port(), flush=True); time.sleep(999)"
)
DRAWN = """() => {
  const small = Object.assign(document.createElement("canvas"), {width: 64, height: 64}).getContext("2d");
  const coloured = ([red, green, blue]) => Math.max(red, green, blue) - Math.min(red, green, blue) > 30;
  return [...document.querySelectorAll("canvas")].some(canvas => {
    if (!canvas.width) return false;
    small.drawImage(canvas, 0, 0, 64, 64);
    const {data} = small.getImageData(0, 0, 64, 64);
    return Array.from({length: 4096}, (_, k) => data.slice(4 * k, 4 * k + 3)).filter(coloured).length > 20;
  });
}"""
COMPLETE = {
    "viser": "document.querySelector('canvas') !== null",
    "viewimit": f"document.querySelectorAll('{css(LEVELS)}, {css(VIEW_NAME)}, {css(STATUS)}').length >= 6"
    f" && ({DRAWN})()",
}


def seconds_until_complete(browser, name: str, url: str) -> float:
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    began = time.perf_counter()
    page.goto(url)
    page.wait_for_function(COMPLETE[name], timeout=60_000, polling=50)
    page.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    taken = time.perf_counter() - began
    page.close()
    return taken


def first_load(browser, url: str) -> tuple[int, float, float]:
    """Bytes by HTTP; px² of L and R together, over what they once had and over the window."""
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    received = []
    network = page.context.new_cdp_session(page)
    network.send("Network.enable")
    network.on("Network.loadingFinished", lambda event: received.append(event["encodedDataLength"]))
    page.goto(url)
    page.wait_for_function(COMPLETE["viewimit"], timeout=60_000)
    boxes = [page.locator(f".vi-four:not(.vi-above *) svg.vi-at-{view}").bounding_box() for view in "LR"]
    area = sum(box["width"] * box["height"] for box in boxes)
    page.close()
    return round(sum(received)), area / BEFORE, area / (1440 * 900)


def updates_a_second(browser, url: str) -> float:
    """Messages that carry anything, while the retuned law runs as fast as it computes."""
    page = browser.new_page(viewport={"width": 1024, "height": 640})
    frames: list[float] = []
    page.on("websocket", lambda ws: ws.on("framereceived", lambda _: frames.append(time.perf_counter())))
    page.goto(url)
    page.wait_for_function(COMPLETE["viewimit"], timeout=60_000)
    page.keyboard.press("Space")
    page.wait_for_timeout(1500)
    frames.clear()
    page.wait_for_timeout(2000)
    page.close()
    return len(frames) / 2.0


def main() -> None:
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    starts = []
    for _ in range(ROUNDS):
        began = time.perf_counter()
        server = Server()
        starts.append(time.perf_counter() - began)
        server.stop()
    print(f"command to listening: {statistics.median(starts):.2f} s (median of {ROUNDS})")
    path = chromium.find()
    server = Server("--servo", "gradient-retuned")
    empty = subprocess.Popen([sys.executable, "-c", EMPTY], stdout=subprocess.PIPE, text=True)
    port = next(line.strip() for line in empty.stdout if line.strip().isdigit())
    taken: dict[str, list[float]] = {"viser": [], "viewimit": []}
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=chromium.FLAGS)
        for _ in range(ROUNDS):
            taken["viser"].append(seconds_until_complete(browser, "viser", f"http://127.0.0.1:{port}"))
            taken["viewimit"].append(seconds_until_complete(browser, "viewimit", server.url))
        received, factor, share = first_load(browser, server.url)
        print(f"first load: {received / 1000:.0f} kB")
        print(f"L and R: {100 * share:.1f} % of 1440 x 900, {factor:.2f} times as before")
        print(f"messages a second while the loop runs: {updates_a_second(browser, server.url):.0f}")
        browser.close()
    empty.kill()
    server.stop()
    for name, values in taken.items():
        print(f"page complete, {name}: {statistics.median(values):.2f} s (median of {ROUNDS})")


if __name__ == "__main__":
    main()
