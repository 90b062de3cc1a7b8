"""The tour in a real browser: by keyboard alone, by a finger alone, and left at once. Offered once."""

import re

import pytest
from browsing import CARD, PATIENCE_MS, STATUS, open_page, press, wait, wait_for_count, wait_until_complete
from viewimit.app.lessons.source import shipped

pytestmark = pytest.mark.browser

INPUTS = "[...document.querySelectorAll('input')].map(input => [input.value, input.checked])"
KEYS_AT_ONCE = """keys => {
  for (const key of keys) document.body.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
}"""
GUIDE, OFFER, MAIN = ".vi-guide", ".vi-offer", ".vi-guide a:has(.vi-guide-main)"
OWN_FIGURES_ARE_HIDDEN = (
    "[...document.querySelectorAll('.vi-metrics,.vi-images,.vi-images .vi-ask')]"
    ".every(one => getComputedStyle(one).visibility === 'hidden')"
)
PHONE = {"width": 390, "height": 844}
LOOK_MS = 25


def screen(page):
    return page.get_attribute(GUIDE, "data-screen")


def wait_until_true(page, condition, arg):
    """Looked at often: Playwright's own waits look each half second after a while, or as often as the page is drawn."""
    page.wait_for_function(condition, arg=arg, timeout=PATIENCE_MS, polling=LOOK_MS)


def wait_for(page, selector):
    wait_until_true(page, "selector => document.querySelector(selector)", selector)


def wait_for_another(page, before):
    """Until another screen is shown, or none."""
    wait_until_true(page, "before => document.querySelector('.vi-guide')?.dataset.screen !== before", before)


def tab_to(page, selector):
    """By the keyboard, as far as it goes."""
    for _ in range(40):
        page.keyboard.press("Tab")
        if page.evaluate("selector => document.activeElement.matches(selector)", selector):
            return
    raise AssertionError(f"Tab does not come to {selector}")


class Keys:
    """Of a person without a pointer."""

    begin = staticmethod(lambda page: page.keyboard.press("Enter"))
    go = staticmethod(lambda page: page.keyboard.press("Enter"))

    @staticmethod
    def choose(page):
        page.keyboard.press("1")

    @staticmethod
    def mark(page):
        tab_to(page, "[data-place]")
        page.keyboard.press("ArrowLeft")

    @staticmethod
    def turn(page, k):
        """To the middle of its range."""
        tab_to(page, f"#vi-guide-slider-{k}")
        for key in ("Home", *["PageUp"] * 5):
            page.keyboard.press(key)


class Finger:
    """Of a person with a phone."""

    begin = staticmethod(lambda page: page.locator(f"{OFFER} a").first.tap())
    go = staticmethod(lambda page: page.locator(MAIN).tap())

    @staticmethod
    def choose(page):
        page.locator(".vi-options a").first.tap()

    @staticmethod
    def mark(page):
        page.locator("[data-place] svg").tap(position={"x": 40, "y": 60})

    @staticmethod
    def turn(page, k):
        page.locator(f"#vi-guide-slider-{k}").tap()


def answer(page, hand):
    """What the screen asks for, and show what is true."""
    if page.locator(".vi-fields a").count():
        page.evaluate(KEYS_AT_ONCE, ["1", "5"])
        wait_for(page, MAIN)
    elif page.locator(".vi-options a").count():
        hand.choose(page)
        wait_for(page, ".vi-options a[aria-pressed=true]")
    elif page.locator("[data-place]").count():
        hand.mark(page)
        wait_for(page, MAIN)
    elif page.locator("#vi-guide-slider-1").count() and not page.locator(".vi-meter,.vi-guide-say").count():
        for k in (0, 1):
            hand.turn(page, k)
        wait_for(page, MAIN)
    elif page.locator(".vi-meter").count():
        for k in (0, 1):
            spoken = page.get_attribute(GUIDE, "data-spoken")
            hand.turn(page, k)
            wait_until_true(page, "before => document.querySelector('.vi-guide').dataset.spoken !== before", spoken)
        wait_for(page, ".vi-guide-say")
    if re.fullmatch(r"(before|after) \d|end", screen(page)) is None and not page.locator(".vi-guide-say").count():
        hand.go(page)
        wait_for(page, ".vi-guide-say")


def walk(page, hand):
    """From the offer to the end. The screens that were seen."""
    wait_for(page, OFFER)
    hand.begin(page)
    return walk_on(page, hand)


def walk_on(page, hand):
    """To the end. The screens that were seen."""
    wait_for(page, GUIDE)
    seen = []
    while page.locator(GUIDE).count():
        seen.append(screen(page))
        answer(page, hand)
        assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth"), seen[-1]
        assert page.evaluate(OWN_FIGURES_ARE_HIDDEN), seen[-1]
        hand.go(page)
        wait_for_another(page, seen[-1])
    return seen


TOUR = [
    *("before 0", "before 1", "before 2"),
    *("eyes", "line", "crossing", "arrows", "number", "servo", "bowl", "feel"),
    *("after 0", "after 1", "after 2", "end"),
]


def test_the_tour_by_keyboard_alone(browser, server):
    page = open_page(browser, server, "small")
    at_first = page.evaluate(INPUTS)
    assert walk(page, Keys) == TOUR
    wait_for_count(page, OFFER, 0, exactly=True)
    assert page.evaluate(INPUTS) == at_first
    page.close()
    assert page.problems == []


def test_the_tour_by_a_finger_alone(browser, server):
    page = open_page(browser, server, "small", has_touch=True, reduced_motion="reduce")
    page.set_viewport_size(PHONE)
    wait_for(page, OFFER)
    offer = page.locator(OFFER).bounding_box()
    assert offer["x"] >= 0 and offer["x"] + offer["width"] <= PHONE["width"]
    assert walk(page, Finger) == TOUR
    page.close()
    assert page.problems == []


OTHERS = [
    name if name == "design" else pytest.param(name, marks=pytest.mark.slow) for name in shipped() if name != "tour"
]


@pytest.mark.parametrize("name", OTHERS)
def test_every_other_lesson_by_keyboard_on_a_phone(browser, server, name):
    page = open_page(browser, server, "small", reduced_motion="reduce")
    page.set_viewport_size(PHONE)
    press(page, "Escape")
    page.evaluate("document.getElementById('vi-view-controls').click()")
    page.locator(f'.vi-lessons a[href$="begin,{name}"]').click()
    wait_for(page, GUIDE)
    page.get_by_text("History", exact=True).wait_for(state="hidden")  # the controls lie over no lesson
    assert walk_on(page, Keys) == [step.id for step in shipped()[name].step]
    page.close()
    assert page.problems == []


def test_a_lesson_is_shown_to_a_class_and_sent_to_it(browser, server):
    """By a remote alone: the lesson goes on without an answer; L shows a link that opens its step elsewhere."""
    page = open_page(browser, f"{server}?present", "small")
    wait_for(page, ".vi-presents .vi-pointer")
    truth = page.locator(".vi-truth")
    assert not truth.is_visible()
    page.keyboard.press("t")
    assert truth.is_visible()
    page.keyboard.press("Enter")  # it is offered
    for key, shown in [*[("PageDown", f"before {k}") for k in range(3)], ("ArrowRight", "eyes")]:
        wait_for(page, f'[data-screen="{shown}"]')
        page.keyboard.press(key)
    wait_for(page, ".vi-guide-say")
    page.keyboard.press("PageDown")
    wait_for(page, '[data-screen="line"]')
    page.keyboard.press("PageUp")
    wait_for(page, '[data-screen="eyes"]')
    assert page.evaluate("getComputedStyle(document.querySelector('.vi-guide-card')).zoom") == "1.5"
    page.keyboard.press("l")
    wait_for(page, ".vi-share pre")
    link = page.text_content(".vi-share pre")
    page.keyboard.press("Escape")
    wait_for_count(page, ".vi-share", 0, exactly=True)
    assert screen(page) == "eyes"
    page.keyboard.press("p")
    wait_for_count(page, ".vi-presents", 0, exactly=True)
    wait(page, lambda: page.locator(".vi-guide-refused").count() or page.keyboard.press(" "))  # a key of the page's
    page.goto(link)
    wait_for(page, '[data-screen="eyes"]')
    assert page.url.rstrip("/") == server.rstrip("/")
    page.close()
    assert page.problems == []


def assert_the_offer_covers_nothing(page):
    """Neither what is said, in as many lines as the strip may have, nor the curves."""
    for size in ((1280, 720), (1024, 640), (1920, 1080), (2560, 1440)):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        wait_for_count(page, CARD, int(size[0] > 1600), exactly=True)
        page.evaluate("where => { document.querySelector(where).textContent = 'so many words '.repeat(40); }", STATUS)
        beneath = page.locator(CARD) if size[0] > 1600 else page.locator(STATUS).locator("..").locator("..")
        bottom = lambda: sum(page.locator(OFFER).bounding_box()[side] for side in ("y", "height"))
        wait(page, lambda beneath=beneath, bottom=bottom: bottom() <= beneath.first.bounding_box()["y"], 10)
        offer, scene = page.locator(OFFER).bounding_box(), page.locator("canvas[data-engine]").bounding_box()
        assert scene["x"] <= offer["x"] and offer["x"] + offer["width"] <= scene["x"] + scene["width"]
    page.set_viewport_size({"width": 768, "height": 1024})
    wait_for_count(page, CARD, 0, exactly=True)
    page.locator(OFFER).get_by_text("Not now").click(trial=True)  # nothing covers it either
    begin, no = (page.locator(f"{OFFER} a").nth(k).bounding_box() for k in (0, 1))
    words = page.locator(f"{OFFER} > span").bounding_box()
    assert begin["y"] == no["y"] < words["y"] + words["height"] and begin["x"] > words["x"] + words["width"]
    page.set_viewport_size({"width": 1280, "height": 720})


def test_the_offer_covers_nothing_escape_leaves_and_what_is_offered_is_offered_once(browser, server):
    page = open_page(browser, server, "small")
    wait_for(page, OFFER)
    at_first = page.evaluate(INPUTS)
    assert_the_offer_covers_nothing(page)
    press(page, "Escape")
    wait_for_count(page, OFFER, 0, exactly=True)
    page.reload()
    wait_until_complete(page)
    assert page.locator(".vi-lessons a").count() and not page.locator(OFFER).count()
    page.locator(".vi-lessons a").first.click()
    wait_for(page, GUIDE)
    page.wait_for_function("document.activeElement.matches('.vi-guide h2')")  # what a reader begins with
    page.keyboard.press("2")
    wait_for(page, ".vi-options a[aria-pressed=true]")
    page.wait_for_function("document.activeElement.matches('.vi-guide a:has(.vi-guide-main)')")
    page.keyboard.press("Escape")
    wait_for_count(page, GUIDE, 0, exactly=True)
    assert page.evaluate(INPUTS) == at_first
    page.close()
    assert page.problems == []
