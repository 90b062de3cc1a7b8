"""What must be seen together is, at every size, pixel ratio and zoom, in light and dark; a window that changes is laid
out anew. One page for all: only its window changes."""

import re

import pytest
from browsing import (
    FOUR_IMAGES,
    LEGEND,
    LEVELS,
    METRICS,
    STATUS,
    VIEW_TABS,
    canvas_colours,
    choose,
    fold,
    open_page,
    press,
    status,
    switch,
    wait,
    wait_for_count,
    wait_for_status,
)

pytestmark = pytest.mark.browser

RATIOS = (1, 1.25, 1.5, 2)
SIZES = [(1024, 640), (1024, 768), (1280, 720), (1440, 900), (1920, 1080)]
SMALL = [(390, 844), (360, 640), (853, 480), (576, 700), (577, 700), (999, 700), (1024, 600)]  # among them 150 % zoom
SIDEWAYS = [(640, 360), (667, 375), (844, 390)]  # phones
ALL_SIZES = [*SIZES, *SMALL, *SIDEWAYS, (500, 800), (768, 1024), (1000, 620), (1180, 820), (1213, 720)]
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


# Height that the offer of the tour and the strip have in common, px; negative where both are apart
COVERED = """() => {
  const [offer, strip] = [".vi-offer", ".vi-status"].map(e => document.querySelector(e).getBoundingClientRect());
  const wide = Math.min(offer.right, strip.right) - Math.max(offer.left, strip.left);
  return offer.height && Math.min(wide, Math.min(offer.bottom, strip.bottom) - Math.max(offer.top, strip.top));
}"""


@pytest.fixture(scope="module")
def page(browser, server):
    """At rest, with a point chosen, the offer of the tour declined; what that covered before, by size."""
    page = open_page(browser, server, "small")
    page.window, page.covered = page.context.new_cdp_session(page), {}
    for size in ALL_SIZES:
        resize(page, *size)
        page.covered[size] = page.evaluate(COVERED)
    resize(page, 1280, 720)
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


def test_the_offer_of_the_tour_does_not_cover_what_the_learner_says(page):
    assert page.covered.keys() == set(ALL_SIZES) and max(page.covered.values()) < 0, page.covered


def show(page, view):
    page.evaluate("id => document.getElementById(id).click()", f"vi-view-{view}")


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_nothing_is_cut_or_covered_at_any_size_and_pixel_ratio(page, dark):
    if dark:
        resize(page, 1280, 720)
        fold(page, "Display")
        switch(page, "Dark")
        fold(page, "Display")
    for width, height in SIZES if not dark else SIZES[::2]:
        for ratio in RATIOS if not dark else RATIOS[::3]:
            where = f"{width} x {height} at {ratio}"
            resize(page, width, height, ratio)
            assert_seen(page, STATUS, where=where)
            assert_seen(page, f"{FOUR_IMAGES} svg:is(.vi-at-L, .vi-at-R, .vi-at-l, .vi-at-r)", 4, where)
            assert_seen(page, METRICS, where=where)
            assert_seen(page, LEGEND, where=where)
            assert_seen(page, f"svg:has({LEVELS})", where=where)
            for words in BUTTONS:
                assert page.get_by_text(words, exact=True).is_visible(), (words, where)


CUT = """() => [...document.querySelectorAll(".vi-status p")].filter(p => p.scrollHeight > p.clientHeight + 1)
  .map(p => p.textContent)"""


def test_all_that_the_learner_says_and_what_is_true_is_read(page):
    """The doubt, too, in which its sentence ends."""
    assert re.search(r"By E alone, it could be up to \d+° off\.$", status(page))
    for size in ALL_SIZES:
        resize(page, *size)
        assert page.evaluate(CUT) == [], size
        assert_seen(page, f"{STATUS}, .vi-truth p", 2, str(size))


SCROLLS = """() => { for (let a = document.querySelector(".vi-four:not(.vi-above *)"); a; a = a.parentElement)
  if (getComputedStyle(a).overflowY == "auto" && a.scrollHeight > a.clientHeight) return true;
  return false }"""


@pytest.mark.parametrize("width, height", SIZES)
def test_the_images_legend_and_figures_are_seen_without_scrolling(page, width, height):
    scrolls = []
    for ratio in RATIOS:
        resize(page, width, height, ratio)
        scrolls.append(page.evaluate(SCROLLS))
    resize(page, 1280, 720)
    assert not any(scrolls)


HEADED = """() => [["own", "L"], ["own", "R"], ["demo", "l"]].map(([pair, view]) => {
  const box = selector => document.querySelector(`.vi-four:not(.vi-above *) ${selector}`).getBoundingClientRect();
  return box(`.vi-over-${pair}`).bottom - box(`svg.vi-at-${view}`).top;
})"""


@pytest.mark.parametrize("width, height", [*SIZES, *SIDEWAYS, (390, 844), (320, 640), (576, 700), (1024, 600)])
def test_headings_stand_above_their_images_and_over_no_point(page, width, height):
    resize(page, width, height)
    above = page.evaluate(HEADED)
    resize(page, 1280, 720)
    assert max(above) <= 1


LETTERS = """() => [...document.querySelectorAll("[data-dock-region=right] :is(text,span,p,b,a,button,div)")]
  .filter(e => e.checkVisibility({visibilityProperty: true, opacityProperty: true}) && !e.closest(".vi-ask")
    && [...e.childNodes].some(n => n.nodeType === 3 && n.data.trim()))
  .map(e => {
    const svg = e.closest("svg"), view = svg?.viewBox?.baseVal;
    const scale = view?.width ? svg.getBoundingClientRect().width / view.width : 1;
    return [parseFloat(getComputedStyle(e).fontSize) * scale, e.textContent.slice(0, 30)];
  })"""


@pytest.mark.parametrize("width, height", [(1024, 768), (1280, 720), (1440, 900), (1920, 1080), (2560, 1440)])
def test_no_letter_of_the_right_column_is_too_small_and_none_dwarfs_the_others(page, width, height):
    resize(page, width, height)
    found = page.evaluate(LETTERS)
    resize(page, 1280, 720)
    small = [each for each in found if each[0] < READABLE - 0.35]
    assert len(found) > 20 and not small


def test_the_images_take_more_than_twice_the_share_of_the_window_that_they_had(page):
    """They had two of 130 x 209 px at 1440 x 900."""
    resize(page, 1440, 900)
    boxes = [page.locator(f".vi-four:not(.vi-above *) svg.vi-at-{view}").bounding_box() for view in "LR"]
    resize(page, 1280, 720)
    assert sum(box["width"] * box["height"] for box in boxes) >= 2.2 * 2 * 130 * 209


APART = """() => ["L", "R", "l", "r"].flatMap(view => {
  const [drawn, links] = [".vi-four:not(.vi-above *)", ".vi-links .vi-four"].map(
    panel => document.querySelector(`${panel} svg.vi-at-${view}`).getBoundingClientRect());
  return ["left", "top", "right", "bottom"].map(side => Math.abs(drawn[side] - links[side])) })"""


@pytest.mark.parametrize("transfer", ["Projective combination", "Epipolar (paper)"])
def test_in_a_low_window_all_is_seen_and_links_lie_where_their_points_are(page, transfer):
    """However many words tell how a point is recovered."""
    choose(page, "Transfer", transfer)
    told = "transferred" if transfer.startswith("P") else "cross at"
    for size in (*SIDEWAYS, (1024, 620), (1024, 640), (1100, 679), (1280, 680), (1280, 719), (1280, 720)):
        resize(page, *size)
        show(page, "images")
        wait(page, lambda: told in page.text_content("p.vi-how"))
        assert_seen(page, METRICS, where=str(size))
        wait(page, lambda: max(page.evaluate(APART)) < 0.5, 10)


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
                button = page.get_by_text(words, exact=True).bounding_box()
                assert button and button["y"] + button["height"] <= height, (words, where)
        show(page, "images")
        assert_seen(page, METRICS, where=where)


@pytest.mark.parametrize("width", [320, 360, 390])
def test_on_narrow_phones_words_are_whole_and_all_tabs_are_in_one_line(page, width):
    resize(page, width, 640)
    show(page, "images")
    assert page.evaluate(CUT) == []
    show(page, "landscape")
    tabs = [page.get_by_role("tab", name=name).bounding_box() for name in ("Landscape", "Experiments", "Follow")]
    resize(page, 1280, 720)
    assert len({tab["y"] for tab in tabs}) == 1 and tabs[-1]["x"] + tabs[-1]["width"] <= width


def test_a_window_with_more_room_has_larger_drawings(page):
    wide = lambda: page.locator(FOUR_IMAGES).first.bounding_box()["width"]
    for size, least, most in (((1920, 1080), 660, 720), ((2560, 1440), 900, 960), ((1280, 720), 430, 470)):
        resize(page, *size)
        wait(page, lambda least=least, most=most: least < wide() < most)
        assert_seen(page, METRICS)
        assert_seen(page, f"svg:has({LEVELS})")


def test_a_small_window_offers_the_lab_in_the_same_state(page):
    resize(page, 820, 1180)
    page.evaluate("document.documentElement.classList.remove('vi-anyway')")
    link = page.get_by_role("link", name="Open the lab")
    wait(page, link.is_visible)
    assert "demo=45%2C-90" in link.get_attribute("href") or "demo=45,-90" in link.get_attribute("href")
    page.get_by_role("button", name="Open the instrument anyway").click()
    wait(page, lambda: not link.is_visible())
    resize(page, 1280, 720)


def test_the_views_of_a_small_window_can_be_chosen_by_keys(page):
    resize(page, 390, 844)
    show(page, "images")
    page.locator("#vi-view-images").focus()
    page.keyboard.press("ArrowRight")
    assert page.locator("#vi-view-landscape").is_checked()
    assert_seen(page, f"svg:has({LEVELS})")


def test_a_window_that_grows_and_shrinks_is_laid_out_anew(page):
    resize(page, 1920, 1080)
    assert_seen(page, f"svg:has({LEVELS})")
    resize(page, 1280, 720)
    assert_seen(page, f"svg:has({LEVELS})")
    assert canvas_colours(page) > 1000


def test_links_lie_over_whole_frames_where_their_points_are(page):
    resize(page, 1280, 720)
    fold(page, "Display")
    switch(page, "Whole frames")
    wait_for_count(page, ".vi-four .vi-whole", 2, exactly=True)
    for size in ((1024, 620), (1280, 720), (1920, 1080), (853, 480), (390, 844), (360, 640)):
        resize(page, *size)
        show(page, "images")
        wait(page, lambda: max(page.evaluate(APART)) < 0.5, 10)
