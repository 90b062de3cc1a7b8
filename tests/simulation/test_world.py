"""The simulated world: images against the plain construction, and postures for the hand."""

import numpy as np
import pytest
from baselines import own_image

from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World, hand_jacobian, hand_position, pose_for_hand


@pytest.fixture(scope="module")
def world():
    return World(load_scene("panda"))


def test_images_of_a_grid_are_those_of_each_posture(world):
    rows, columns = np.radians([0, 40, 90]), np.radians([-180, -100, -20, 0])
    points, visible = world.own_images((rows[:, None], columns))
    assert points.shape == (3, 4, 10, 4) and visible.shape == (3, 4, 10, 2)
    for i, j in np.ndindex(3, 4):
        alone, alone_visible = world.own_images((rows[i], columns[j]))
        np.testing.assert_allclose(points[i, j], alone, atol=1e-10)
        np.testing.assert_array_equal(visible[i, j], alone_visible)
        np.testing.assert_allclose(alone, own_image(world, np.array([rows[i], columns[j]])), atol=1e-10)


def test_images_show_the_points_of_the_body_in_the_world(world):
    theta = np.radians([20, -70])
    for images, T, cameras in (
        (world.demo_images(theta), world.T_world_demo, world.demo_cameras),
        (world.own_images(theta), world.T_world_own, world.own_cameras),
    ):
        points = world.points_world(theta, T)
        expected = np.concatenate([camera.project(points.T)[0] for camera in cameras]).T
        np.testing.assert_allclose(images[0], expected, atol=1e-10)


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
