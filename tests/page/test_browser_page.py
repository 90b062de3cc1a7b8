"""The page in a real browser: what a visitor sees and does. Software rendering, so everything waits patiently."""

import io
import json
import re
import zipfile
from pathlib import Path
from urllib.parse import urlparse

import numpy as np
import pytest
from browsing import (
    ALL_TRANSFERS,
    CHOSEN_POINT,
    CONFLICT,
    DUEL,
    EPIPOLAR_LINE,
    EXPERIMENT,
    HELP,
    HOW,
    IMAGE_L,
    LESSON,
    LEVELS,
    MOTION,
    PATIENCE_MS,
    PATIENCE_S,
    PROGRESS,
    SIZES,
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
    points_drawn,
    posture,
    press,
    progress,
    row,
    set_number,
    stands,
    status,
    still,
    switch,
    wait,
    wait_for_count,
    wait_for_progress,
    wait_for_status,
    wait_for_text,
    wait_until_complete,
)
from viewimit.app.model.choices import PRESETS, servo_names, transfer_names

from viewimit.loop import link
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.simulated_robot import complete

pytestmark = pytest.mark.browser
EXPERIMENT_S = 2 * PATIENCE_S  # of a process that lets all others go first


FITS = "e => e.scrollWidth <= e.clientWidth && e.clientWidth > 0.9 * e.closest('[data-dock-region]').clientWidth"
INPUTS = "[...document.querySelectorAll('input')].map(input => [input.value, input.checked])"


@pytest.fixture(scope="module")
def used_page(browser, server):
    page = open_page(browser, server)
    page.at_first = page.evaluate(INPUTS)
    yield page
    page.close()
    assert page.problems == []


@pytest.fixture
def session(used_page):
    """A page on which others have been, with its session as at first. Who changes more than that puts it right."""
    press(used_page, "Escape")  # nothing is large
    if used_page.evaluate(INPUTS) != used_page.at_first:  # a browser shows at once what was put into it
        if row(used_page, "Preset").locator("input:visible").first.input_value() == PRESETS[0].name:
            choose(used_page, "Preset", PRESETS[1].name)  # to choose what is chosen changes nothing
        choose(used_page, "Preset", PRESETS[0].name)
    press(used_page, "r")
    used_page.get_by_role("tab", name="Landscape").click()
    wait(used_page, lambda: used_page.text_content(LESSON) == PRESETS[0].lesson)
    wait_for_status(used_page, "Ready")
    wait(used_page, lambda: posture(used_page) == [25, -25] and demonstrator(used_page) == 45)
    return used_page


def test_a_new_visitor_sees_everything(used_page):
    page = used_page  # by nobody yet: the others come after
    assert "Ready" in status(page)
    assert canvas_colours(page) > 1000
    names = page.locator(VIEW_NAME).all_text_contents()
    assert sorted(names) == sorted(["l", "r", "L", "R"])
    assert posture(page) == [25, -25]
    tabs = ["Landscape", "Curves", "Equations", "Duel", "Experiments", "Follow"]
    assert page.get_by_role("tab").all_inner_texts() == tabs
    assert page.get_by_text("Method: epipolar, Broyden", exact=True).is_visible()
    fold(page, "Method")
    assert row(page, "Transfer").locator("input:visible").first.input_value() == "Epipolar (paper)"
    fold(page, "Method")
    assert chosen_point(page)
    assert [page.locator(f"svg.vi-at-{view} {EPIPOLAR_LINE}").count() for view in "lrLR"] == [3, 3, 3, 3]
    assert page.locator(EPIPOLAR_LINE).count() == 14  # and in the sentence of the point one of l and one of r


def test_playing_converges_and_says_so(session):
    page = session
    press(page, "Space")
    text = wait_for_status(page, "At rest")
    assert "agree to 1.3 px" in text
    assert np.abs(np.array(posture(page)) - [45, -90]).max() < 2


def test_step_undo_reset_by_button_and_key(session):
    page = session
    start = posture(page)
    press(page, "ArrowRight")
    wait(page, lambda: posture(page) == [40, -25])  # the first probe: joint 2 by 15°
    press(page, "ArrowLeft")
    wait(page, lambda: posture(page) == start)
    page.get_by_text("Step", exact=True).click()
    wait(page, lambda: posture(page) == [40, -25])
    page.get_by_text("Step", exact=True).click()
    wait(page, lambda: posture(page) == [40, -10])
    page.get_by_text("Undo", exact=True).click()
    wait(page, lambda: posture(page) == [40, -25])
    press(page, "r")
    wait(page, lambda: posture(page) == start)
    wait_for_status(page, "Ready")
    set_number(page, "θ₂", 60)  # the landscape still follows
    wait_for_text(page, "demonstrator (60°")


def test_the_demonstrator_may_move_while_the_loop_runs(session):
    page = session
    press(page, "Space")
    wait_for_status(page, "At rest")
    set_number(page, "θ₂", 70)
    wait_for_text(page, "demonstrator (70°")
    wait(page, lambda: np.abs(np.array(posture(page)) - [70, -90]).max() < 5)
    wait_for_status(page, "At rest")


def test_every_preset_runs(session):
    page = session
    worlds = set()  # that were looked at in 3-D
    for preset in reversed([preset for preset in PRESETS if preset.settings.sensor == "projected"]):
        choose(page, "Preset", preset.name)
        wait(page, lambda preset=preset: page.text_content(LESSON) == preset.says)
        start = posture(page)
        press(page, "Space")
        wait(page, lambda start=start: posture(page) != start or "Too few points" in status(page))
        assert re.search(r"E is (< )?[\d.]+ px²|images show|there is no E", status(page)), preset.name
        press(page, "Space")  # one that rests costs a frame, not one after the other
        world = preset.settings.scene, preset.settings.joints
        if world not in worlds:
            worlds.add(world)
            assert canvas_colours(page) > 1000, preset.name


def test_every_method_can_be_chosen(session):
    page = session
    for name in transfer_names().values():
        choose(page, "Transfer", name)
    for name in servo_names().values():
        choose(page, "Servo", name)
        start = posture(page)
        press(page, "ArrowRight")
        wait(page, lambda start=start: posture(page) != start)
        assert "error" not in status(page).lower()


def test_too_few_points_hold_the_arm_still_and_say_so(session):
    page = session
    set_number(page, "Images averaged", 1)  # of 25, one or another shows each point
    set_number(page, "Points lost (%)", 50)
    wait_for_status(page, "Too few points · Five points are needed")
    before = posture(page)
    press(page, "ArrowRight")
    page.wait_for_timeout(700)
    assert posture(page) == before
    set_number(page, "Points lost (%)", 0)
    wait_for_status(page, "Ready|Moving|Paused")


def test_noise_and_seed_repeat(session):
    page = session

    def changed_E(label, value):
        before = page.text_content(CONFLICT)
        set_number(page, label, value)
        wait(page, lambda: page.text_content(CONFLICT) != before)
        return page.text_content(CONFLICT)

    noisy = changed_E("Pixel noise (px)", 0.5)
    fold(page, "Actuator errors, random seed")
    other = changed_E("Seed", 8)
    assert changed_E("Seed", 7) == noisy != other
    changed_E("Points misplaced (%)", 20)
    changed_E("Images averaged", 50)  # sets them aside, and averages the noise
    set_number(page, "Pixel noise (px)", 0)
    set_number(page, "Points misplaced (%)", 0)
    set_number(page, "Arm overshoot (%)", 20)
    press(page, "ArrowRight")
    wait(page, lambda: posture(page) == [43, -25])  # the first probe of 15°
    set_number(page, "Arm resolution (°)", 2)
    press(page, "ArrowRight")
    wait(page, lambda: posture(page)[1] == -8)
    fold(page, "Actuator errors, random seed")


def test_all_joints_can_be_freed_and_held_again(session):
    page = session
    choose(page, "Joints", "all seven")
    wait(page, lambda: len(posture(page)) == 7)
    wait(page, lambda: points_drawn(page) == [16, 16])
    wait_for_text(page, "Joint error per pixel of noise")
    press(page, "ArrowRight")
    wait(page, lambda: posture(page) != [0, 25, 0, -25, 0, 90, 45])
    click(page, "Compare all transfers")
    wait_for_count(page, f"{ALL_TRANSFERS} rect", 28, exactly=True)
    choose(page, "Joints", "two: θ₂, θ₄")
    wait(page, lambda: posture(page) == [25, -25])
    wait(page, lambda: points_drawn(page) == [10, 10])
    wait_for_count(page, f"{ALL_TRANSFERS} {LEVELS}", 4, exactly=True)
    bias = re.findall(r"bias ([\d.]+)°", page.text_content(ALL_TRANSFERS))
    assert len(bias) == 4 and float(bias[3]) == 0 < float(bias[0])
    click(page, "This transfer alone")
    page.wait_for_selector(ALL_TRANSFERS, state="detached")


def test_two_methods_race_from_one_start(session):
    page = session
    page.get_by_role("tab", name="Duel").click()
    choose(page, "Opponent's transfer", "Rank 3, all views")
    choose(page, "Opponent's servo", "Broyden on images")
    click(page, "Begin duel")
    said = lambda: "".join(page.locator(DUEL).all_text_contents())
    wait(page, lambda: "Opponent: Rank 3, all views" in said())
    wait_for_count(page, f"{DUEL} {LEVELS}", 2, exactly=True)
    wait(page, lambda: re.search(r"was first within 1°, after \d+ steps", said()))
    wait_for_status(page, "At rest")
    press(page, "r")
    wait(page, lambda: "Neither is within 1° of the demonstrator yet" in said())
    set_number(page, "θ₄", -45)
    wait(page, lambda: said().count("largest error20.0°") == 2)  # the demonstrator is both's
    press(page, "ArrowRight")
    wait(page, lambda: posture(page) == [40, -25] and said().count("steps1") == 2)
    click(page, "End duel")
    wait(page, lambda: "which method arrives first?" in said())
    assert posture(page) == [40, -25]


def test_display_switches(session):
    page = session
    fold(page, "Display")
    switches = ("Rays", "Residuals, 3-D", "Hand gizmo", "Whole frames", "Dark")
    for label in switches:
        switch(page, label)
    page.wait_for_selector(":root[data-mantine-color-scheme=dark]")
    choose(page, "Layout", "16 points")
    wait(page, lambda: points_drawn(page) == [16, 16])
    choose(page, "Point", "12")
    wait_for_text(page, "12: ")
    assert page.locator(CHOSEN_POINT).count() >= 4
    for label in switches:
        switch(page, label)
    page.wait_for_selector(":root[data-mantine-color-scheme=light]")
    switch(page, "Raw, rectified")
    wait_for_text(page, "Not rectified: one affine")
    switch(page, "Raw, rectified")
    fold(page, "Display")


def test_keys_choose_points_and_show_the_help(session):
    page = session
    before = chosen_point(page)
    press(page, "n")
    wait(page, lambda: chosen_point(page) != before)
    assert page.locator(CHOSEN_POINT).count() >= 4 and page.locator(EPIPOLAR_LINE).count() >= 8
    press(page, "h")
    page.wait_for_selector(HELP)
    page.wait_for_timeout(500)
    press(page, "h")
    page.wait_for_selector(HELP, state="detached")


def test_how_a_point_is_recovered_is_built_up(session):
    page, seen = session, []
    assert "cross at" in page.text_content(HOW)
    press(page, "c")
    wait(page, lambda: seen.append(page.text_content(HOW)) or seen[-1].startswith("6/6"))
    assert any(words.startswith(("1/6", "2/6", "3/6")) for words in seen)
    wait(page, lambda: "cross at" in page.text_content(HOW), 20)
    choose(page, "Transfer", "Linear combination")
    wait(page, lambda: "transferred by the steps" in page.text_content(HOW))
    wait_for_count(page, EPIPOLAR_LINE, 0, exactly=True)


# Words of headings that the link which makes the images small again lies over
OVER_HEADINGS = """() => {
  const link = document.querySelector(".vi-enlarge-images a").getBoundingClientRect();
  return [...document.querySelectorAll(".vi-four:not(.vi-above *) .vi-heading")].filter(heading => {
    const words = document.createRange();
    words.selectNodeContents(heading);
    const box = words.getBoundingClientRect();
    return link.left < box.right && box.left < link.right && link.top < box.bottom && box.top < link.bottom;
  }).map(heading => heading.textContent);
}"""


def test_panels_and_images_are_enlarged_by_a_link_and_a_key(session):
    page = session
    width = lambda selector: (page.locator(selector).first.bounding_box() or {"width": 0.0})["width"]
    widths = lambda: (width(IMAGE_L), width(LEVELS))
    wait(page, lambda: all(widths()))
    usual = still(page, widths)
    page.get_by_role("link", name="Images, large or not").click()
    wait(page, lambda: width(IMAGE_L) > 1.3 * usual[0] and not page.locator(LEVELS).first.is_visible())
    assert page.evaluate(OVER_HEADINGS) == []
    page.get_by_role("link", name="Enlarge image L", exact=True).click()
    wait(page, lambda: page.locator(f"{VIEW_NAME}:visible").all_text_contents() == ["L"])
    press(page, "Escape")
    wait(page, lambda: width(IMAGE_L) == usual[0])
    press(page, "m")
    press(page, "m")
    wait(page, lambda: width(LEVELS) > 1.3 * usual[1] and not page.locator(IMAGE_L).first.is_visible())
    assert all(page.get_by_text(words, exact=True).is_visible() for words in ("Play", "Step"))
    still(page, widths)
    page.get_by_role("link", name="Figures, large or not").click()
    wait(page, lambda: widths() == usual)


def test_a_learner_that_watches_itself_first_imitates_in_few_motions(session):
    page = session
    watch = page.get_by_role("button", name="Watch yourself first")
    fold(page, "Start")
    assert watch.is_disabled() and page.get_by_text("Only for Trust region on images.").is_visible()
    choose(page, "Preset", PRESETS[1].name)
    choose(page, "Speed", "10 a second")
    watch.click()
    wait_for_status(page, "watches its own arm, without a demonstrator")
    wait_for_status(page, "Arrived")
    wait_for_text(page, "Remembers 12 postures, which hold. Imitated in ")
    press(page, "r")
    wait_for_status(page, "Ready")
    press(page, "Space")
    after = wait_for_status(page, r"Arrived.*After 1 step\b")
    wait_for_text(page, f"Imitated in {re.search('After (.*?),', after)[1]}.")
    page.get_by_role("button", name="Forget").click()
    watch.wait_for(timeout=PATIENCE_MS)
    fold(page, "Start")


def test_history_can_be_scrubbed(session):
    page = session
    press(page, "Space")
    wait_for_status(page, "At rest")
    end = posture(page)
    assert np.abs(np.array(end) - [45, -90]).max() < 2
    set_number(page, "History", 1)
    wait(page, lambda: posture(page) == [40, -25])
    set_number(page, "History", 2)
    wait(page, lambda: posture(page) == [40, -10])


def test_nothing_is_sent_when_nothing_changes(session):
    page = session

    def falls_silent():
        page.frames_received.clear()
        page.wait_for_timeout(2000)
        return page.frames_received == []

    wait(page, falls_silent)  # once what was still to be drawn, as the landscape, has come


def test_nothing_leaves_the_machine(session):
    page = session
    press(page, "Space")
    wait_for_status(page, "At rest")
    hosts = {urlparse(url).hostname for url in page.requested if not url.startswith(("data:", "blob:"))}
    assert hosts == {"127.0.0.1"}


def test_two_tabs_are_two_sessions(browser, server, session):
    page = session
    other = open_page(browser, server)
    set_number(other, "θ₂", 80)
    press(other, "ArrowRight")
    wait(other, lambda: posture(other) == [40, -25])
    wait_for_text(other, "demonstrator (80°")
    assert posture(page) == [25, -25] and "demonstrator (45°" in page.text_content("body")
    other.close()


def test_a_reloaded_tab_goes_on_where_it_was(session):
    page, alone = session, Session(Settings.paper())
    for _ in range(3):
        alone.step()
        press(page, "ArrowRight")
    wait(page, lambda: posture(page) == stands(alone) != [25, -25])
    page.reload()
    wait_until_complete(page)
    wait(page, lambda: posture(page) == stands(alone))


def test_a_link_of_an_own_scene_opens_on_a_server_that_knows_nothing_of_it_and_survives_a_reload(browser, server):
    scene = 'title = "Eyes apart"\nextends = "panda"\n[head]\nbaseline = 0.8\n'
    there, usual = Session(Settings.paper(scene=scene)), Session(Settings.paper())
    for one in (there, usual):
        one.run(5)
    said = link.said(there.script, complete(Settings.paper()))
    page = open_page(browser, f"{server}/?preset=paper&{link.joined(said)}")
    wait(page, lambda: posture(page) == stands(there) != stands(usual))
    page.reload()
    wait_until_complete(page)
    wait(page, lambda: posture(page) == stands(there))
    press(page, "l")
    wait_for_text(page, "its scene came without a file; save the scene")
    assert page.locator(".vi-qr").count() == 1 and page.problems == []
    page.close()


@pytest.fixture
def laboratory(session):
    """A page with the tab Experiments open, in a small window."""
    session.set_viewport_size(dict(zip(("width", "height"), SIZES["small"])))
    session.get_by_role("tab", name="Experiments").click()
    session.wait_for_selector(EXPERIMENT)
    yield session
    session.set_viewport_size(dict(zip(("width", "height"), SIZES["least"])))


def test_an_experiment_is_run_judged_and_downloaded(laboratory):
    page = laboratory
    choose(page, "Experiment", "Fig. 10: trajectory imitation")
    wait(page, lambda: "frozen" in page.text_content(EXPERIMENT))
    assert page.get_by_text("Download figure and data").is_disabled()
    click(page, "Run")
    seen = set()
    wait(page, lambda: seen.add(progress(page)) or "done" in progress(page), EXPERIMENT_S)
    assert any(re.search(r"^\d+ %$", words) for words in seen), seen
    for selector in (PROGRESS, EXPERIMENT):  # seen together with the button, without scrolling
        box = page.locator(selector).bounding_box()
        assert 400 < box["y"] and box["y"] + box["height"] <= SIZES["small"][1], selector
    assert "Demonstrator (45.0°, −90.0°) · epipolar" in page.text_content(EXPERIMENT)
    rows = page.locator(VERDICT_ROW).all_text_contents()
    assert page.locator(VERDICT_ROW).first.locator("xpath=ancestor::table").evaluate(FITS)
    assert len(rows) == 14 and sum(text.endswith("pass") for text in rows) == 4, rows
    name, data = downloaded(page, "Download figure and data")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert name == "viewimit-fig10.zip" and {"fig10.npz", "fig10.json"} <= set(archive.namelist())
        assert b"demonstrator2_deg" in archive.read("fig10-frames.csv")
    set_number(page, "θ₂", 60)  # the result remains, and says for which demonstrator it was made
    page.wait_for_timeout(500)
    assert "Demonstrator (45.0°, −90.0°)" in page.text_content(EXPERIMENT)


def test_an_experiment_can_be_cancelled_and_the_session_goes_on_meanwhile(session):
    page = session
    page.get_by_role("tab", name="Experiments").click()
    choose(page, "Experiment", "Fig. 9: posture imitation")
    click(page, "Run")
    wait(page, lambda: "0 of 1" in page.text_content(EXPERIMENT), EXPERIMENT_S)
    wait_for_progress(page, r"[1-9]\d? %", EXPERIMENT_S)
    press(page, "ArrowRight")
    wait(page, lambda: posture(page) == [40, -25])
    click(page, "Cancel")
    wait_for_progress(page, r"cancelled at \d+ %")
    page.get_by_text("Run", exact=True).wait_for(timeout=PATIENCE_MS)
    assert "0 of" in page.text_content(EXPERIMENT) and page.locator(VERDICT_ROW).count() == 0


def test_a_motion_is_recorded_replayed_scrubbed_saved_and_followed(session, tmp_path):
    page = session
    page.get_by_role("tab", name="Follow").click()
    choose(page, "Chosen motion", "recorded")
    wait_for_status(page, "nothing is recorded yet")
    click(page, "Record")
    for angle in (50, 55, 60, 65):
        set_number(page, "θ₂", angle)
        page.wait_for_timeout(600)  # so that the replay shows each for long enough
    click(page, "Stop")
    wait(page, lambda: "recorded: " in page.text_content(MOTION))
    click(page, "Move the demonstrator")
    wait_for_status(page, "Moving the demonstrator · recorded")
    wait(page, lambda: demonstrator(page) in (50, 55, 60))
    wait(page, lambda: demonstrator(page) == 65 and "Moving the demonstrator" not in status(page))
    set_number(page, "Time (s)", 0)
    wait(page, lambda: demonstrator(page) == 45)
    with page.expect_download() as download:
        page.get_by_role("button", name="Save", exact=True).last.click()  # below the folder of that name
    name, data = download.value.suggested_filename, Path(download.value.path()).read_bytes()
    saved = json.loads(data)
    assert name == "viewimit-motion.json" and saved["theta_deg"][0] == [45, -90] and saved["theta_deg"][-1] == [65, -90]
    (tmp_path / "broken.json").write_text('{"format": "viewimit motion 1"}')
    upload = page.locator("input[type=file]")
    upload.set_input_files(tmp_path / "broken.json")
    wait_for_status(page, "not a recorded motion: .*missing required field")
    (tmp_path / "wave.json").write_text(json.dumps({**saved, "name": "<b>wave</b>"}))
    upload.set_input_files(tmp_path / "wave.json")
    wait(page, lambda: "<b>wave</b>: " in page.text_content(MOTION))
    page.get_by_role("tab", name="Experiments").click()
    choose(page, "Experiment", "Fig. 10: trajectory imitation")
    click(page, "Run")
    wait(page, lambda: "<b>wave</b>" in page.text_content(EXPERIMENT) and "done" in progress(page), EXPERIMENT_S)
