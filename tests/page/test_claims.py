"""In a browser: the strip that says apart claim and truth, and the glossary's cards. One page for all."""

import re

import pytest
from browsing import (
    FOUR_IMAGES,
    choose,
    open_page,
    pause,
    press,
    uncovered_row,
    wait,
    wait_for_count,
    wait_for_status,
)

pytestmark = pytest.mark.browser
STRIP, TRUTH, CARD = ".vi-strip", ".vi-truth p", ".vi-word:popover-open"
ASKED = "document.activeElement.getAttribute('popovertarget')"


@pytest.fixture(scope="module")
def page(browser, server):
    page = open_page(browser, server, "small")
    choose(page, "Speed", "all it can")
    yield page
    page.close()
    assert page.problems == []


def test_a_learner_that_cannot_tell_a_joint_does_not_say_that_it_arrived(page):
    choose(page, "Preset", "Five points")
    choose(page, "Speed", "all it can")
    press(page, "Space")
    said = wait_for_status(page, "At rest, without proof")
    assert "Arrived" not in said and "px of noise would shift" in said
    wait(page, lambda: re.match(r"19\.\d° off: θ₂ is at 25\.\d° but should be at 45\.0°", page.text_content(TRUTH)))
    strip, canvas = page.locator(STRIP).bounding_box(), page.locator("canvas").first.bounding_box()
    assert strip["height"] <= 84 and strip["y"] + strip["height"] <= 720
    assert canvas["x"] <= strip["x"] and strip["x"] + strip["width"] <= canvas["x"] + canvas["width"]
    press(page, "Space")


HEADINGS = ("own_views", "demo_views")  # of the images, at the top of the window: their cards open below them


def opened(page, key):
    """The card, above its "?", of which it leaves the number free."""
    page.locator(f".vi-ask[popovertarget=vi-word-{key}]").click()
    wait_for_count(page, CARD, 1, exactly=True)
    card = page.locator(CARD)
    asks = page.locator(f".vi-ask[popovertarget=vi-word-{key}]")
    # none while the figures are drawn anew
    ask, box = wait(page, lambda: all(boxes := (asks.bounding_box(), card.bounding_box())) and boxes)
    above, below = box["y"] + box["height"] <= ask["y"], ask["y"] + ask["height"] <= box["y"]
    assert below if key in HEADINGS else above
    assert box["y"] >= 0 and box["y"] + box["height"] <= 720
    assert box["x"] >= 0 and box["x"] + box["width"] <= 1280
    return card


@pytest.mark.parametrize("key", ["E", "largest_e", "points_seen", "own_views", "demo_views", "cost", "servo", "truth"])
def test_every_number_explains_itself(page, key):
    if key == "points_seen":  # of which some are not seen: else it is no number of the page
        choose(page, "Preset", "Points that get lost")
    if key == "servo":
        uncovered_row(page, "Servo")
    card = opened(page, key)
    assert len(card.text_content()) > 60
    page.keyboard.press("Escape")
    wait_for_count(page, CARD, 0, exactly=True)


def step(page):
    before = page.locator(FOUR_IMAGES).text_content()
    press(page, "ArrowRight")
    wait(page, lambda: page.locator(FOUR_IMAGES).text_content() != before)
    pause(page)


def come_by_keys(page, key):
    """To its "?": what keys come to keeps the focus when it is drawn anew."""
    page.keyboard.press("Tab")
    page.locator(f".vi-ask[popovertarget=vi-word-{key}]").focus()


def test_a_card_stays_open_while_the_numbers_change(page):
    choose(page, "Preset", "The paper's experiment")
    wait_for_status(page, "Ready")  # the images were drawn anew
    place = opened(page, "condition").bounding_box()
    step(page)
    assert page.locator(CARD).bounding_box() == place
    page.locator(f"{CARD} .vi-close").click()
    wait_for_count(page, CARD, 0, exactly=True)


def test_the_pages_keys_act_after_a_question_by_pointer_and_beside_one_by_keys(page):
    opened(page, "cost")
    press(page, "Escape")
    for asked in (None, "vi-word-E"):
        assert page.evaluate(ASKED) == asked  # None: the pointer has left it
        step(page)
        come_by_keys(page, "E")
    press(page, " ")  # on a question it asks
    wait_for_count(page, CARD, 1, exactly=True)
    press(page, " ")
    wait_for_count(page, CARD, 0, exactly=True)
    wait_for_status(page, "^Paused")


def test_a_question_is_reached_and_asked_by_keys(page):
    come_by_keys(page, "E")
    page.keyboard.press("Tab")
    assert page.evaluate(ASKED) == "vi-word-mean_e"
    page.keyboard.press("Enter")
    wait_for_count(page, CARD, 1, exactly=True)
    page.keyboard.press("Escape")
    wait_for_count(page, CARD, 0, exactly=True)


def test_a_question_keeps_the_focus_while_the_numbers_are_drawn_anew_unless_it_was_left(page):
    press(page, "r")
    wait_for_status(page, "Ready")
    come_by_keys(page, "E")
    for _ in range(2):
        step(page)
        assert page.evaluate(ASKED) == "vi-word-E"
    page.evaluate("document.activeElement.blur()")
    step(page)
    assert page.evaluate(ASKED) is None
