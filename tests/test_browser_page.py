"""The page in a real browser: what a visitor sees and does. Software rendering, so everything waits patiently."""

import io
import json
import re
import time
import zipfile
from pathlib import Path
from urllib.parse import urlparse

import numpy as np
import pytest
from PIL import Image
from viewimit.app.control.names import servo_names, transfer_names
from viewimit.app.control.presets import PRESETS

pytestmark = pytest.mark.browser

SIZES = {"least": (1024, 640), "small": (1280, 720), "large": (1920, 1080)}
PAUSE = 0.12  # s between widgets: the browser throttles messages at 50 ms and keeps only the latest
PATIENCE_S = 90.0  # other tests may run beside
PATIENCE_MS = 1000 * PATIENCE_S


def open_page(browser, url: str, size: str = "least"):
    width, height = SIZES[size]
    page = browser.new_page(viewport={"width": width, "height": height})
    page.problems, page.requested, page.frames_received = [], [], []
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.on("console", lambda m: page.problems.append(m.text) if m.type == "error" else None)
    page.on("request", lambda request: page.requested.append(request.url))
    page.on("websocket", lambda ws: ws.on("framereceived", lambda data: page.frames_received.append(data)))
    page.goto(url)
    page.wait_for_selector(".vi-status", timeout=PATIENCE_MS)
    page.wait_for_function("document.querySelectorAll('.vi-contour').length > 0", timeout=PATIENCE_MS)
    return page


@pytest.fixture
def page(browser, server):
    page = open_page(browser, server)
    yield page
    page.close()
    assert page.problems == []


def status(page) -> str:
    return page.text_content(".vi-status")


def wait_for_status(page, pattern: str, seconds: float = PATIENCE_S) -> str:
    until = time.monotonic() + seconds
    while not re.search(pattern, status(page)):
        assert time.monotonic() < until, f"still {status(page)!r}, waiting for {pattern!r}"
        page.wait_for_timeout(100)
    return status(page)


def wait_until(page, condition, seconds: float = PATIENCE_S) -> None:
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until
        page.wait_for_timeout(100)


def posture(page) -> list[float]:
    """The learner's read-out, degrees."""
    return [float(text.replace("−", "-").rstrip("°")) for text in page.locator(".vi-bar b").all_text_contents()]


def row(page, label: str):
    """The innermost row of the panel that carries this label."""
    rows = page.locator("div.mantine-Flex-root").filter(has=page.get_by_text(label, exact=True))
    return rows.filter(has=page.locator("input")).last


def set_number(page, label: str, value) -> None:
    """Type into the number box of a slider or of a number."""
    box = row(page, label).locator("input[type=text]").last
    box.fill(str(value))
    box.press("Enter")
    box.blur()  # a key typed into a box is not a command
    page.wait_for_timeout(1000 * PAUSE)


def choose(page, label: str, option: str) -> None:
    """Take an option of a dropdown."""
    box = row(page, label).locator("input:visible").first
    box.click()
    page.get_by_role("option", name=option, exact=True).click()
    box.blur()
    page.wait_for_timeout(1000 * PAUSE)


def switch(page, label: str) -> None:
    """Click a checkbox."""
    box = row(page, label).locator("input[type=checkbox]")
    box.click()
    box.blur()
    page.wait_for_timeout(1000 * PAUSE)


def press(page, key: str) -> None:
    page.keyboard.press(key)
    page.wait_for_timeout(1000 * PAUSE)


def canvas_colours(page) -> int:
    picture = Image.open(io.BytesIO(page.locator("canvas").first.screenshot())).convert("RGB")
    return len(np.unique(np.asarray(picture).reshape(-1, 3), axis=0))


def test_a_new_visitor_sees_everything(page):
    assert "Ready" in status(page)
    assert canvas_colours(page) > 500
    names = page.locator(".vi-name").all_text_contents()
    assert sorted(names) == sorted(["l", "r", "L", "R"])
    assert posture(page) == [25, -25]
    tabs = ["Images", "Landscape", "Curves", "Equations", "Duel", "Experiments"]
    assert page.get_by_role("tab").all_inner_texts() == tabs


def test_playing_converges_and_says_so(page):
    press(page, "Space")
    text = wait_for_status(page, "Converged")
    assert float(re.search(r"E ([\d.]+) px²", text)[1]) < 2
    assert np.abs(np.array(posture(page)) - [45, -90]).max() < 2


def test_step_undo_reset_by_button_and_key(page):
    start = posture(page)
    press(page, "ArrowRight")
    wait_until(page, lambda: posture(page) == [40, -25])  # the first probe: joint 2 by 15°
    press(page, "ArrowLeft")
    wait_until(page, lambda: posture(page) == start)
    page.get_by_text("Step", exact=True).click()
    wait_until(page, lambda: posture(page) == [40, -25])
    page.get_by_text("Step", exact=True).click()
    wait_until(page, lambda: posture(page) == [40, -10])
    page.get_by_text("Undo", exact=True).click()
    wait_until(page, lambda: posture(page) == [40, -25])
    press(page, "r")
    wait_until(page, lambda: posture(page) == start)
    wait_for_status(page, "Ready")
    set_number(page, "θ₂", 60)  # the landscape still follows
    page.wait_for_function("document.body.textContent.includes('demonstrator (60°')")


def test_the_demonstrator_may_move_while_the_loop_runs(page):
    press(page, "Space")
    wait_for_status(page, "Converged")
    set_number(page, "θ₂", 70)
    page.wait_for_function("document.body.textContent.includes('demonstrator (70°')")
    wait_until(page, lambda: np.abs(np.array(posture(page)) - [70, -90]).max() < 5)
    wait_for_status(page, "Converged")


def test_every_preset_runs(page):
    for preset in reversed([preset for preset in PRESETS if preset.settings.camera == "points"]):
        choose(page, "Preset", preset.name)
        page.wait_for_function("text => document.querySelector('.vi-lesson').textContent == text", arg=preset.lesson)
        press(page, "Space")
        page.wait_for_timeout(1500)
        assert re.search(r"E [\d.]+ px²|points? (is|are) seen", status(page)), preset.name
        assert canvas_colours(page) > 300, preset.name


def test_every_method_can_be_chosen(page):
    for name in transfer_names().values():
        choose(page, "Transfer", name)
    for name in servo_names().values():
        choose(page, "Servo", name)
        press(page, "ArrowRight")
        page.wait_for_timeout(700)
        assert "error" not in status(page).lower()


def test_too_few_points_hold_the_arm_still_and_say_so(page):
    set_number(page, "Frames", 1)  # of 25, one or another shows each point
    set_number(page, "Missing %", 50)
    wait_for_status(page, "Stopped · (only|no)")
    before = posture(page)
    press(page, "ArrowRight")
    page.wait_for_timeout(700)
    assert posture(page) == before
    set_number(page, "Missing %", 0)
    wait_for_status(page, "Ready|Moving|Paused")


def test_noise_and_seed_repeat(page):
    def changed_E(label, value):
        before = page.locator(".vi-big").first.text_content()
        set_number(page, label, value)
        wait_until(page, lambda: page.locator(".vi-big").first.text_content() != before)
        return page.locator(".vi-big").first.text_content()

    noisy = changed_E("Noise px", 0.5)
    click(page, "Arm and chance")
    page.wait_for_timeout(300)
    other = changed_E("Seed", 8)
    assert changed_E("Seed", 7) == noisy != other
    changed_E("Wrong %", 20)
    changed_E("Frames", 50)  # sets them aside, and averages the noise
    set_number(page, "Noise px", 0)
    set_number(page, "Wrong %", 0)
    set_number(page, "Gain err. %", 20)
    press(page, "ArrowRight")
    wait_until(page, lambda: posture(page) == [43, -25])  # the first probe of 15°
    set_number(page, "Steps °", 2)
    press(page, "ArrowRight")
    wait_until(page, lambda: posture(page)[1] == -8)


def test_all_joints_can_be_freed_and_held_again(page):
    choose(page, "Joints", "all seven")
    wait_until(page, lambda: len(posture(page)) == 7)
    assert "of 16" in page.text_content(".vi-panel svg")
    page.wait_for_function("document.body.textContent.includes('What 1 px of noise costs')")
    press(page, "ArrowRight")
    wait_until(page, lambda: posture(page) != [0, 25, 0, -25, 0, 90, 45])
    click(page, "Compare all transfers")
    page.wait_for_function("document.querySelectorAll('.vi-transfers rect').length == 28")
    choose(page, "Joints", "two: θ₂, θ₄")
    wait_until(page, lambda: posture(page) == [25, -25])
    assert "of 10" in page.text_content(".vi-panel svg")
    page.wait_for_function("document.querySelectorAll('.vi-transfers .vi-contour').length == 4")
    bias = re.findall(r"bias ([\d.]+)°", page.text_content(".vi-transfers"))
    assert len(bias) == 4 and float(bias[3]) == 0 < float(bias[0])
    click(page, "This transfer alone")
    page.wait_for_selector(".vi-transfers", state="detached")


def test_two_methods_race_from_one_start(page):
    page.get_by_role("tab", name="Duel").click()
    choose(page, "Opponent's transfer", "Rank 3, all views")
    choose(page, "Opponent's servo", "Broyden on images")
    click(page, "Begin duel")
    said = lambda: "".join(page.locator(".vi-duel").all_text_contents())
    wait_until(page, lambda: "Opponent: Rank 3, all views" in said())
    page.wait_for_function("document.querySelectorAll('.vi-duel .vi-contour').length == 2")
    wait_until(page, lambda: re.search(r"was first within 1° of the demonstrator, after \d+ motions", said()))
    wait_for_status(page, "Converged")
    press(page, "r")
    wait_until(page, lambda: "Neither is within 1° of the demonstrator yet" in said())
    set_number(page, "θ₄", -45)
    wait_until(page, lambda: said().count("largest error20.0°") == 2)  # the demonstrator is both's
    press(page, "ArrowRight")
    wait_until(page, lambda: posture(page) == [40, -25] and said().count("motions1") == 2)
    click(page, "End duel")
    wait_until(page, lambda: "which method arrives first?" in said())
    assert posture(page) == [40, -25]


def test_display_switches(page):
    page.get_by_text("Display", exact=True).click()
    page.wait_for_timeout(500)
    for label in ("Rays", "Residuals, 3-D", "Hand gizmo", "Whole frames", "Dark"):
        switch(page, label)
    page.wait_for_selector(":root[data-mantine-color-scheme=dark]")
    choose(page, "Layout", "16 points")
    page.wait_for_function("document.body.textContent.includes('of 16')")
    choose(page, "Point", "12")
    page.wait_for_function("document.body.textContent.includes('12: ')")
    assert page.locator("circle.vi-ring").count() >= 4


def test_keys_choose_points_and_show_the_help(page):
    press(page, "n")
    page.wait_for_function("document.querySelectorAll('circle.vi-ring').length >= 4")
    assert page.locator(".vi-line").count() >= 8
    press(page, "h")
    page.wait_for_selector(".vi-help")
    page.wait_for_timeout(500)
    press(page, "h")
    page.wait_for_selector(".vi-help", state="detached")


def test_history_can_be_scrubbed(page):
    press(page, "Space")
    wait_for_status(page, "Converged")
    end = posture(page)
    assert np.abs(np.array(end) - [45, -90]).max() < 2
    set_number(page, "History", 1)
    wait_until(page, lambda: posture(page) == [40, -25])
    set_number(page, "History", 2)
    wait_until(page, lambda: posture(page) == [40, -10])


def test_nothing_is_sent_when_nothing_changes(page):
    page.wait_for_timeout(2500)
    page.frames_received.clear()
    page.wait_for_timeout(2000)
    assert page.frames_received == []


def test_nothing_leaves_the_machine(page):
    press(page, "Space")
    wait_for_status(page, "Converged")
    hosts = {urlparse(url).hostname for url in page.requested if not url.startswith(("data:", "blob:"))}
    assert hosts == {"127.0.0.1"}


def test_two_tabs_are_two_sessions(browser, server, page):
    other = open_page(browser, server)
    set_number(other, "θ₂", 80)
    press(other, "ArrowRight")
    wait_until(other, lambda: posture(other) == [40, -25])
    other.wait_for_function("document.body.textContent.includes('demonstrator (80°')")
    assert posture(page) == [25, -25] and "demonstrator (45°" in page.text_content("body")
    other.close()


def test_a_reloaded_tab_goes_on_where_it_was(page):
    press(page, "ArrowRight")
    wait_until(page, lambda: posture(page) == [40, -25])
    page.reload()
    page.wait_for_selector(".vi-status", timeout=PATIENCE_MS)
    page.wait_for_function("document.querySelectorAll('.vi-contour').length > 0", timeout=PATIENCE_MS)
    assert posture(page) == [40, -25]


@pytest.fixture
def laboratory(browser, server):
    """A page with the tab Experiments open."""
    page = open_page(browser, server, "small")
    choose(page, "Preset", "Paper, Section 5.3")
    page.get_by_role("tab", name="Experiments").click()
    page.wait_for_selector(".vi-figure")
    yield page
    page.close()
    assert page.problems == []


def progress(page) -> str:
    return page.text_content(".vi-progress span")


def wait_for_progress(page, pattern: str, seconds: float = PATIENCE_S) -> None:
    wait_until(page, lambda: re.search(pattern, progress(page)), seconds)


def click(page, words: str) -> None:
    page.get_by_text(words, exact=True).click()
    page.wait_for_timeout(1000 * PAUSE)


def downloaded(page, button: str) -> tuple[str, bytes]:
    with page.expect_download() as download:
        click(page, button)
    return download.value.suggested_filename, Path(download.value.path()).read_bytes()


def demonstrator(page) -> float:
    """The slider of joint 2, degrees."""
    return float(row(page, "θ₂").get_by_role("slider").get_attribute("aria-valuenow"))


def test_an_experiment_is_run_judged_and_downloaded(laboratory):
    page = laboratory
    choose(page, "Experiment", "Fig. 10: trajectory imitation")
    assert "frozen" in page.text_content(".vi-figure") and page.get_by_text("Download figure and data").is_disabled()
    click(page, "Run")
    seen = set()
    wait_until(page, lambda: seen.add(progress(page)) or "done" in progress(page), 60)
    assert any(re.search(r"^\d+ %$", words) for words in seen), seen
    for selector in (".vi-progress", ".vi-figure"):  # seen together with the button, without scrolling
        box = page.locator(selector).bounding_box()
        assert 400 < box["y"] and box["y"] + box["height"] <= SIZES["small"][1], selector
    assert "Demonstrator (45.0°, −90.0°) · epipolar" in page.text_content(".vi-figure")
    rows = page.locator(".vi-verdict tr").all_text_contents()
    assert len(rows) == 14 and sum(text.endswith("pass") for text in rows) == 4, rows
    name, data = downloaded(page, "Download figure and data")
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        assert name == "viewimit-fig10.zip" and {"fig10.npz", "fig10.json"} <= set(archive.namelist())
        assert b"demonstrator2_deg" in archive.read("fig10-frames.csv")
    set_number(page, "θ₂", 60)  # the result remains, and says for which demonstrator it was made
    page.wait_for_timeout(500)
    assert "Demonstrator (45.0°, −90.0°)" in page.text_content(".vi-figure")


def test_an_experiment_can_be_cancelled_and_the_session_goes_on_meanwhile(page):
    page.get_by_role("tab", name="Experiments").click()
    choose(page, "Experiment", "Fig. 9: posture imitation")
    click(page, "Run")
    wait_until(page, lambda: "0 of 1" in page.text_content(".vi-figure"))
    assert re.search(r"[1-9]\d? %", progress(page))
    press(page, "ArrowRight")
    wait_until(page, lambda: posture(page) == [40, -25])
    click(page, "Cancel")
    wait_for_progress(page, r"cancelled at \d+ %")
    page.get_by_text("Run", exact=True).wait_for(timeout=PATIENCE_MS)
    assert "0 of" in page.text_content(".vi-figure") and page.locator(".vi-verdict").count() == 0


def test_a_motion_is_recorded_replayed_scrubbed_saved_and_followed(page, tmp_path):
    page.get_by_role("tab", name="Experiments").click()
    choose(page, "Experiment", "Fig. 10: trajectory imitation")
    click(page, "Demonstrator's motion")
    page.wait_for_timeout(300)
    choose(page, "Chosen motion", "recorded")
    wait_for_status(page, "nothing is recorded yet")
    click(page, "Record")
    for angle in (50, 55, 60, 65):
        set_number(page, "θ₂", angle)
        page.wait_for_timeout(600)  # so that the replay shows each for long enough
    click(page, "Stop")
    wait_until(page, lambda: "recorded: " in page.text_content(".vi-said"))
    click(page, "Replay")
    wait_until(page, lambda: demonstrator(page) in (50, 55, 60))
    wait_for_status(page, "Replaying · recorded")
    wait_until(page, lambda: demonstrator(page) == 65 and "Replaying" not in status(page))
    set_number(page, "Moment", 0)
    wait_until(page, lambda: demonstrator(page) == 45)
    name, data = downloaded(page, "Save")
    saved = json.loads(data)
    assert name == "viewimit-motion.json" and saved["theta_deg"][0] == [45, -90] and saved["theta_deg"][-1] == [65, -90]
    (tmp_path / "broken.json").write_text('{"format": "viewimit motion 1"}')
    upload = page.locator("input[type=file]")
    upload.set_input_files(tmp_path / "broken.json")
    wait_for_status(page, "not a recorded motion: .*missing required field")
    (tmp_path / "wave.json").write_text(json.dumps({**saved, "name": "<b>wave</b>"}))
    upload.set_input_files(tmp_path / "wave.json")
    wait_until(page, lambda: "<b>wave</b>: " in page.text_content(".vi-said"))
    click(page, "Run")
    wait_for_progress(page, "done")
    assert "<b>wave</b>" in page.text_content(".vi-figure")


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", ["small", "large"])
def test_layout_has_no_overlap(browser, server, size, dark, tmp_path):
    page = open_page(browser, server, size)
    if dark:
        page.get_by_text("Display", exact=True).click()
        switch(page, "Dark")
        page.get_by_text("Display", exact=True).click()
    press(page, "n")
    press(page, "Space")
    wait_for_status(page, "Converged")
    page.wait_for_timeout(800)
    page.screenshot(path=tmp_path / f"{size}_{'dark' if dark else 'light'}.png")
    width, height = SIZES[size]
    pill = page.locator(".vi-status").bounding_box()
    canvas = page.locator("canvas").first.bounding_box()
    assert canvas["x"] <= pill["x"] and pill["x"] + pill["width"] <= canvas["x"] + canvas["width"]
    assert pill["y"] + pill["height"] <= height
    if size == "large":
        card = page.locator(".vi-card").bounding_box()
        assert card["y"] + card["height"] <= pill["y"]
    for selector in (".vi-keys", ".vi-panel >> nth=0"):
        box = page.locator(selector).first.bounding_box()
        assert box["y"] + box["height"] <= height + 1, selector
    texts = page.locator(".vi-panel svg").first.locator("text")
    assert texts.count() > 8
    assert page.problems == []
    page.close()
