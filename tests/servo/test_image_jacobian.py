"""Learned image Jacobians and image-based servoing: exact on linear images, blind to hidden points, within limits."""

from dataclasses import replace

import numpy as np
import pytest
from linear_world import LinearWorld

from viewimit.servo import Observation
from viewimit.servo.image_jacobian import SOFT_RAD, BroydenModel, RecursiveJacobian

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
def test_one_motion_of_each_joint_determines_a_linear_map(m):
    world = world_of(m)
    model, theta = learned(world)
    np.testing.assert_allclose(model.jacobian, world.J, atol=1e-8)
    other = np.random.default_rng(1).normal(size=m)
    np.testing.assert_allclose(model.predict(other), world.images(other), atol=1e-7)


def test_small_motions_teach_less():
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


def test_points_that_are_hidden_unknown_or_not_followed_are_ignored():
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


def test_unobservable_motions_are_not_made():
    """Both joints move the images alike: of all motions that do, the damping takes the shortest."""
    world = world_of(2)
    world.J[..., 1] = world.J[..., 0]
    model = replace(BroydenModel.start(world.seen(np.zeros(2))), jacobian=world.J)
    step = model.step_towards(world.seen(np.zeros(2)), world.images(np.array([0.1, 0.0])), np.ones(N, bool))
    np.testing.assert_allclose(step, (0.05, 0.05), atol=1e-4)


# Recursive estimates


def walk(rng, m=3, points=6, motions=9, hidden=0.25):
    """Observations of images that have nothing to do with the motions, with points that come and go."""
    theta, wide = np.zeros(m), np.full(m, 9.0)
    for k in range(motions):
        yield Observation(
            rng.uniform(0, 300, (points, 4)), rng.uniform(size=(points, 2)) > hidden, 0.0, theta, -wide, wide, k
        )
        theta = theta + rng.normal(0, 0.2, m)


@pytest.mark.parametrize("soft", [0.0, 0.05])
def test_a_filter_without_memory_of_its_covariance_is_broydens_update(soft):
    """P' = q I, so that k = h/(r/q + hᵀh): Broyden's, with soft² = r/q; what it remembers makes the difference."""
    q, first, *rest = 1e6, *walk(np.random.default_rng(1))
    filtered, broyden = RecursiveJacobian.start(first, 0.0), BroydenModel.start(first)
    remembering = filtered
    for seen in rest:
        r = max(soft**2, 1e-18) * q
        filtered, broyden = filtered.update(seen, r, q), broyden.update(seen, soft)
        remembering = remembering.update(seen, r, q)
        filtered = replace(filtered, covariance=np.zeros_like(filtered.covariance))
        np.testing.assert_allclose(filtered.jacobian, broyden.jacobian, rtol=1e-9, atol=1e-7)
        np.testing.assert_allclose(filtered.last.own, broyden.last.own, rtol=1e-9)
    assert np.abs(broyden.jacobian).max() > 100 and np.abs(remembering.jacobian - broyden.jacobian).max() > 10


@pytest.mark.parametrize("forgetting", [1.0, 0.9, 0.5])
def test_without_drift_it_is_weighted_least_squares_over_all_motions(forgetting):
    """Σ λ^(k-i) (Δy_i - j·h_i)² + λ^k |j|²/P_0 over the motions at both ends of which the point was seen is least."""
    rng = np.random.default_rng(2)
    first, *rest = walk(rng, points=4)
    P_0, model, before = 100.0, RecursiveJacobian.start(first, 100.0), first
    pairs_of = [[] for _ in range(8)]  # h and Δy, by point and image
    for seen in rest:
        model = model.update(seen, r=forgetting, forgetting=forgetting)
        h = seen.displacement - before.displacement
        for k in range(8):
            point, image = divmod(k, 2)
            columns = slice(2 * image, 2 * image + 2)
            if seen.seen[point, image] and before.seen[point, image]:
                pairs_of[k].append((h, (seen.own - before.own)[point, columns]))
        before = seen
    for k, pairs in enumerate(pairs_of):
        assert len(pairs) >= 2
        point, image = divmod(k, 2)
        weight = forgetting ** np.arange(len(pairs) - 1, -1, -1)
        H, dy = (np.array(column) for column in zip(*pairs))
        normal = (H * weight[:, None]).T @ H + forgetting ** len(pairs) / P_0 * np.eye(3)
        batch = np.linalg.solve(normal, (H * weight[:, None]).T @ dy).T
        np.testing.assert_allclose(model.jacobian[point, 2 * image : 2 * image + 2], batch, rtol=1e-7, atol=1e-7)
        np.testing.assert_allclose(model.covariance[point, image], np.linalg.inv(normal), rtol=1e-7)


def test_the_filters_covariance_is_that_of_its_errors():
    """A true Jacobian that is drawn from P_0, and measured with variance r: the errors are as P says."""
    rng, m, r, P_0 = np.random.default_rng(3), 2, 4.0, 100.0**2
    points, wide = 2000, np.full(2, 9.0)
    true, rest = rng.normal(0, 100.0, (points, 4, m)), rng.uniform(0, 300, (points, 4))
    theta = np.zeros(m)

    def seen(noise):
        own = rest + true @ theta + rng.normal(0, np.sqrt(noise), (points, 4))
        return Observation(own, np.ones((points, 2), bool), 0.0, theta, -wide, wide, 0)

    model = RecursiveJacobian.start(seen(0.0), P_0)
    for _ in range(4):
        model = replace(model, last=replace(model.last, own=rest + true @ theta))  # the end before, without noise
        theta = theta + rng.normal(0, 0.03, m)
        model = model.update(seen(r), r)
    whitened = np.linalg.solve(np.linalg.cholesky(model.covariance[0, 0]), (model.jacobian - true).reshape(-1, m).T)
    np.testing.assert_allclose(whitened @ whitened.T / whitened.shape[1], np.eye(m), atol=0.06)
    assert 0 < model.mean_gain < 1
