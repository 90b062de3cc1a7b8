"""The baselines are the paper's equations and OpenCV's perspective ones; `bench speed` times what it says."""

import importlib.util
from functools import partial

import baselines
import numpy as np
import pytest

from viewimit.analysis import landscape
from viewimit.estimation.transfers import TRANSFERS
from viewimit.experiments.bench import speed
from viewimit.servo import SERVOS
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


@pytest.fixture
def quick(monkeypatch):
    """10 x 19 postures, and few rounds"""
    for name, few in {"ROUNDS": 3, "SLOW_ROUNDS": 1, "SINGLE_CALLS": 20, "MOTIONS": 3}.items():
        monkeypatch.setattr(speed, name, few)
    for module in (speed, landscape, baselines):
        monkeypatch.setattr(module, "grid_axes", partial(landscape.grid_axes, step_deg=10.0))


def test_the_baselines_agree_with_each_other():
    world = World(load_scene("iiwa"))
    demo, _ = world.demo_images(np.radians([45, -60]))
    postures = np.random.default_rng(0).uniform(world.scene.lower, world.scene.upper, (100, 2))
    E, condition = baselines.batch(world, demo, postures, with_condition=True)
    np.testing.assert_allclose(E, baselines.loop(world, demo, postures), rtol=1e-9)
    assert condition.min() >= 1
    own = baselines.own_image(world, postures[7])
    np.testing.assert_allclose(own, world.own_images(postures[7])[0], rtol=1e-12)
    assert baselines.conflict(demo, own) == pytest.approx(E[7], rel=1e-9)


def test_the_command_times_every_transfer_and_servo(quick, ask_json):
    status, told = ask_json("bench", "speed", "--n-points", 16)
    found = told["speed"]
    assert status == 0 and found["postures"] == 10 * 19 and set(found["landscape_s"]) == set(TRANSFERS)
    assert {name: set(times) for name, times in found["motion_s"].items()} == {name: set(SERVOS) for name in TRANSFERS}


@pytest.mark.parametrize(
    "points, said", [(10, "pip install 'viewimit[opencv]'"), (5, "needs at least 8 points, got 5")]
)
def test_E_is_timed_beside_the_same_E_and_without_opencv_or_with_few_points_its_row_says_why(
    quick, monkeypatch, capsys, points, said
):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None if points == 10 else object())
    baselines.main(["--n-points", str(points)])
    told = capsys.readouterr().out
    batch, loop, condition = (float(line.split()[-1]) for line in told.splitlines()[-3:])
    assert said in told and max(batch, loop, condition) < 1e-8


@pytest.mark.parametrize("scene", ["panda", "iiwa", "panda-facing", "panda-verged"])
@pytest.mark.parametrize("demonstrator", [(45, -90), (20, -40), (80, -110)])
def test_opencvs_E_is_0_in_the_demonstrators_posture_alone_and_grows_away_from_it(scene, demonstrator):
    """Pinhole views of equal bodies in equal postures are projectively the same, wherever the arms stand."""
    pytest.importorskip("cv2")
    world = World(load_scene(scene))
    theta = np.radians(demonstrator)
    demo, _ = world.demo_images(theta)
    assert baselines.opencv_loop(world, demo, theta[None])[0] < 1e-6
    for direction in np.array([(1, 0), (0, 1), (-1, 0), (0, -1), (1, -1)]):
        E = baselines.opencv_loop(world, demo, theta + np.radians([[1], [2], [4], [8]]) * direction)
        assert E[0] > 1e-3 and (np.diff(E) > 0).all()
