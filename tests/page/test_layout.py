"""What must be seen together is, at every size, pixel ratio and zoom, in light and dark; a window that changes is laid
out anew. One page for all: only its window changes."""

import re

import numpy as np
import pytest
from browsing import (
    FOUR_IMAGES,
    LEGEND,
    LEVELS,
    METRICS,
    STATUS,
    VIEW_TABS,
    chosen_point,
    fold,
    open_page,
    press,
    status,
    still,
    switch,
    wait,
    wait_for_status,
)

pytestmark = pytest.mark.browser

RATIOS = (1, 1.5)
SIZES = [(1024, 640), (1024, 768), (1280, 720), (1440, 900), (1920, 1080)]
SMALL = [(390, 844), (360, 640), (853, 480), (576, 700), (577, 700), (999, 700), (1024, 600)]  # among them 150 % zoom
SIDEWAYS = [(640, 360), (667, 375), (844, 390)]  # phones
ALL_SIZES = [*SIZES, *SMALL, *SIDEWAYS]
LEAST_TEXT = 8.0  # px, as a drawing's letters come out in small windows
READABLE = 11.0  # px, and where there is room for all
BUTTONS = ("Play", "Step", "Undo", "Reset")

# Whole, and not covered: inside the window and whatever cuts it off, and what is met at its middle is its own
SEEN = """
selector => [...document.querySelectorAll(selector)].filter(e => e.getClientRects().length).map(e => {
  const box = e.getBoundingClientRect();
  let cut = Math.max(-box.left, -box.top, box.right - innerWidth, box.bottom - innerHeight);
  for (let a = e; a && getComputedStyle(a).position != "fixed"; a = a.parentElement) {
    const around = a.parentElement;
    if (!around || getComputedStyle(around).overflow == "visible") continue;
    const hole = around.getBoundingClientRect();
    cut = Math.max(cut, hole.left - box.left, hole.top - box.top, box.right - hole.right, box.bottom - hole.bottom);
  }
  const met = document.elementsFromPoint(box.left + box.width / 2, box.top + box.height / 2)
    .find(other => getComputedStyle(other).opacity != "0" && !other.closest(".vi-links"));
  const catches = getComputedStyle(e).pointerEvents != "none";
  const view = e.viewBox?.baseVal;
  const shown = getComputedStyle(e).visibility == "visible";
  return {cut, scale: view?.width ? box.width / view.width : 1, width: box.width, shown,
          met: met?.outerHTML.slice(0, 200),
          own: !catches || !met || e.contains(met) || met.contains(e) || e.parentElement.contains(met)};
}).filter(e => e.shown && e.width > 0)
"""

CAMERA = """() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() =>
  done(window.__viserMutable.camera.position.toArray()))))"""  # after another frame


@pytest.fixture(scope="module")
def page(browser, server):
    """At rest, with a point chosen, the offer of the tour declined."""
    page = open_page(browser, server, "small")
    page.window = page.context.new_cdp_session(page)
    press(page, "Escape")
    press(page, "n")
    press(page, "Space")
    wait_for_status(page, "At rest")
    press(page, "Space")
    yield page
    page.close()
    assert page.problems == []


def resize(page, width, height, ratio=1.0):
    """As when a window grows, is zoomed, or goes to another screen."""
    metrics = {"width": width, "height": height, "deviceScaleFactor": ratio, "mobile": False}
    page.window.send("Emulation.setDeviceMetricsOverride", metrics)
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")


def assert_seen(page, selector, least=1, where=""):
    found = page.evaluate(SEEN, selector)
    assert len(found) >= least, (selector, where)
    for each in found:
        assert each["cut"] <= 1 and each["own"], (selector, where, each)
        assert 11 * each["scale"] >= LEAST_TEXT, (selector, where, each)


def show(page, view):
    page.evaluate("id => document.getElementById(id).click()", f"vi-view-{view}")


def camera_at_rest(page):
    return still(page, lambda: np.round(page.evaluate(CAMERA), 2).tolist(), 2)


def test_the_view_is_fitted_to_another_canvas_unless_the_visitor_has_turned_it(page):
    first = camera_at_rest(page)
    resize(page, 1480, 720)
    wait(page, lambda: not np.allclose(page.evaluate(CAMERA), first, atol=0.05))
    fitted = camera_at_rest(page)
    box = page.locator("canvas[data-engine]").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + 60  # where nothing stands over the scene
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 80, y, steps=4)
    page.mouse.up()
    wait(page, lambda: not np.allclose(page.evaluate(CAMERA), fitted, atol=0.3))
    turned = camera_at_rest(page)
    page.keyboard.down("ArrowRight")  # the page's: viser would turn its camera as long as it is held
    camera_at_rest(page)
    page.keyboard.up("ArrowRight")
    assert np.allclose(page.evaluate(CAMERA), turned, atol=0.05)
    resize(page, 1280, 720)
    before = chosen_point(page)
    press(page, "n")
    wait(page, lambda: chosen_point(page) != before)
    assert np.allclose(page.evaluate(CAMERA), turned, atol=0.05)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_nothing_is_cut_or_covered_at_any_size_and_pixel_ratio(page, dark):
    if dark:
        resize(page, 1280, 720)
        fold(page, "Display")
        switch(page, "Dark")
        fold(page, "Display")
    for width, height in SIZES if not dark else SIZES[::2]:
        for ratio in RATIOS if not dark else RATIOS[:1]:
            where = f"{width} x {height} at {ratio}"
            resize(page, width, height, ratio)
            assert_seen(page, STATUS, where=where)
            assert_seen(page, f"{FOUR_IMAGES} svg:is(.vi-at-L, .vi-at-R, .vi-at-l, .vi-at-r)", 4, where)
            assert_seen(page, METRICS, where=where)
            assert_seen(page, LEGEND, where=where)
            assert_seen(page, f"svg:has({LEVELS})", where=where)
            for words in BUTTONS:
                assert page.get_by_text(words, exact=True).last.is_visible(), (words, where)


CUT = """() => [...document.querySelectorAll(".vi-status p")].filter(p => p.scrollHeight > p.clientHeight + 1)
  .map(p => p.textContent)"""


def test_all_that_the_learner_says_and_what_is_true_is_read(page):
    """The doubt, too, in which its sentence ends."""
    assert re.search(r"By E alone, it could be up to \d+° off\.$", status(page))
    for size in ALL_SIZES:
        resize(page, *size)
        assert page.evaluate(CUT) == [], size
        assert_seen(page, f"{STATUS}, .vi-truth p", 2, str(size))


def test_a_small_window_shows_one_view_at_a_time(page):
    for width, height in SMALL:
        where = f"{width} x {height}"
        resize(page, width, height)
        for view, seen, least in (
            ("images", f"{FOUR_IMAGES} svg:is(.vi-at-L, .vi-at-R, .vi-at-l, .vi-at-r)", 4),
            ("landscape", f"svg:has({LEVELS})", 1),
            ("scene", "canvas[data-engine]", 1),
        ):
            show(page, view)
            assert_seen(page, STATUS, where=where)
            assert_seen(page, VIEW_TABS, 4, where)
            assert_seen(page, seen, least, where)
            for words in BUTTONS:
                button = page.get_by_text(words, exact=True).last.bounding_box()
                assert button and button["y"] + button["height"] <= height, (words, where)
        show(page, "images")
        assert_seen(page, METRICS, where=where)


def test_the_views_of_a_small_window_can_be_chosen_by_keys(page):
    resize(page, 390, 844)
    show(page, "images")
    page.locator("#vi-view-images").focus()
    page.keyboard.press("ArrowRight")
    assert page.locator("#vi-view-landscape").is_checked()
    assert_seen(page, f"svg:has({LEVELS})")
