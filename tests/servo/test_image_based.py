"""Image-based servoing and the learned images: exact on linear images, blind to what is not seen, within limits."""

from dataclasses import replace

import numpy as np
import pytest
from linear_world import LinearWorld

from viewimit.servo.image_jacobian import MAX_STEP_RAD, SOFT_RAD, BroydenModel

N = 6


def world_of(m):
    return LinearWorld(m, np.random.default_rng(0), N)


def learned(world):
    """After one motion a joint, each large beside SOFT_RAD."""
    theta = np.zeros(world.J.shape[-1])
    model = BroydenModel.start(world.seen(theta))
    for joint in range(len(theta)):
        theta = theta + 0.5 * np.eye(len(theta))[joint]
        model = model.update(world.seen(theta), soft=0.0)
    return model, theta


@pytest.mark.parametrize("m", [1, 2, 7])
def test_a_linear_map_is_learned_by_one_motion_a_joint(m):
    world = world_of(m)
    model, theta = learned(world)
    np.testing.assert_allclose(model.jacobian, world.J, atol=1e-8)
    other = np.random.default_rng(1).normal(size=m)
    np.testing.assert_allclose(model.predict(other), world.images(other), atol=1e-7)


def test_small_motions_teach_less_by_how_small_they_are():
    """Broyden's update times |u|²/(|u|² + SOFT²)."""
    world = world_of(1)
    for size in (0.3 * SOFT_RAD, SOFT_RAD, 10 * SOFT_RAD):
        model = BroydenModel.start(world.seen(np.zeros(1))).update(world.seen(np.array([size])))
        np.testing.assert_allclose(model.jacobian, world.J * size**2 / (size**2 + SOFT_RAD**2), rtol=1e-9)


def test_points_teach_only_if_seen_at_both_ends():
    world = world_of(2)
    before, after = world.seen(np.zeros(2)), world.seen(np.array([0.3, 0.0]))
    hidden = after.seen.copy()
    hidden[1, 0] = False
    model = BroydenModel.start(before).update(replace(after, seen=hidden, own=np.full_like(after.own, 7e5)))
    assert not model.jacobian[1, :2].any() and (model.last.own[1, :2] == before.own[1, :2]).all()
    model = BroydenModel.start(replace(before, seen=hidden)).update(after)
    assert not model.jacobian[1, :2].any() and (model.last.own[1, :2] == after.own[1, :2]).all()
    np.testing.assert_allclose(model.jacobian[2, :, 0], world.J[2, :, 0], rtol=1e-3)


@pytest.mark.parametrize("m", [1, 2, 3])
def test_one_motion_reaches_a_target_within_reach(m):
    world = world_of(m)
    model, theta = learned(world)
    aim = theta + np.random.default_rng(2).uniform(-0.1, 0.1, m)
    step = model.step_towards(world.seen(theta), world.images(aim), np.ones(N, bool))
    np.testing.assert_allclose(theta + step, aim, atol=1e-4)  # the damping holds back one part in a million


def test_a_long_way_is_shortened_and_keeps_its_direction():
    world = world_of(2)
    model, theta = learned(world)
    way = np.array([1.0, -0.4])
    step = model.step_towards(world.seen(theta), world.images(theta + way), np.ones(N, bool))
    assert np.abs(step).max() == pytest.approx(MAX_STEP_RAD)
    np.testing.assert_allclose(step / step[0], way / way[0], atol=1e-3)


def test_limits_hold():
    world = world_of(2)
    model, theta = learned(world)
    seen = world.seen(theta, limit=float(theta.max()) + 0.02)
    step = model.step_towards(seen, world.images(theta + (0.15, 0.15)), np.ones(N, bool))
    assert (theta + step <= seen.upper + 1e-12).all()


def test_unwanted_unseen_and_unknown_points_have_no_say():
    world = world_of(2)
    model, theta = learned(world)
    seen = world.seen(theta)
    aim = world.images(theta + (0.05, -0.02))
    wanted, hidden, target = np.ones(N, bool), seen.seen.copy(), aim.copy()
    wanted[0], hidden[1, 1], target[2] = False, False, np.nan
    target[0] += 500
    target[1, 2:] += 500
    step = model.step_towards(replace(seen, seen=hidden), target, wanted)
    np.testing.assert_allclose(step, (0.05, -0.02), atol=1e-4)
    nothing = model.step_towards(seen, np.full_like(aim, np.nan), np.ones(N, bool))
    assert not nothing.any()


def test_what_the_images_cannot_tell_is_left_alone():
    """Both joints move the images alike: of all motions that do, the damping takes the shortest."""
    world = world_of(2)
    world.J[..., 1] = world.J[..., 0]
    model = replace(BroydenModel.start(world.seen(np.zeros(2))), jacobian=world.J)
    step = model.step_towards(world.seen(np.zeros(2)), world.images(np.array([0.1, 0.0])), np.ones(N, bool))
    np.testing.assert_allclose(step, (0.05, 0.05), atol=1e-4)
