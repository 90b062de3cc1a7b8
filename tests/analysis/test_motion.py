"""Motions stay within limits, draw what they are named for, and come back from a file; broken files are told."""

import json

import numpy as np
import pytest

from viewimit.analysis import trajectory
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World, hand_position


@pytest.fixture(scope="module")
def world():
    return World(load_scene("panda"))


@pytest.mark.parametrize("posture", [(45, -90), (0, 0), (90, -180), (88, -3)])
def test_the_sinusoid_swings_each_joint_k_times_within_its_limits(world, posture):
    made = trajectory.sinusoid(world, np.radians(posture), frames=360)
    theta = np.array(made.theta_deg)
    low, high = np.transpose(world.scene.range_deg)
    assert (theta >= low - 1e-6).all() and (theta <= high + 1e-6).all()
    np.testing.assert_allclose(np.ptp(theta, axis=0), 2 * trajectory.SWING_DEG, rtol=1e-3)
    centred = theta - (theta.max(0) + theta.min(0)) / 2
    turns = [(np.diff(np.sign(centred[1:-1, k])) != 0).sum() for k in range(2)]
    assert turns == [1, 3]  # sin t crosses its middle once between the ends of a period, sin 2t three times
    assert made.seconds == pytest.approx(359 * trajectory.STEP_S)


def test_the_hand_draws_its_circle_from_where_it_is(world):
    theta = np.radians([45.0, -90.0])
    made = trajectory.hand_circle(world, theta, frames=40)
    hand = np.array([hand_position(world, posture, world.T_world_demo) for posture in made.theta])
    np.testing.assert_allclose(hand[0], hand_position(world, theta, world.T_world_demo), atol=1e-4)
    np.testing.assert_allclose(hand[0], hand[-1], atol=1e-3)
    centre = hand[:-1].mean(0)
    np.testing.assert_allclose(np.linalg.norm(hand - centre, axis=1), trajectory.RADIUS_M, atol=2e-3)
    _, sizes, _ = np.linalg.svd(hand - centre)
    assert sizes[2] < 1e-3 * sizes[0]  # in a plane


def test_a_motion_comes_back_from_its_file(world, tmp_path):
    made = trajectory.sinusoid(world, np.radians([30.0, -60.0]), frames=12)
    (tmp_path / "wave.json").write_bytes(trajectory.encode_motion(made))
    assert trajectory.load_motion(tmp_path / "wave.json", world.scene) == made


GOOD = {
    "format": trajectory.FORMAT,
    "name": "wave",
    "joints": [2, 4],
    "step_s": 0.05,
    "theta_deg": [[45, -90], [46, -91]],
}


@pytest.mark.parametrize(
    "change, message",
    [
        ({"format": "viewimit motion 9"}, "format 'viewimit motion 9' is not"),
        ({"joints": [2, 5]}, "it moves joints 2, 5, but in this scene joints 2, 4 move"),
        ({"theta_deg": [[45, -90]]}, "2 to 5000 frames, this one 1"),
        ({"theta_deg": [[45, -90]] * 5001}, "2 to 5000 frames, this one 5001"),
        ({"theta_deg": [[45, -90], [46]]}, "frame 1, demonstrator's posture needs 2 angles"),
        ({"theta_deg": [[45, -90], [46, 20]]}, "frame 1, demonstrator's joint 4 at 20° is outside"),
        ({"theta_deg": [["left", -90], [46, 20]]}, r"not a recorded motion: .*\$.theta_deg\[0\]\[0\]"),
        ({"step_s": 0}, "step_s must be between 0.001 and 10 s, got 0"),
        ({"colour": "red"}, "not a recorded motion: .*colour"),
        ({"name": None}, "not a recorded motion: .*name"),
        ({"name": "w" * 201}, "not a recorded motion: .*length <= 200.*name"),
    ],
)
def test_what_is_no_motion_of_this_scene_is_told(world, tmp_path, change, message):
    path = tmp_path / "wave.json"
    path.write_text(json.dumps({**GOOD, **change}))
    with pytest.raises(ValueError, match=f"wave.json: .*{message}"):
        trajectory.load_motion(path, world.scene)
