"""The benchmark measures what it says; its baselines are the paper's equations, and OpenCV's perspective ones."""

import importlib.util
import itertools
import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from viewimit.analysis import landscape
from viewimit.commands.cli import main
from viewimit.estimation.transfers import TRANSFERS
from viewimit.experiments.bench import baselines, speed
from viewimit.loop.session import Session
from viewimit.servo import SERVOS
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(speed, "LOOP_SHARE", 50)
    monkeypatch.setattr(speed, "ROUNDS", 3)
    monkeypatch.setattr(speed, "SLOW_ROUNDS", 1)
    monkeypatch.setattr(speed, "SINGLE_CALLS", 20)
    monkeypatch.setattr(speed, "MOTIONS", 3)


@pytest.fixture
def coarse(monkeypatch):
    """10 x 19 postures"""
    for module in (speed, landscape):
        monkeypatch.setattr(module, "grid_axes", partial(landscape.grid_axes, step_deg=10.0))


def test_the_baselines_agree_with_each_other():
    world = World(load_scene("iiwa"))
    demo, _ = world.demo_images(np.radians([45, -60]))
    postures = np.random.default_rng(0).uniform(world.scene.lower, world.scene.upper, (100, 2))
    E, condition = baselines.batch(world, demo, postures, with_condition=True)
    np.testing.assert_allclose(E, baselines.loop(world, demo, postures), rtol=1e-9)
    assert condition.min() >= 1
    assert baselines.batch(world, demo, postures)[1] is None
    own = baselines.own_image(world, postures[7])
    np.testing.assert_allclose(own, world.own_images(postures[7])[0], rtol=1e-12)
    assert baselines.conflict(demo, own) == pytest.approx(E[7], rel=1e-9)
    assert baselines.conflicts(demo, own[None])[0] == pytest.approx(E[7:8], rel=1e-9)


def test_the_benchmark_compares_like_with_like_and_is_much_faster(quick):
    """Figures are for the command; here only that a fast path is far from the plain one, on however busy a machine."""
    shares = []
    result = speed.run(progress=shares.append)
    assert (result.postures, result.loop_postures) == (91 * 181, 91 * 181 // 50)
    assert result.batch_agreement < 1e-8 and result.loop_agreement < 1e-8 and result.condition_agreement < 1e-8
    assert result.batch_s > 2 * result.landscape_s["epipolar"]
    assert result.loop_s > 20 * result.landscape_s["epipolar"]
    assert all(set(times) == {1, speed.BATCH} for times in result.fit_s.values())
    assert {name: set(times) for name, times in result.motion_s.items()} == {name: set(SERVOS) for name in TRANSFERS}
    assert shares == sorted(shares) and shares[-1] == 1


def test_what_is_timed_at_one_posture_is_E_of_the_same_images(quick, coarse, monkeypatch):
    monkeypatch.setattr(speed, "call_s", lambda call: call())
    result = speed.run("iiwa")
    one, together = result.fit_s["epipolar"].values()
    assert one == pytest.approx(together[0]) and together.shape == (speed.BATCH,)
    assert one == pytest.approx(result.loop_posture_s) and [one] == pytest.approx(result.batch_posture_s[0])
    world = World(load_scene("iiwa"))
    demo, _ = world.demo_images(np.radians([45, -90]))
    first = np.array([axis[0] for axis in landscape.grid_axes(world)])
    assert one == pytest.approx(baselines.loop(world, demo, first[None])[0])
    if result.opencv:
        assert result.opencv.posture_s == baselines.opencv_loop(world, demo, first[None])[0] != one


def test_a_motion_is_timed_from_the_scenes_start_again_whenever_the_servo_rests(quick, coarse, monkeypatch):
    monkeypatch.setattr(speed, "MOTIONS", 40)
    monkeypatch.setattr(speed, "SERVOS", {"broyden": SERVOS["broyden"]})
    calls = []
    step, reset = Session.step, Session.reset
    monkeypatch.setattr(Session, "step", lambda session: calls.append(step(session)) or calls[-1])
    monkeypatch.setattr(Session, "reset", lambda session: calls.append("reset") or reset(session))
    clock = itertools.count()
    monkeypatch.setattr(speed.time, "process_time", lambda: float(next(clock)))
    assert speed.run("panda").motion_s == {transfer: {"broyden": 1.0} for transfer in TRANSFERS}
    assert calls.count(True) == speed.MOTIONS * len(TRANSFERS)
    rests = [k for k, call in enumerate(calls) if call is False]
    assert len(rests) >= 3 * len(TRANSFERS) and all(calls[k + 1] == "reset" for k in rests)


@pytest.fixture(scope="module")
def cv2():
    return pytest.importorskip("cv2")


@pytest.mark.parametrize("scene", ["panda", "iiwa", "panda-facing", "panda-verged"])
@pytest.mark.parametrize("demonstrator", [(45, -90), (20, -40), (80, -110)])
def test_opencvs_E_is_0_in_the_demonstrators_posture_alone_and_grows_away_from_it(cv2, scene, demonstrator):
    """Pinhole views of equal bodies in equal postures are projectively the same, wherever the arms stand."""
    world = World(load_scene(scene))
    theta = np.radians(demonstrator)
    demo, _ = world.demo_images(theta)
    assert baselines.opencv_loop(world, demo, theta[None])[0] < 1e-6
    for direction in np.array([(1, 0), (0, 1), (-1, 0), (0, -1), (1, -1)]):
        E = baselines.opencv_loop(world, demo, theta + np.radians([[1], [2], [4], [8]]) * direction)
        assert E[0] > 1e-3 and (np.diff(E) > 0).all()


def test_opencvs_E_is_timed_beside_ours_and_its_own_figures_are_told(cv2, quick):
    result = speed.run("iiwa")
    assert result.opencv_why_not is None
    assert result.opencv.E_at_demonstrator < 1e-6 and result.opencv.E_median > 1
    assert result.opencv.loop_s > 20 * result.landscape_s["epipolar"]
    table = speed.speed_table(result)
    assert "OpenCV loop" in table and "OpenCV: perspective" in table and "pip install" not in table


@pytest.mark.parametrize(
    "points, installed, said",
    [
        (10, False, "OpenCV is not installed: pip install 'viewimit[opencv]'"),
        (5, True, "OpenCV is left out: its eight-point algorithm needs at least 8 points, got 5"),
    ],
)
def test_without_opencv_or_with_few_points_its_row_says_why(
    quick, coarse, monkeypatch, capsys, points, installed, said
):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: object() if installed else None)
    monkeypatch.setattr(baselines, "opencv_loop", None)
    assert main(["bench", "speed", "--n-points", str(points), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)["speed"]
    assert told["postures"] == 10 * 19
    assert told["opencv"] is None and told["opencv_why_not"] == said
    assert main(["bench", "speed", "--n-points", str(points)]) == 0
    assert capsys.readouterr().out.splitlines().count(f"  {said}") == 2  # over the range, and for one posture


def test_the_table_says_every_figure_in_120_columns():
    times = {1: 100e-6, 8: 200e-6}
    found = speed.Times(
        scene="panda",
        points=10,
        postures=16471,
        loop_postures=1647,
        landscape_s={"epipolar": 0.010, "linear": 0.003},
        many_s={"epipolar": 0.060, "linear": 0.042},
        condition_s=0.0125,
        batch_s=0.2,
        batch_condition_s=0.25,
        loop_s=4.0,
        fit_s={"epipolar": times, "linear": times},
        loop_posture_s=120e-6,
        batch_posture_s=140e-6,
        motion_s={"epipolar": {"broyden": 1.1e-3}, "linear": {"broyden": 0.9e-3}},
        opencv=speed.OpenCV(6.0, 230e-6, 1e-26, 20.0),
        opencv_why_not=None,
        batch_agreement=1e-13,
        loop_agreement=2e-13,
        condition_agreement=3e-13,
    )
    rows = {line[:62].strip(): line[62:].split() for line in speed.speed_table(found).splitlines()}
    assert max(map(len, speed.speed_table(found).splitlines())) <= 120
    assert rows["epipolar, 100 points"] == ["60.0", "ms", "6.0", "x"]
    assert rows["linear, 100 points"] == ["42.0", "ms", "14.0", "x"]
    assert rows["numpy batch: eigh and solve"] == ["200.0", "ms", "20.0", "x"]
    assert rows["numpy loop: eigh and lstsq (1647 postures, scaled)"] == ["4000.0", "ms", "400.0", "x"]
    assert rows["OpenCV loop: perspective, another E (1647 postures, scaled)"] == ["6000.0", "ms", "600.0", "x"]
    assert rows["numpy batch, without cond(A)"] == ["200.0", "ms", "16.0", "x"]
    assert rows["numpy batch with cond(A), eigvalsh of its AᵀA"] == ["250.0", "ms", "20.0", "x"]
    assert rows["numpy batch of one: eigh and solve"] == ["140", "µs", "1.4", "x"]
    assert rows["numpy loop: eigh and lstsq"] == ["120", "µs", "1.2", "x"]
    assert rows["OpenCV: perspective, another E"] == ["230", "µs", "2.3", "x"]
    assert rows["linear, 8 postures together"] == ["200", "µs", "2.0", "x"]
    assert rows["linear, broyden"] == ["900", "µs"]
    assert rows["E to the loop, 1647 postures"] == ["2.0e-13"]
    assert "(all postures)" in speed.speed_table(replace(found, loop_postures=16471))
