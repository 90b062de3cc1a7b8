"""The projective combination is exact for cameras with parallel axes, and is what a plain implementation says."""

import numpy as np
import pytest

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.estimation.transfers import projective
from viewimit.estimation.transfers.transfer import conflict
from viewimit.estimation.views import FourViews
from viewimit.geometry.rigid import rotation_from_rpy
from viewimit.simulation.camera import Lens, StereoHead
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


def seen(demo, own):
    return FourViews(demo, own, np.ones(own.shape[:-1] + (4,), bool))


def heads_views(rng, count=12, depth=2.5):
    """A rigid body seen by one head twice, turned and moved in between, and each body placed anew."""
    lens = Lens((300.0, 300.0), (320, 240))
    head = StereoHead((0, 0, 0), 0.5, 640, 480, lens, lens)
    body = rng.uniform(-0.4, 0.4, (count, 3))
    images = []
    for _ in range(2):
        target = np.array([depth, rng.uniform(-0.5, 0.5), rng.uniform(-0.3, 0.3)])
        placed = body @ rotation_from_rpy(rng.uniform(-0.4, 0.4, 3)).T + target
        images.append(np.concatenate([camera.project(placed.T)[0].T for camera in head.gaze(target)], 1))
    return seen(*images)


@pytest.mark.parametrize("seed", range(8))
def test_with_parallel_axes_it_is_exact_up_to_its_prior(seed):
    """The affine transfer of the same views is off by pixels; this one by what the prior holds back."""
    views = heads_views(np.random.default_rng(seed))
    e = projective.fit(views).residual(views)
    assert conflict(e) < 1e-4


def test_the_minimum_of_E_is_at_the_true_posture():
    world = World(load_scene("panda"))
    demo, _ = world.demo_images(np.radians([45, -90]))
    found = landscape_over(world, projective.fit, demo, np.ones((10, 2), bool), grid_axes(world))
    np.testing.assert_allclose(np.degrees(found.minimum), [45, -90], atol=1e-9)
    assert found.E.min() < 1e-6
    assert found.E.max() == pytest.approx(226, abs=1)  # a prototype's figure, with four steps and another prior
    assert len(found.local_minima()) == 1 and found.basin_fraction() == 1.0


def plain(demo, own, steps, prior):
    """Variable projection posture by posture, with QR and explicit Jacobians. → own points found, (N, 4) px"""
    N = len(demo)
    u = np.sqrt(N) * np.linalg.svd(demo - demo.mean(0), full_matrices=False)[0][:, :3]
    Y = own - own.mean(0)
    weight, p = prior * (Y**2).sum() / N, np.zeros(3)
    for step in range(steps + 1):
        rho = np.maximum(1 + u @ p, projective.MIN_DEPTH)
        Q, _ = np.linalg.qr(np.column_stack([np.ones(N), u]) / rho[:, None])
        found = Q @ (Q.T @ Y)
        if step == steps:
            return found + own.mean(0)
        J = np.stack(
            [
                (found * (u[:, j] / rho)[:, None] - Q @ (Q.T @ (found * (u[:, j] / rho)[:, None]))).ravel()
                for j in range(3)
            ],
            1,
        )
        p = p + np.linalg.solve(J.T @ J + weight * np.eye(3), -J.T @ (Y - found).ravel() - weight * p)
        p = p * min(1, projective.MAX_P / max(np.linalg.norm(p), 1e-300))


@pytest.mark.parametrize("postures", [40, 60])
def test_a_batch_equals_a_plain_implementation_posture_by_posture(postures):
    """A short one by LAPACK, and a long one by array operations."""
    world, rng = World(load_scene("iiwa")), np.random.default_rng(3)
    demo, _ = world.demo_images(np.radians([40, -70]))
    own, _ = world.own_images(rng.uniform(world.scene.lower, world.scene.upper, (postures, 2)).T)
    assert (own[..., 0].size > projective.MAX_POINTS_LAPACK) == (postures == 60)
    recovered = projective.fit(seen(demo, own)).recover(demo[:, :2], demo[:, 2:])
    expected = [plain(demo, each, projective.GAUSS_NEWTON_STEPS, projective.PRIOR) for each in own]
    np.testing.assert_allclose(recovered, expected, atol=1e-8)
    one = projective.fit(seen(demo, own[7])).recover(demo[:, :2], demo[:, 2:])
    np.testing.assert_allclose(one, recovered[7], atol=1e-9)
    demos = demo + np.random.default_rng(1).normal(size=own.shape)
    batched = projective.fit(seen(demos, own)).recover(demos[..., :2], demos[..., 2:])
    expected = [plain(*each, projective.GAUSS_NEWTON_STEPS, projective.PRIOR) for each in zip(demos, own)]
    np.testing.assert_allclose(batched, expected, atol=1e-8)


def test_it_recovers_points_that_it_was_not_fitted_to():
    views = heads_views(np.random.default_rng(5), count=30)
    fitted = projective.fit(views.select(np.arange(20)))
    e = views.own[20:] - fitted.recover(views.demo_left[20:], views.demo_right[20:])
    assert np.abs(e).max() < 0.5
