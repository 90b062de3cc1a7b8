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


def test_nothing_is_right_before_an_answer(found):
    assert found["unanswered"] == {"answered": False, "right": None, "reply": ""}


def test_each_choice_gets_its_own_reply(found):
    assert found["rightChoice"] == 1
    assert [one["right"] for one in found["choices"]] == [False, True, False]
    assert [one["reply"] for one in found["choices"]] == [
        "No: it is the second.",
        "Right: it is the second.",
        "No: the third is worse.",
    ]


def test_what_was_shown_unanswered_is_neither_right_nor_replied_to(found):
    assert (found["shown"]["right"], found["shown"]["reply"]) == (None, "")


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


def test_the_seed_picks_a_deal(found):
    assert found["sampled"] == {"index": 3, "goal": 30, "count": 5}


def test_a_slider_turns_a_joint_and_a_motion_by_hand_counts(found):
    assert found["slid"] == pytest.approx(33)
    assert [posture[:2] for posture in found["motions"]] == [
        pytest.approx(at) for at in ([30, -115], [40, -100], [70, -68])
    ]


def test_a_solution_reaches_the_goal_and_leaves_the_stage_as_it_was(found):
    assert found["left"] and found["solvedE"] < 30


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


def test_bets_cost_the_square_of_their_error(found):
    assert [(one["right"], one["penalty"]) for one in found["bets"]] == [
        (True, "0.04"),
        (False, "0.64"),
        (None, "0.20"),
    ]
    assert found["runs"] == 2


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


def test_nothing_is_said_of_a_step_that_was_not_played(found):
    unplayed, played = found["played"]
    assert unplayed == (
        "Steps to the goal: Broyden {motions of Broyden}. Hollow marks are tests. You have not played “Be the servo”."
    )
    assert played.startswith("Steps to the goal: you {your motions to the goal}, Broyden")
    assert found["unplayedSentence"] == "E is {E}. You have not played “Be the servo”."
