"""What the browser computes for the lessons on limits, motion and claims. The library is the oracle."""

import json
import subprocess
from pathlib import Path

import numpy as np
import oracles
import pytest
import typescript
from viewimit.app.lab.lessons import circle, records
from viewimit.app.lab.lessons.source import shipped
from viewimit.app.lab.lessons.step_data import situation_of, step_data

from viewimit.analysis.construction import construct

HERE = Path(__file__).parent
LESSONS = HERE.parent.parent / "app" / "lab" / "lessons"
MAP_STEP_DEG = 1.5  # of the maps with few points
TIMES, NEAR_CM, BASELINE_CM = 10.0, 10.0, 60.0  # sliders
BETS = [80, 30, None, 90, 70, 50, 10, 5, 100, 65]  # %
CROSSING = "crossing angle", "crossing moves", "uncertain by", "cond A", "baseline"
FEW = "largest E of all matches", "largest E of four matches", "cond A of all matches", "cond A in a plane"
COUNTS = 5, 7, 10
CASES = {
    "minimum": ("limits/minimum", {}, {"measures": ["E without depth"], "smallest": None}),
    "far": ("limits/minimum", {"distance": TIMES}, {"smallest": None}),
    "crossing": ("limits/crossing-angle", {}, {"measures": CROSSING}),
    "wide": ("limits/crossing-angle", {"baseline": BASELINE_CM}, {"measures": CROSSING}),
    "few": ("limits/four-points", {}, {"measures": FEW, "order": None, "largest": COUNTS}),
    "swapped": (
        "limits/swapped",
        {},
        {"measures": ["smallest E", "smallest E is off", "how E is with swapped points"]},
    ),
    "toed-in": ("limits/toed-in", {}, {"mended": "as seen"}),
    "rectified": ("limits/toed-in", {}, {"mended": "rectified"}),
    "carried": ("motion/frozen", {}, {"carried": None}),
    "sign": ("sign/sign", {}, {"scores": BETS}),
}
NEAR_DEG = 0.01  # of a posture with the smallest E
NO_CLAIM_BET = 0.5


def _step(path):
    name, step_id = path.split("/")
    lesson = shipped()[name]
    return lesson, next(step for step in lesson.step if step.id == step_id)


def _situation(case, **eyes):
    situation = situation_of(*_step(CASES[case][0]))
    return situation.with_eyes(**eyes) if eyes else situation


@pytest.fixture(scope="module")
def found():
    scenes, cases, steps = {}, [], {}
    for path, sliders, ask in CASES.values():
        if path not in steps:
            lesson, step = _step(path)
            own, computed = step_data(lesson, step)
            scenes |= own
            fields = {
                "id": step.id,
                "chosen": step.chosen,
                "race": step.race,
                "ask": {"kind": "choice", "question": ""},
            }
            sliders_of = [
                {"name": one.name, "low": one.low, "high": one.high, "start": one.start} for one in step.sliders
            ]
            steps[path] = {**fields, "sliders": sliders_of, **computed}
        cases.append({"step": steps[path], "sliders": sliders, "ask": ask})
    command = [typescript.node(), HERE / "limits.mjs", LESSONS]
    asked = json.dumps({"page": {"scenes": scenes, "hulls": {}}, "cases": cases})
    done = subprocess.run(command, input=asked, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return dict(zip(CASES, json.loads(done.stdout)))


def _value(found, case, name):
    return found[case]["measures"][name]["value"]


def test_without_depth_E_is_the_librarys(found):
    expected = oracles.without_depth(_situation("minimum"))
    assert _value(found, "minimum", "E without depth") == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("case, eyes", [("minimum", {}), ("far", {"distance": TIMES})])
def test_the_smallest_E_is_where_the_library_finds_it(found, case, eyes):
    situation = _situation(case, **eyes)
    off = np.degrees(np.abs(np.array(found[case]["smallest"]) - situation.start.theta_demo)).max()
    assert off == pytest.approx(records.bias_deg(situation), abs=NEAR_DEG)


@pytest.mark.parametrize("case, eyes", [("crossing", {"baseline": NEAR_CM}), ("wide", {"baseline": BASELINE_CM})])
def test_lines_cross_as_in_the_library(found, case, eyes):
    situation = _situation(case, **eyes)
    snapshot, point = situation.start, situation.chosen
    made = construct(snapshot, point)
    measured = {name: _value(found, case, name) for name in CROSSING}
    assert measured["crossing angle"] == pytest.approx(np.degrees(made.angle[0]), rel=1e-6)
    assert measured["crossing moves"] == pytest.approx(1 / np.sin(made.angle[0]), rel=1e-6)
    assert measured["uncertain by"] == pytest.approx(made.half_axes[0, 0], rel=1e-6)
    assert measured["cond A"] == pytest.approx(float(snapshot.transfer.condition), rel=1e-6)
    assert measured["baseline"] == pytest.approx(100 * situation.scene.head.baseline, rel=1e-9)


def test_few_matches_have_the_librarys_maps(found, monkeypatch):
    monkeypatch.setattr(oracles, "MAP_STEP_DEG", MAP_STEP_DEG)
    made = oracles.matches.__wrapped__(_situation("few"))
    every = made.by_count[len(made.order)]
    assert found["few"]["order"][4:] == made.order.tolist()[4:] and set(found["few"]["order"]) == set(made.order)
    assert found["few"]["largest"] == pytest.approx([np.nanmax(made.by_count[n].E) for n in COUNTS], rel=1e-6)
    assert _value(found, "few", "largest E of all matches") == pytest.approx(np.nanmax(every.E), rel=1e-6)
    assert _value(found, "few", "largest E of four matches") == 0 and np.nanmax(made.by_count[4].E) < 1e-9
    assert _value(found, "few", "cond A of all matches") == pytest.approx(np.nanmedian(every.condition), rel=1e-6)
    assert _value(found, "few", "cond A in a plane") == pytest.approx(np.nanmedian(made.plane.condition), rel=1e-4)


def test_the_map_with_swapped_points_is_what_the_library_sees(found):
    situation = _situation("swapped")
    found_map = records.landscape(situation, 1.0)
    off = np.degrees(np.abs(found_map.minimum - situation.start.theta_demo)).max()
    assert _value(found, "swapped", "smallest E") == pytest.approx(np.nanmin(found_map.E), rel=1e-6)
    assert _value(found, "swapped", "smallest E is off") == pytest.approx(off, abs=1e-6)
    assert _value(found, "swapped", "how E is with swapped points") == 3


@pytest.mark.parametrize("case, name", [("toed-in", "as seen"), ("rectified", "rectified")])
def test_rectified_images_have_the_librarys_smallest_E(found, case, name):
    situation = records.rectified(_situation("toed-in"))[name]
    off = np.degrees(np.abs(np.array(found[case]["mended"]) - situation.start.theta_demo)).max()
    assert off == pytest.approx(records.bias_deg(situation), abs=NEAR_DEG)


def test_hands_are_as_far_apart_as_the_library_says(found):
    made = circle.follow_circle(_situation("carried"))
    for name in ("right", "early"):
        one, shown = getattr(made, name), found["carried"]["carried"][name]
        assert np.median(shown["handMm"]) == pytest.approx(one.hand_mm, rel=1e-3)
        assert np.array(shown["overlapPx"]) == pytest.approx(one.overlap_px, rel=1e-2, abs=1e-2)
        assert np.array(shown["side"]) == pytest.approx(one.side, abs=1e-4)


def test_bets_cost_what_brier_says(found):
    runs = step_data(*_step("sign/sign"))[1]["records"]["runs"]
    bet = [k for k, each in enumerate(BETS) if each is not None]
    holds = [runs[k]["holds"] for k in bet]
    own = [runs[k]["certificate"] if runs[k]["certificate"] is not None else NO_CLAIM_BET for k in bet]
    scores = found["sign"]["scores"]
    assert scores["yours"] == pytest.approx(oracles.brier([BETS[k] / 100 for k in bet], holds))
    assert scores["certificate"] == pytest.approx(oracles.brier(own, holds))
    assert scores["costs"][BETS.index(None)] is None
