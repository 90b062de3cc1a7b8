"""The hand goes where the chain says, and a posture is found for it."""

import numpy as np
import pytest

from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World, hand_jacobian, hand_position, pose_for_hand


@pytest.fixture(scope="module")
def world():
    return World(load_scene("panda"))


def test_the_hand_moves_about_the_axes_of_the_joints(world):
    """A revolute joint moves a point by axis × (point - origin)."""
    theta = np.radians([30.0, -100.0])
    frames = world.link_frames(theta, world.T_world_demo)
    hand = hand_position(world, theta, world.T_world_demo)
    expected = []
    for joint in world.scene.moving:
        T, axis = frames[joint + 1], world.robot.joints[joint].axis
        expected.append(np.cross(T[:3, :3] @ axis / np.linalg.norm(axis), hand - T[:3, 3]))
    np.testing.assert_allclose(hand_jacobian(world, theta, world.T_world_demo), np.transpose(expected), atol=1e-4)


def test_a_posture_is_found_for_a_hand_that_can_be_there(world):
    aim = np.radians([62.0, -71.0])
    found = pose_for_hand(world, hand_position(world, aim, world.T_world_demo), np.radians([45.0, -90.0]))
    np.testing.assert_allclose(np.degrees(found), [62, -71], atol=0.1)


def test_out_of_reach_the_limits_hold(world):
    found = pose_for_hand(world, np.array([9.0, 0.0, -9.0]), np.radians([45.0, -90.0]))
    assert (found >= world.scene.lower).all() and (found <= world.scene.upper).all()
