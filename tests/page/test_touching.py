"""What is drawn is touched in a real browser, with mouse and keys, at several sizes and pixel ratios."""

import contextlib

import pytest
from browsing import (
    CHOSEN_POINT,
    CURVES,
    FOUR_IMAGES,
    choose,
    chosen_point,
    open_page,
    posture,
    press,
    set_number,
    status,
    switch,
    wait,
    wait_for_status,
)

pytestmark = pytest.mark.browser
ANSWER_S = 15.0  # after which a click has met no point
SIZES = (1024, 720), (1280, 720), (1500, 900)


@pytest.fixture(scope="module")
def page(browser, server):
    page = open_page(browser, server, "small", device_scale_factor=1.2)
    yield page
    page.close()
    assert page.problems == []


def middle(page, mark) -> tuple[float, float]:
    page.locator(mark).first.scroll_into_view_if_needed()
    box = page.locator(mark).first.bounding_box()
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def touch(page, mark) -> None:
    """Click where a mark is, whatever lies there."""
    page.mouse.click(*middle(page, mark))


def wait_for_chosen(page, point) -> None:
    """Until the drawing's rings stand around this point in all four images, or are nowhere."""
    rings = 0 if point is None else 4
    said = "" if point is None else f"Point {point}: its"
    images = page.locator(FOUR_IMAGES)
    wait(page, lambda: page.locator(CHOSEN_POINT).count() == rings and said in images.text_content())


def choose_in_motion(page, view, point, tries=5) -> None:
    """Click where a point is: again, when the arm has taken it away between the look and the click."""
    for _ in range(tries):
        before = chosen_point(page)
        touch(page, f".vi-at-{view}{point} .vi-nearest")
        with contextlib.suppress(AssertionError):
            wait(page, lambda before=before: chosen_point(page) != before, ANSWER_S)
        if chosen_point(page) == f"{point}":
            break
    wait_for_chosen(page, point)


def test_a_click_on_a_point_of_any_image_chooses_it(page):
    for view, point in zip("LRlr", (7, 3, 8, 5)):
        touch(page, f".vi-at-{view}{point} .vi-nearest")
        wait_for_chosen(page, point)
    touch(page, ".vi-at-r5 .vi-nearest")
    wait_for_chosen(page, None)


def test_tab_reaches_the_points_and_enter_chooses_one_without_losing_the_place(page):
    page.get_by_role("link", name="point 3").focus()
    press(page, "Tab")
    for point in (4, None):
        press(page, "Enter")
        wait_for_chosen(page, point)
        assert page.evaluate("document.activeElement.getAttribute('aria-label')") == "point 4"


def test_a_click_on_the_landscape_is_exact_at_every_size(page):
    for size, angles in zip(SIZES, ([70, -140], [20, -35], [90, 0])):
        page.set_viewport_size(dict(zip(("width", "height"), size)))
        touch(page, f"a[data-do='posture/{angles[0]},{angles[1]}'] path")
        wait(page, lambda angles=angles: posture(page) == angles)
    page.set_viewport_size({"width": 1280, "height": 720})


def test_a_look_moves_nothing_until_the_learner_starts_there(page):
    start = posture(page)
    switch(page, "Preview the posture")
    touch(page, "a[data-do='posture/45,-60'] path")
    wait_for_status(page, r"Ghost arm · At \(45\.0°, −60\.0°\) E would be [\d.]+ px²\. The arm has not moved\.")
    assert posture(page) == start
    press(page, "Escape")
    wait(page, lambda: "Ghost arm" not in status(page))
    page.get_by_role("link", name="θ₂ 45°, θ₄ −45°").press("Enter")
    wait_for_status(page, "Ghost arm")
    page.get_by_role("link", name="Start here").click()
    wait(page, lambda: posture(page) == [45, -45])
    switch(page, "Preview the posture")


def test_a_click_on_a_moment_of_the_curves_goes_there_also_while_the_arm_moves(page):
    start = posture(page)
    press(page, "Space")
    wait_for_status(page, "At rest")
    if page.get_by_role("tab", name="Curves").count():  # else they stand over the scene
        page.get_by_role("tab", name="Curves").click()
    touch(page, "a[data-do='moment/0'] path")
    wait(page, lambda: posture(page) == start)
    press(page, "Space")
    wait(page, lambda: posture(page) != start)
    choose_in_motion(page, "L", 7)  # which is redrawn all the time
    press(page, "Space")
    pressed = page.locator("a[data-do='moment/0']").first.element_handle()
    page.mouse.move(*middle(page, "a[data-do='moment/0'] path"))
    page.mouse.down()
    curve = page.locator(CURVES).first.element_handle()
    page.keyboard.press("ArrowLeft")
    wait(page, lambda: not curve.evaluate("curve => curve.isConnected"))  # drawn anew under the pointer
    page.mouse.up()
    wait(page, lambda: posture(page) == start)
    assert pressed.evaluate("link => link.isConnected")


def test_a_changed_preset_says_so_is_restored_by_choosing_it_and_brought_back_by_undo(page):
    shown = lambda: page.get_by_label("Preset", exact=True).first.input_value()
    preset = shown().removeprefix("(modified) ")
    set_number(page, "θ₂", 60)
    wait(page, lambda: shown() == f"(modified) {preset}")
    choose(page, "Preset", preset)
    wait(page, lambda: shown() == preset)
    wait_for_status(page, "Ready")
    press(page, "ArrowLeft")
    wait_for_status(page, "Back is what was here before")
    wait(page, lambda: shown() == f"(modified) {preset}")
