"""The simulated world: images against the plain construction, disturbance against its settings."""

import numpy as np
import pytest

from viewimit.experiments.bench.baselines import own_image
from viewimit.perception.disturbance import Disturbance
from viewimit.simulation.actuator import Actuator
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


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


def test_noise_has_its_standard_deviation_and_grows_in_place():
    points, visible = np.zeros((5000, 4)), np.ones((5000, 2), bool)

    def noise(sigma):
        return Disturbance(noise_px=sigma).apply(points, visible, [1])[0]

    # the standard deviation of 20000 draws is known to 1/√40000, five times that is allowed
    assert noise(0.5).std() == pytest.approx(0.5, rel=0.025)
    np.testing.assert_allclose(noise(1.0), 2 * noise(0.5), atol=1e-14)


def test_a_larger_share_of_missing_points_loses_the_same_ones_first():
    points, visible = np.zeros((5000, 4)), np.ones((5000, 2), bool)

    def seen(share):
        return Disturbance(missing=share).apply(points, visible, [1])[1]

    assert seen(0.0).all() and not seen(1.0).any()
    assert np.mean(~seen(0.1)) == pytest.approx(0.1, abs=0.015)  # five standard deviations
    assert not (seen(0.3) & ~seen(0.1)).any()


def test_undisturbed_looks_are_the_images(world):
    theta_demo, theta_own = np.radians([45, -90]), np.radians([10, -30])
    views = world.look(theta_demo, theta_own)
    np.testing.assert_array_equal(views.demo, world.demo_images(theta_demo)[0])
    np.testing.assert_array_equal(views.own, world.own_images(theta_own)[0])


def test_an_arm_obeys_by_its_gain_and_in_its_steps():
    theta, command = np.radians([10.0, -20.0]), np.radians([10.0, -4.0])
    np.testing.assert_allclose(Actuator().move(theta, command), theta + command)
    np.testing.assert_allclose(np.degrees(Actuator(0.05).move(theta, command)), [20.5, -24.2])
    np.testing.assert_allclose(np.degrees(Actuator(0.05, 0.4).move(theta, command)), [20.5, -24.2], atol=0.2 + 1e-9)
    steps = np.degrees(Actuator(0.05, 0.4).move(theta, command)) / 0.4
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
