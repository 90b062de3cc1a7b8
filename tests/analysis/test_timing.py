"""Cameras that are not in time are noticed, with the shift; cameras in time never are."""

import numpy as np
import pytest

from viewimit.analysis.evaluation import evaluate
from viewimit.analysis.timing import find_time_shift
from viewimit.estimation.views import FourViews
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

FRAMES = 60


def swinging(t):
    """Joint angles at a moment, (2,) rad."""
    return np.radians([45 + 25 * np.sin(0.1 * t), -85 + 25 * np.sin(0.07 * t + 1)])


def still(t):
    return np.radians([45.0, -85.0])


def images(late, path=swinging, scene="panda", noise=0.3, seed=0, frames=FRAMES):
    """Both bodies, (T, 2N, 4) px; late(t): frames by which the right camera lags."""
    world = World(load_scene(scene), 10)

    def seen(t):
        views = world.look(path(t), path(t) + 0.15)
        return np.concatenate([views.demo, views.own])

    both = [np.concatenate([seen(t)[:, :2], seen(t - late(t))[:, 2:]], 1) for t in range(frames)]
    return np.array(both) + np.random.default_rng(seed).normal(0, noise, np.shape(both))


@pytest.mark.parametrize("scene", ["panda", "panda-toed"])
@pytest.mark.parametrize("late", [2, -3, 10])
def test_the_shift_of_a_late_camera_is_found(scene, late):
    found = find_time_shift(images(lambda t: late, scene=scene))
    assert found is not None and len(found.parts) == 1
    assert found.parts[0][1] == pytest.approx(late, abs=0.25) and found.shifted_px < 0.4 < found.rms_px


def test_time_stamps_and_missing_frames_hide_no_shift():
    there = [t for t in range(40) if t not in (7, 8, 20)]
    left, right = np.split(images(lambda t: 2)[there].reshape(-1, 2, 10, 4), 2, -1)
    views = FourViews.from_arrays(left[:, 0], right[:, 0], left[:, 1], right[:, 1])
    found = evaluate(views, frames=[10**18 + 33_333_333 * t + 1000 * (t % 3) for t in there]).time_shift
    assert found is not None and found.parts[0] == (0, pytest.approx(2, abs=0.25))


@pytest.mark.parametrize("path, noise, seed", [(swinging, 0.0, 0), (swinging, 0.5, 1), (still, 0.5, 0)])
@pytest.mark.parametrize("wrong", ["nothing", "a point", "a lens"])
def test_cameras_in_time_are_not_doubted(seed, path, noise, wrong):
    seen = images(lambda t: 0, path, "panda-toed", noise, seed, frames=(12, 40)[seed])
    if wrong == "a point":
        seen[:, 8, 2:] += (3, 8)
    if wrong == "a lens":
        halves = (seen.reshape(*seen.shape[:2], 2, 2) - (320, 120)) / 256
        seen += (256 * halves * -0.05 * (halves**2).sum(-1, keepdims=True)).reshape(seen.shape)
    assert find_time_shift(seen) is None
