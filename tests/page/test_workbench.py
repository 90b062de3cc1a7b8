"""The Workbench in a real browser: one walk with the mouse, one with keys. Software rendering: all waits patiently."""

import io
import json
import re
import zipfile
from pathlib import Path
from urllib.parse import urlparse

import numpy as np
import pytest
from browsing import (
    CHOSEN_POINT,
    DUEL,
    EXPERIMENT,
    HELP,
    IMAGE_L,
    LESSON,
    MOTION,
    PATIENCE_S,
    VERDICT_ROW,
    VIEW_NAME,
    canvas_colours,
    choose,
    chosen_point,
    click,
    demonstrator,
    downloaded,
    fold,
    open_page,
    pause,
    points_drawn,
    posture,
    press,
    progress,
    row,
    set_number,
    status,
    wait,
    wait_for_count,
    wait_for_progress,
    wait_for_status,
    wait_for_text,
)
from viewimit.app.model.choices import PRESETS

pytestmark = pytest.mark.browser
TABS = ("Curves", "Equations", "Duel", "Experiments", "Follow", "Landscape")
FOLDERS = ("Start", "Method", "Disturbances", "Actuator errors, random seed", "Points", "Display", "Save")
EXPERIMENT_S = 2 * PATIENCE_S  # of a process that lets all others go first
PLACE = """name => {
  const {camera, canvas, nodeRefFromName} = window.__viserMutable, box = canvas.getBoundingClientRect()
  const place = nodeRefFromName[name].getWorldPosition(camera.position.clone()).project(camera)
  return [box.left + box.width * (1 + place.x) / 2, box.top + box.height * (1 - place.y) / 2] }"""
ELBOW = "/panda/demonstrator/j1/j2/j3/j4"
# What answers a pointer, and is neither a control that keys reach, nor in one, nor the same as one that they reach
OUT_OF_REACH = """
() => [...document.querySelectorAll("body *:not(canvas)")].filter(e => {
  const style = getComputedStyle(e);
  if (!e.getClientRects().length || style.visibility != "visible" || style.cursor != "pointer") return false;
  const control = e.closest("a,button,input,label,select,textarea,[role]:not([role=group]),[tabindex]");
  return !control || (control.tabIndex < 0 && !control.matches("label,[aria-hidden=true],[role=option]")
    && !control.querySelector("[tabindex='0']"));
}).map(e => e.outerHTML.slice(0, 200))
"""


@pytest.fixture(scope="module")
def page(browser, server):
    page = open_page(browser, server, "small", device_scale_factor=1.2)
    yield page
    page.close()
    assert page.problems == []


def shares(page, selector: str, across: float, up: float) -> None:
    """Click at a share of the width and of the height of what is met first."""
    box = page.locator(selector).first.bounding_box()
    page.mouse.click(box["x"] + across * box["width"], box["y"] + (1 - up) * box["height"])


def begin(page, *names: str) -> None:
    """Let go of what others have left, and begin with these presets one after the other, the last to stay."""
    press(page, "Escape")
    for name in names or ("Beyond the paper", "The paper's experiment"):  # to choose what is chosen changes nothing
        choose(page, "Preset", name)
        says = next(preset.says for preset in PRESETS if preset.name == name)
        wait(page, lambda says=says: page.text_content(LESSON) == says)
    wait_for_status(page, "Ready")


def look_in_3d(page) -> None:
    """A busy machine is slow, so that the page has put a still picture there."""
    page.evaluate("act('flat', 0)")
    wait_for_count(page, ".vi-flat", 0, exactly=True)


class TestWithTheMouse:
    def test_a_new_visitor_sees_everything_and_nothing_leaves_the_machine(self, page):
        assert "Ready" in status(page) and posture(page) == [25, -25] and chosen_point(page)
        assert canvas_colours(page) > 1000
        assert sorted(page.locator(VIEW_NAME).all_text_contents()) == sorted("lrLR")
        assert set(page.get_by_role("tab").all_inner_texts()) >= set(TABS[1:])
        hosts = {urlparse(url).hostname for url in page.requested if not url.startswith(("data:", "blob:"))}
        assert hosts == {"127.0.0.1"}
        page.get_by_role("button", name="Not now").click()

    def test_points_of_the_images_are_chosen_by_a_click_and_images_enlarged(self, page):
        for view, point in zip("Lr", (7, 5)):
            shares(page, f".vi-at-{view}{point} .vi-nearest", 0.5, 0.5)
            wait(page, lambda point=point: chosen_point(page) == f"{point}" and page.locator(CHOSEN_POINT).count() == 4)
        width = lambda: (page.locator(IMAGE_L).first.bounding_box() or {"width": 0.0})["width"]
        usual = width()
        page.get_by_role("link", name="Pictures, large or not").click()
        wait(page, lambda: width() > 1.3 * usual)
        press(page, "Escape")
        wait(page, lambda: width() == usual)

    def test_a_click_on_landscape_and_curves_is_exact(self, page):
        def is_placed():  # what was large may still be going back
            shares(page, "rect[data-field=posture]", 0.75, 0.5)
            pause(page)
            return np.abs(np.array(posture(page)) - [45, -45]).max() < 1

        wait(page, is_placed)
        start = posture(page)
        click(page, "Play")
        wait_for_status(page, "At rest")
        assert np.abs(np.array(posture(page)) - [45, -90]).max() < 2
        page.get_by_role("tab", name="Curves").click()
        shares(page, "rect[data-field=moment]", 0.01, 0.5)
        wait(page, lambda: posture(page) == start)
        click(page, "Step")
        wait(page, lambda: posture(page) != start)
        click(page, "Undo")
        wait(page, lambda: posture(page) == start)
        page.get_by_role("tab", name="Landscape").click()

    def test_presets_methods_disturbances_and_joints_act_at_once(self, page):
        shown = lambda: page.get_by_label("Preset", exact=True).first.input_value()
        begin(page, "Beyond the paper")
        set_number(page, "θ₂", 60)
        wait_for_text(page, "demonstrator (60°")
        choose(page, "Servo", "Broyden on pictures")
        set_number(page, "Pixel noise (px)", 0.5)
        wait(page, lambda: shown() == "(modified) Beyond the paper")
        choose(page, "Joints", "all seven")
        wait(page, lambda: len(posture(page)) == 7 and points_drawn(page) == [16, 16])
        begin(page)
        wait(page, lambda: posture(page) == [25, -25] and points_drawn(page) == [10, 10])
        set_number(page, "Pictures averaged", 1)
        set_number(page, "Points lost (%)", 50)
        wait_for_status(page, "Too few points")

    def test_points_are_placed_proposed_and_taken_back(self, page):
        begin(page)
        look_in_3d(page)
        fold(page, "Points")
        click(page, "Edit points")
        wait_for_status(page, r"Editing points · 10 points; noise of 1 px: θ₂ [\d.]+°")
        page.mouse.click(*page.evaluate(PLACE, ELBOW))
        wait_for_status(page, "11 points")
        press(page, "b")
        wait_for_status(page, "The hollow point would help most: noise of 1 px: ")
        wait_for_count(page, "circle.vi-proposed", 4, exactly=True)
        press(page, "b")
        wait_for_status(page, "12 points")
        press(page, "ArrowLeft")
        wait_for_status(page, "Back is what was here before.* 11 points")

    def test_two_methods_race(self, page):
        begin(page)
        page.get_by_role("tab", name="Duel").click()
        choose(page, "Opponent's transfer", "Rank 3, all views")
        choose(page, "Opponent's servo", "Broyden on pictures")
        click(page, "Begin duel")
        said = lambda: "".join(page.locator(DUEL).all_text_contents())
        wait(page, lambda: re.search(r"was first within 1°, after \d+ steps", said()))
        click(page, "End duel")
        wait(page, lambda: "which method arrives first?" in said())

    def test_an_experiment_is_cancelled_another_judged_and_downloaded(self, page):
        page.get_by_role("tab", name="Experiments").click()
        choose(page, "Experiment", "Fig. 9: posture imitation")
        click(page, "Run")
        wait_for_progress(page, r"[1-9]\d? %", EXPERIMENT_S)
        click(page, "Cancel")
        wait_for_progress(page, r"cancelled at \d+ %")
        choose(page, "Experiment", "Fig. 10: trajectory imitation")
        click(page, "Run")
        wait(page, lambda: "done" in progress(page), EXPERIMENT_S)
        rows = page.locator(VERDICT_ROW).all_text_contents()
        assert len(rows) == 14 and any(text.endswith("pass") for text in rows), rows
        name, data = downloaded(page, "Download figure and data")
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            assert name == "viewimit-fig10.zip" and {"fig10.npz", "fig10.json"} <= set(archive.namelist())
        assert page.locator(EXPERIMENT).count() == 1

    def test_a_motion_is_recorded_replayed_saved_and_loaded(self, page, tmp_path):
        begin(page)
        page.get_by_role("tab", name="Follow").click()
        click(page, "Record")
        for angle in (50, 65):
            set_number(page, "θ₂", angle)
            page.wait_for_timeout(600)  # so that the replay shows each for long enough
        click(page, "Stop")
        wait(page, lambda: "recorded: " in page.text_content(MOTION))
        set_number(page, "θ₂", 30)  # so that 65° is where the motion has led it
        wait(page, lambda: demonstrator(page) == 30)
        click(page, "Move the demonstrator")
        wait(page, lambda: demonstrator(page) == 65 and "Moving the demonstrator" not in status(page))
        set_number(page, "Time (s)", 0)
        wait(page, lambda: demonstrator(page) == 45)
        with page.expect_download() as download:
            page.get_by_role("button", name="Save", exact=True).last.click()  # below the folder of that name
        saved = json.loads(Path(download.value.path()).read_bytes())
        assert saved["theta_deg"][0] == [45, -90] and saved["theta_deg"][-1] == [65, -90]
        (tmp_path / "wave.json").write_text(json.dumps({**saved, "name": "<b>wave</b>"}))
        page.locator("input[type=file]").set_input_files(tmp_path / "wave.json")
        wait(page, lambda: "<b>wave</b>: " in page.text_content(MOTION))


class TestWithKeys:
    def test_every_control_is_reached_has_a_name_and_can_be_read(self, page, violations):
        press(page, "r")
        for name in FOLDERS:
            folder = page.get_by_role("button", name=re.compile(f"^{name}(: .*)?$")).first
            if folder.get_attribute("aria-expanded") != "true":
                folder.press("Enter")
                wait(page, lambda folder=folder: folder.get_attribute("aria-expanded") == "true")
        for k, tab in enumerate(TABS):
            page.get_by_role("tab", name=tab, exact=True).click()
            scheme = "light" if k % 2 else "dark"
            page.emulate_media(color_scheme=scheme)
            page.wait_for_selector(f":root[data-mantine-color-scheme={scheme}]")
            assert page.evaluate(OUT_OF_REACH) == [], tab
            assert violations(page) == [], (tab, scheme)

    def test_keys_play_step_and_go_back_and_arrows_are_the_sliders_that_has_the_focus(self, page):
        page.evaluate("document.activeElement.blur()")
        begin(page)
        press(page, "ArrowRight")
        wait(page, lambda: posture(page) == [40, -25])  # the first probe: joint 2 by 15°
        press(page, "ArrowLeft")
        wait(page, lambda: posture(page) == [25, -25])
        noise = row(page, "Pixel noise (px)").locator("[role=slider]")
        noise.press("ArrowRight")
        wait(page, lambda: float(noise.get_attribute("aria-valuenow")) > 0)
        noise.press("ArrowLeft")
        wait(page, lambda: float(noise.get_attribute("aria-valuenow")) == 0)
        assert posture(page) == [25, -25]
        page.evaluate("document.activeElement.blur()")
        press(page, "Space")
        wait_for_status(page, "At rest")
        press(page, "Space")

    def test_points_help_link_and_questions_open_and_close_by_keys(self, page):
        before = chosen_point(page)
        press(page, "n")
        wait(page, lambda: chosen_point(page) != before)
        page.get_by_role("link", name="point 3").focus()
        press(page, "Enter")
        wait(page, lambda: chosen_point(page) == "3")
        page.evaluate("document.activeElement.blur()")
        for key, opened in (("h", HELP), ("l", ".vi-share pre")):
            press(page, key)
            page.wait_for_selector(opened)
            press(page, "Escape")
            wait_for_count(page, opened, 0, exactly=True)
        page.locator(".vi-ask[popovertarget=vi-word-E]").focus()
        press(page, "Enter")
        wait_for_count(page, ".vi-word:popover-open", 1, exactly=True)
        press(page, "Escape")
        wait_for_count(page, ".vi-word:popover-open", 0, exactly=True)

    def test_a_number_box_without_a_number_shows_its_value_again_and_says_its_range(self, page):
        box = page.get_by_label("Elbow θ₄, −180 … 0", exact=True)
        before = box.input_value()
        box.fill("-")
        box.blur()
        wait(page, lambda: box.input_value() == before)
        box.fill("7")
        assert box.evaluate("e => e.validationMessage") == "From −180 to 0"
        box.blur()

    def test_before_a_class_what_gives_the_answer_away_is_hidden_until_t(self, page):
        truth = page.locator(".vi-truth")
        assert truth.is_visible()
        press(page, "p")
        wait(page, lambda: not truth.is_visible())
        assert (
            page.locator("[role=status]").is_visible()
            and not page.get_by_role("button", name="Play", exact=True).is_visible()
        )
        press(page, "t")
        wait(page, truth.is_visible)
        press(page, "p")
        wait(page, page.get_by_role("button", name="Play", exact=True).is_visible)
