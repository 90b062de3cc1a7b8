"""A challenge: its rules in Node, beside this file's own reading of them, and whole games in a browser."""

import datetime
import json
import subprocess
from pathlib import Path

import numpy as np
import pytest
import typescript
from browsing import sparing
from viewimit.app.lab.engine_scene import engine_scene
from viewimit.app.lab.page import lab_page
from waiting import wait_until

from viewimit import Session, Settings, load_scene

HERE = Path(__file__).parent
LAB = HERE.parent.parent / "app" / "lab"
WITHIN = {"easy": 5, "points": 5, "blindfold": 10}  # degrees
RANGE = np.array([[0, 90], [-180, 0]])  # degrees of shoulder and elbow
DAYS = [str(datetime.date(2026, 11, 28) + datetime.timedelta(days=13 * k)) for k in range(12)]
OFFSET, DISGUISE, DIGITS = 256, 0x5BD12F3A6, "0123456789abcdefghijklmnopqrstuvwxyz"
POSE = "#challenge=2026-11-28"


def decoded(word):
    """Degrees of both joints of the demonstrator and of the start, as the documentation says a word holds them."""
    bits = int(word, 36) ^ DISGUISE
    angles = [(bits >> 5 + 9 * k & 511) - OFFSET for k in (3, 2, 1, 0)]
    assert sum((v + OFFSET) * (2 * k + 3) for k, v in enumerate(angles)) % 32 == bits % 32
    return angles


def robots_steps(angles, level, most=30):
    """Of the library's Broyden with the projective transfer, until it is near enough; None if it never is."""
    goal = np.array(angles[:2])
    settings = Settings.paper(
        transfer="projective", servo="broyden", rectify="off", demonstrator_deg=tuple(map(float, angles[:2])),
        start_deg=tuple(map(float, angles[2:])),
    )  # fmt: skip
    session = Session(settings)
    for steps in range(1, most + 1):
        if not session.step():
            return None
        if np.abs(np.degrees(session.snapshot.theta) - goal).max() <= WITHIN[level] + 1e-6:
            return steps
    return None


def why_not(angles, level):
    """A word of the reason for which a pose is not offered; "" if it is."""
    goal, start = np.array(angles[:2]), np.array(angles[2:])
    near_end = lambda pose: (np.abs(RANGE - pose[:, None]) < 8).any()
    far = np.abs(goal - start).max()
    if near_end(goal):
        return "joint is at its end"
    if not 20 <= abs(goal[1]) <= 160:
        return "stretched" if abs(goal[1]) < 20 else "folded"
    if near_end(start):
        return "blue arm stands at its end"
    if far < 30:
        return "Too easy"
    steps = robots_steps(angles, level)
    if steps is not None and steps < 4:
        return "Too easy"
    if far > 100:
        return "too far away"
    return "Even the robot" if steps is None or steps > 8 else ""


@pytest.fixture(scope="module")
def asked():
    rng = np.random.default_rng(5)
    angles = [[int(rng.integers(*RANGE[k % 2] + [0, 1])) for k in range(4)] for _ in range(60)]
    pairs = [
        [np.radians(one[:2]).tolist(), np.radians(one[2:]).tolist(), list(WITHIN)[k % 3]]
        for k, one in enumerate(angles)
    ]
    pose = [np.radians(p).tolist() for p in ([30, -60], [1000, 1000])]
    return {
        "scene": engine_scene(load_scene("panda")), "days": DAYS, "levels": list(WITHIN), "angles": angles,
        "pairs": pairs, "hashes": ["", "#challenge=zzzzzzzz", f"{POSE}&level=hard", "#challenge=../x", POSE],
        "games": [{"hash": POSE, "moves": pose[:1] * 10}, {"hash": POSE, "moves": []}],
    }  # fmt: skip


@pytest.fixture(scope="module")
def found(asked):
    command = [typescript.node(), HERE / "challenge.mjs", LAB]
    done = subprocess.run(command, input=json.dumps(asked), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_each_day_has_an_offered_pose_for_each_level_and_the_robots_steps_are_the_librarys(found):
    assert len({tuple(one["whole"]) for one in found["days"]}) == len(found["days"]) == len(DAYS) * len(WITHIN)
    for one in found["days"]:
        assert why_not(one["whole"], one["level"]) == ""
        assert one["robot"] == robots_steps(one["whole"], one["level"])


def test_a_pose_is_refused_for_the_reason_that_its_sentence_names(asked, found):
    reasons = [why_not(one, pair[2]) for one, pair in zip(asked["angles"], asked["pairs"])]
    assert len(set(reasons)) >= 6
    for reason, said in zip(reasons, found["refusals"]):
        assert said == reason == "" or (reason and reason in said)


def test_a_pose_made_by_hand_keeps_its_arm_and_gets_a_start_from_which_it_is_offered(asked, found):
    for one, pair, made in zip(asked["angles"], asked["pairs"], found["made"]):
        if isinstance(made, str):
            assert made
            continue
        assert made["whole"][:2] == one[:2] and why_not(made["whole"], pair[2]) == ""
        link = made["link"]
        assert decoded(link.partition("=")[2].partition("&")[0]) == made["whole"]
        assert made["by"] == "Mia <b> and all of h" and "by=Mia%20%3Cb%3E" in link and str(abs(one[1])) not in link[:19]


def test_what_holds_no_challenge_is_refused_and_of_typing_errors_few_pass(asked, found):
    *wrong, day = found["read"]
    assert wrong == [None] * len(wrong) and day["day"] == "2026-11-28"
    assert sum(found["typos"]) < 0.02 * len(asked["pairs"]) * 8 * 35


def test_ten_steps_are_the_end_and_the_line_says_it_in_words_first(found):
    played, given_up = found["games"]
    assert played["isOver"] and played["verdict"].startswith("Not found in 10 steps. The robot needed ")
    first, squares = played["line"].split("\n")
    assert first.startswith("viewimit 2026-11-28 (Points): not found in 10 steps. Robot: ") and len(squares) == 10
    assert given_up["verdict"].startswith("You gave up before the first step.")


class Player:
    """A page in which a challenge is played, and the live region's sentences."""

    def __init__(self, page, address):
        self.page = page
        page.goto(address)
        page.locator(".challenge .task:not(:empty)").wait_for()
        page.evaluate("""() => {
            window.heard = [];
            const status = document.querySelector(".challenge [role=status]");
            new MutationObserver(() => heard.push(status.textContent)).observe(status, {childList: true});
        }""")

    @property
    def heard(self):
        return self.page.evaluate("heard")

    @property
    def over(self):
        return self.page.locator(".challenge").get_attribute("data-over") == "true"

    def sliders(self):
        return self.page.locator(".turned input").all()

    def went(self, steps):
        wait_until(lambda: len(self.heard) >= steps)

    def by_touch(self, *degrees):
        """Tap beside the thumbs, then − or + until the sliders stand there."""
        for k, slider in enumerate(self.sliders()):
            share, box = (degrees[k] - RANGE[k, 0]) / np.ptp(RANGE[k]), slider.bounding_box()
            self.page.touchscreen.tap(box["x"] + 12 + share * (box["width"] - 24), box["y"] + box["height"] / 2)
            missing = round(degrees[k] - RANGE[k, 0] - float(slider.input_value()) / 100 * np.ptp(RANGE[k]))
            for _ in range(abs(missing)):
                self.page.tap(f".turned >> nth={k} >> .nudge >> nth={int(missing > 0)}")

    def by_keys(self, k, degrees):
        """Press until a slider has gone on by so many degrees, and hear it said."""
        slider = self.sliders()[k]
        slider.focus()
        for _ in range(abs(degrees)):
            slider.press("ArrowRight" if degrees > 0 else "ArrowLeft")
        return f"{slider.get_attribute('aria-label')}, slider, {slider.get_attribute('aria-valuetext')}"


def game_by_keys(player, angles, detour=-12):
    """A detour of the shoulder, then straight to the pose. Returns what a screen reader says after each key."""
    goal, start = angles[:2], angles[2:]
    spoken = [player.page.inner_text(".challenge .brief .task"), player.page.inner_text(".challenge .rule")]
    spoken.append(player.by_keys(0, detour))
    player.page.keyboard.press("Enter")
    player.went(1)
    spoken += player.heard[-1:]
    spoken.append(player.by_keys(1, goal[1] - start[1]))
    spoken.append(player.by_keys(0, goal[0] - start[0] - detour))
    player.page.keyboard.press("Enter")
    player.went(2)
    return spoken + player.heard[-1:]


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    path = tmp_path_factory.mktemp("challenge") / "lab.html"
    path.write_text(lab_page(), "utf-8")
    return path.as_uri()


@pytest.mark.browser
def test_a_challenge_made_here_is_played_there_by_touch_and_by_keys(browser, address):
    faults, pages = [], []
    for options in ({}, {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True}, {}):
        page = sparing(browser.new_context(**options)).new_page()
        page.on("pageerror", lambda error: faults.append(str(error)))
        page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
        pages.append(page)
    maker, phone, keys = pages
    maker.goto(address + "#preset=paper&demo=40,-70&start=66,-140")
    maker.click("#challenge")
    maker.fill(".maker label input", "Mia")
    link = maker.input_value(".sending input")
    angles = decoded(link.partition("=")[2].partition("&")[0])
    assert angles == [40, -70, 66, -140] and link.endswith("&by=Mia")

    by_touch = Player(phone, address + link)
    robot = robots_steps(angles, "points")
    assert phone.inner_text(".task") == f"Mia posed the orange arm. Copy it in fewer steps than the robot: {robot}."
    hints = phone.locator(".four :is(.vi-found, .vi-e)[d]:not([d=''])")  # diamonds and arrows
    assert hints.count() == 0
    assert phone.locator(".four .vi-demo .vi-hull").first.is_hidden() and "°" not in phone.inner_text(".playing")
    windows = "[...document.querySelectorAll('.four .vi-rule')].map(one => one.outerHTML)"
    before = phone.evaluate(windows)
    by_touch.by_touch(angles[0] - 30, angles[1])
    assert by_touch.heard == []  # setting moves nothing
    phone.tap(".steered .go")
    by_touch.went(1)
    assert phone.evaluate(windows) == before and not by_touch.over
    by_touch.by_touch(*angles[:2])
    phone.tap(".steered .go")
    by_touch.went(2)
    assert by_touch.over and phone.inner_text(".verdict") == "Faster than the robot: 2 steps."
    assert phone.evaluate("document.activeElement.className") == "verdict"
    assert hints.count() > 0
    assert phone.inner_text(".line").startswith("viewimit challenge (Points): ")

    by_keys = Player(keys, address + link)
    heard = game_by_keys(by_keys, angles)
    assert "Step 1 of 10. The pictures disagree by " in heard[3]
    assert heard[-1].startswith("Faster than the robot: 2 steps. You stopped 0.0° off")
    assert keys.inner_text(".best") == "Best on this device: 2 steps."
    keys.reload()
    keys.click("text=Give up")
    assert keys.is_visible("section.playing")  # until the second press
    keys.click("text=Give up: sure?")
    assert "practice" in keys.inner_text(".best")
    keys.click("text=How did the robot do it?")
    keys.locator("#count:not(:empty)").wait_for()
    assert keys.evaluate("lab.session().settings.transfer") == "projective"
    assert keys.evaluate("lab.session().now.motion") == robot
    keys.go_back()
    assert keys.inner_text(".verdict").startswith("You gave up")
    keys.goto(address + "#challenge=today")
    wait_until(lambda: keys.inner_text(".task").startswith("The pose of today. Copy it"))
    assert faults == []
    for page in pages:
        page.context.close()
