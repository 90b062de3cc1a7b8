"""The benchmark measures what it says; its baselines are the paper's equations, and OpenCV's perspective ones."""

import importlib.util
import json
from functools import partial

import numpy as np
import pytest

from viewimit.analysis import landscape
from viewimit.commands.cli import main
from viewimit.estimation.transfers import TRANSFERS
from viewimit.experiments.bench import baselines, speed
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


def test_the_benchmark_compares_like_with_like(quick, coarse):
    shares = []
    result = speed.run(progress=shares.append)
    assert (result.postures, result.loop_postures) == (10 * 19, 10 * 19 // 50)
    assert result.batch_agreement < 1e-8 and result.loop_agreement < 1e-8 and result.condition_agreement < 1e-8
    assert all(set(times) == {1, speed.BATCH} for times in result.fit_s.values())
    assert {name: set(times) for name, times in result.motion_s.items()} == {name: set(SERVOS) for name in TRANSFERS}
    assert shares == sorted(shares) and shares[-1] == 1


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


def test_opencvs_E_is_timed_beside_ours_and_its_own_figures_are_told(cv2, quick, coarse):
    result = speed.run("iiwa")
    assert result.opencv_why_not is None
    assert result.opencv.E_at_demonstrator < 1e-6 and result.opencv.E_median > 1
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
