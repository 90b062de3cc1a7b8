"""What the runtime of lessons computes from a page's data, in Node: answers, samples, sliders, questions."""

import json
import subprocess
from collections import Counter
from pathlib import Path

import pytest
import typescript
import walking

HERE = Path(__file__).parent
LESSONS = HERE.parent.parent / "app" / "lab" / "lessons"


@pytest.fixture(scope="module")
def found():
    command = [typescript.node(), str(HERE / "runtime.mjs"), str(LESSONS)]
    done = subprocess.run(command, input=json.dumps(walking.data()), capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_mark_is_judged_by_its_distance_and_the_reply_states_it(found):
    near, far = found["places"]
    assert (near["right"], near["reply"]) == (True, "Very close.")
    assert (far["right"], far["reply"]) == (False, "Too far: 60\xa0px.")
    assert near["apart"]["value"] == pytest.approx(3)


def test_a_place_elsewhere_has_a_reply_of_its_own_that_comes_first(found):
    assert found["elsewhere"] == "There."


def test_the_distance_to_a_line_is_to_its_nearest_place(found):
    assert found["toLine"] == pytest.approx(3)


def test_a_number_is_close_within_a_factor_and_too_little_has_its_own_reply(found):
    close, little, much = found["numbers"]
    assert [close["right"], little["right"], much["right"]] == [True, False, False]
    assert close["reply"] == "Well judged." and much["reply"] == "Not so much."
    assert little["reply"].startswith("It is more: 846\xa0px²")


def test_a_step_goes_on_with_the_deal_the_path_and_the_goal_of_the_earlier_one(found):
    carried = found["carried"]
    assert (carried["seed"], carried["motions"], carried["demonstrator"], carried["goal"]) == (4, 3, True, 30)
    assert carried["at"] == pytest.approx([70, -68])


def test_marks_on_a_map_are_judged_in_degrees(found):
    assert found["onMap"] == {"answered": True, "right": True, "reply": "Close.", "apart": "10°"}


def test_a_posture_is_judged_by_the_joint_that_is_farthest_off(found):
    assert found["pose"]["right"] and found["pose"]["apart"] == pytest.approx(3)
    assert found["guessed"] == pytest.approx([70, -40])


def test_knobs_turn_one_joint_each_by_dealt_gains_of_either_sign(found):
    knobs = found["knobs"]
    assert sum(abs(turn) > 1 for turn in knobs["turns"]) == 1
    each = [[row.index(next(v for v in row if v)) for row in pair] for pair in knobs["seeds"]]
    assert {tuple(pair) for pair in each} == {(0, 1), (1, 0)}
    gains = [v for pair in knobs["seeds"] for row in pair for v in row if v]
    assert min(gains) < 0 < max(gains) and min(map(abs, gains)) > 0.2


def test_sliders_bring_the_arms_alike_and_turn_the_demonstrator(found):
    assert found["alike"] == pytest.approx([0, 0], abs=1e-9)
    assert found["demo"] == pytest.approx(-90)


def test_the_order_of_answers_is_dealt_evenly_and_stays(found):
    assert found["orderAgain"][0] == found["orderAgain"][1]
    firsts = Counter(order[0] for order in found["orders"])
    assert set(firsts) == {0, 1, 2, 3} and min(firsts.values()) > 30
    assert all(sorted(order) == [0, 1, 2, 3] for order in found["orders"])


def test_the_gain_is_the_share_of_what_was_wrong_that_is_right_now(found):
    assert found["gains"] == [0.75, None, -0.5, 5]
    better, all_right, once = found["outcomes"]
    assert better["large"] == "4 → 7 of 8" and "Gain 0.75" in better["words"]
    assert "all of them right before" in all_right["words"] and "no gain" in once["words"]
