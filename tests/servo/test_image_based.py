"""Image-based servoing and the learned images: exact on linear images, blind to what is not seen, within limits."""

from dataclasses import replace

import numpy as np
import pytest

from viewimit.servo import Observation
from viewimit.servo.image_based import LONGEST, towards
from viewimit.servo.image_model import SOFT, ImageModel

N = 6


class LinearWorld:
    """own(θ) = y + J θ exactly."""

    def __init__(self, m, seed=0):
        rng = np.random.default_rng(seed)
        self.J, self.y = rng.normal(0, 100, (N, 4, m)), rng.uniform(0, 240, (N, 4))

    def images(self, theta):
        return self.y + self.J @ theta

    def seen(self, theta, limit=2.0):
        m = len(theta)
        own = self.images(theta)
        return Observation(own, np.ones((N, 2), bool), np.nan, theta, np.full(m, -limit), np.full(m, limit), 0)

    def learned(self):
        """After one motion a joint, each large beside SOFT."""
        theta = np.zeros(self.J.shape[-1])
        model = ImageModel.start(self.seen(theta))
        for joint in range(len(theta)):
            theta = theta + 0.5 * np.eye(len(theta))[joint]
            model = model.learn(self.seen(theta), soft=0.0)
        return model, theta


@pytest.mark.parametrize("m", [1, 2, 7])
def test_a_linear_map_is_learned_by_one_motion_a_joint(m):
    world = LinearWorld(m)
    model, theta = world.learned()
    np.testing.assert_allclose(model.jacobian, world.J, atol=1e-8)
    other = np.random.default_rng(1).normal(size=m)
    np.testing.assert_allclose(model.predict(other), world.images(other), atol=1e-7)


def test_small_motions_teach_less_by_how_small_they_are():
    """Broyden's update times |u|²/(|u|² + SOFT²)."""
    world = LinearWorld(1)
    for size in (0.3 * SOFT, SOFT, 10 * SOFT):
        model = ImageModel.start(world.seen(np.zeros(1))).learn(world.seen(np.array([size])))
        np.testing.assert_allclose(model.jacobian, world.J * size**2 / (size**2 + SOFT**2), rtol=1e-9)


def test_points_teach_only_if_seen_at_both_ends():
    world = LinearWorld(2)
    before, after = world.seen(np.zeros(2)), world.seen(np.array([0.3, 0.0]))
    hidden = after.seen.copy()
    hidden[1, 0] = False
    model = ImageModel.start(before).learn(replace(after, seen=hidden, own=np.full_like(after.own, 7e5)))
    assert not model.jacobian[1, :2].any() and (model.last.own[1, :2] == before.own[1, :2]).all()
    model = ImageModel.start(replace(before, seen=hidden)).learn(after)
    assert not model.jacobian[1, :2].any() and (model.last.own[1, :2] == after.own[1, :2]).all()
    np.testing.assert_allclose(model.jacobian[2, :, 0], world.J[2, :, 0], rtol=1e-3)


@pytest.mark.parametrize("m", [1, 2, 3])
def test_one_motion_reaches_a_target_within_reach(m):
    world = LinearWorld(m)
    model, theta = world.learned()
    aim = theta + np.random.default_rng(2).uniform(-0.1, 0.1, m)
    step = towards(model, world.seen(theta), world.images(aim), np.ones(N, bool))
    np.testing.assert_allclose(theta + step, aim, atol=1e-4)  # the damping holds back one part in a million


def test_a_long_way_is_shortened_and_keeps_its_direction():
    world = LinearWorld(2)
    model, theta = world.learned()
    way = np.array([1.0, -0.4])
    step = towards(model, world.seen(theta), world.images(theta + way), np.ones(N, bool))
    assert np.abs(step).max() == pytest.approx(LONGEST)
    np.testing.assert_allclose(step / step[0], way / way[0], atol=1e-3)


def test_limits_hold():
    world = LinearWorld(2)
    model, theta = world.learned()
    seen = world.seen(theta, limit=float(theta.max()) + 0.02)
    step = towards(model, seen, world.images(theta + (0.15, 0.15)), np.ones(N, bool))
    assert (theta + step <= seen.upper + 1e-12).all()


def test_unwanted_unseen_and_unknown_points_have_no_say():
    world = LinearWorld(2)
    model, theta = world.learned()
    seen = world.seen(theta)
    aim = world.images(theta + (0.05, -0.02))
    wanted, hidden, target = np.ones(N, bool), seen.seen.copy(), aim.copy()
    wanted[0], hidden[1, 1], target[2] = False, False, np.nan
    target[0] += 500
    target[1, 2:] += 500
    step = towards(model, replace(seen, seen=hidden), target, wanted)
    np.testing.assert_allclose(step, (0.05, -0.02), atol=1e-4)
    nothing = towards(model, seen, np.full_like(aim, np.nan), np.ones(N, bool))
    assert not nothing.any()


def test_what_the_images_cannot_tell_is_left_alone():
    """Both joints move the images alike: of all motions that do, the damping takes the shortest."""
    world = LinearWorld(2)
    world.J[..., 1] = world.J[..., 0]
    model = replace(ImageModel.start(world.seen(np.zeros(2))), jacobian=world.J)
    step = towards(model, world.seen(np.zeros(2)), world.images(np.array([0.1, 0.0])), np.ones(N, bool))
    np.testing.assert_allclose(step, (0.05, 0.05), atol=1e-4)
