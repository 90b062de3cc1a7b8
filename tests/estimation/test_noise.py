"""Noise: whitened residuals near the demonstrator, affine whitening, E that noise explains, and rounding."""

from itertools import product

import numpy as np
import pytest
from scipy.stats import chi2, norm

from viewimit.estimation.noise import (
    HomographyResiduals,
    affine_whitening,
    conflict_quantile,
    rounding_std,
)
from viewimit.estimation.residuals import conflict
from viewimit.estimation.transfers import linear
from viewimit.estimation.views import FourViews
from viewimit.experiments.bench.bound import bound
from viewimit.geometry.rectification import fit_rectification
from viewimit.servo.least_squares import minimise
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

# Homography of space


THERE = np.radians([45.0, -90.0])


@pytest.fixture(scope="module")
def world():
    return World(load_scene("panda-toed"), 16)


@pytest.fixture(scope="module")
def rectification(world):
    rng = np.random.default_rng(0)
    own = [world.own_images(theta)[0] for theta in rng.uniform(world.scene.lower, world.scene.upper, (6, 2))]
    matches = np.concatenate([world.demo_images(THERE)[0], *own])
    return fit_rectification(matches[:, :2], matches[:, 2:])


def own_at(world, theta):
    return world.own_images(tuple(np.moveaxis(theta, -1, 0)))[0]


def noisy(views, rng, demo_px, own_px):
    return FourViews(
        views.demo + demo_px * rng.standard_normal(views.demo.shape),
        views.own + own_px * rng.standard_normal(views.own.shape),
        views.visible,
    )


def found_near(world, views, rectification, own_share):
    by = HomographyResiduals.whitened_at(views, rectification, own_share)
    low, high = THERE - 0.3, THERE + 0.3
    return minimise(lambda theta: by.residual(views.with_own(own_at(world, theta))), THERE[None], low, high).theta


def test_whitened_E_is_zero_at_the_demonstrators_posture_only(world, rectification):
    views = world.look(THERE, THERE)
    around = THERE + np.radians(np.stack(np.meshgrid(*[np.arange(-10, 11, 2.0)] * 2, indexing="ij"), -1))
    E = conflict(
        HomographyResiduals.whitened_at(views, rectification, 0.1).residual(views.with_own(own_at(world, around)))
    )
    assert E[5, 5] < 1e-18
    assert np.delete(E.ravel(), 60).min() > 1e-3


def partially_visible(views, rng, share=0.3):
    """The same, some points of the demonstrator without one of their images."""
    visible = views.visible.copy()
    points = rng.choice(len(visible), int(share * len(visible)), replace=False)
    visible[points, rng.integers(2, size=len(points))] = False
    demo = np.where(np.repeat(visible[:, :2], 2, 1), views.demo, np.nan)
    return FourViews(demo, views.own, visible)


def test_a_partially_visible_point_counts_and_its_missing_coordinates_do_not(world, rectification):
    views = partially_visible(world.look(THERE, THERE), np.random.default_rng(5))
    around = THERE + np.radians(np.stack(np.meshgrid(*[np.arange(-10, 11, 2.0)] * 2, indexing="ij"), -1))
    own = own_at(world, around)
    for by in (
        HomographyResiduals.unweighted(views, rectification),
        HomographyResiduals.whitened_at(views, rectification, 0.1),
    ):
        e = by.residual(views.with_own(own))
        E = conflict(e)
        assert E[5, 5] < 1e-18 and np.delete(E.ravel(), 60).min() > 1e-4
        assert (e[..., np.repeat(~views.visible[:, :2], 2, 1)] == 0).all()
    elsewhere = FourViews(np.where(np.isnan(views.demo), 77.0, views.demo), views.own, views.visible)
    np.testing.assert_array_equal(e, by.residual(elsewhere.with_own(own)))


def test_unweighted_residuals_count_the_row_that_both_images_share_once(world, rectification):
    views = partially_visible(world.look(THERE, THERE), np.random.default_rng(5))
    weight = HomographyResiduals.unweighted(views, rectification).weight
    in_both, left_only = views.visible[:, :2].all(1), views.visible[:, 0] & ~views.visible[:, 1]
    np.testing.assert_allclose(
        weight[in_both], np.broadcast_to(np.diag([1, 0.5, 1, 0.5]) ** 0.5, (in_both.sum(), 4, 4))
    )
    np.testing.assert_allclose(weight[left_only], np.broadcast_to(np.diag([1, 1, 0, 0]), (left_only.sum(), 4, 4)))


def test_a_batch_equals_the_loop(world, rectification):
    views = world.look(THERE, THERE)
    by = HomographyResiduals.whitened_at(views, rectification, 0.1)
    own = own_at(world, THERE + np.random.default_rng(1).uniform(-0.2, 0.2, (2, 3, 2)))
    together = by.residual(views.with_own(own))
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(together[index], by.residual(views.with_own(own[index])), atol=1e-7)


def test_with_noise_in_the_demonstrators_images_only_the_posture_reaches_the_cramer_rao_bound(world, rectification):
    exact, rng, px = world.look(THERE, THERE), np.random.default_rng(3), 0.05
    errors = [found_near(world, noisy(exact, rng, px, 0.0), rectification, 0.0) - THERE for _ in range(60)]
    least = bound(world, THERE, px)
    rms = np.sqrt(np.mean(np.square(errors), 0))
    assert (rms < 1.25 * least).all() and (rms > 0.75 * least).all()
    np.testing.assert_allclose(bound(world, THERE, 3 * px), 3 * least)


# Affine whitening


def test_affine_whitening_makes_the_covariance_of_noise_the_identity():
    """e = own noise - B (demonstrator's noise): covariance I + BBᵀ, and the identity once weighed."""
    world = World(load_scene("panda"), 20)
    views = world.look(np.radians([45, -90]), np.radians([45, -90]))
    C = affine_whitening(views)
    B = linear.fit(views).matrix  # (4, 4): [L; R] of [l; r]
    rng = np.random.default_rng(0)
    demo, own = rng.normal(size=(2, 200_000, 4))
    e = own - demo @ B.T
    assert np.cov(e.T).max() > 1.5
    np.testing.assert_allclose(np.cov((e @ C).T), np.eye(4), atol=0.02)


# E that noise explains


def test_the_conflict_quantile_is_the_quantile_of_chi_square():
    """The cube root of χ² is normal up to terms of 1/freedom: 0.06/freedom of it here, and 4 % at most."""
    points, noise_px = 12, 0.3
    for deviations, freedom in product((0.0, 1.0, 2.0, 3.0), (1, 2, 4, 10, 40, 200)):
        quantile = chi2.ppf(norm.cdf(deviations), freedom)
        E = conflict_quantile(points, freedom, noise_px, deviations)
        assert E == pytest.approx(noise_px**2 * quantile / (2 * points), rel=min(0.06 / freedom, 0.04))


def test_noise_exceeds_the_conflict_quantile_with_its_probability():
    rng, points, draws = np.random.default_rng(0), 10, 20_000
    e = 0.2 * rng.standard_normal((draws, points, 4))
    exceeded = np.mean(conflict(e) > conflict_quantile(points, 4 * points, 0.2, 2.0))
    surely = norm.sf(2.0)
    assert exceeded == pytest.approx(surely, abs=4 * np.sqrt(surely / draws))


# Rounding


def scattered(rng, *shape):
    return rng.uniform(20, 620, shape)


def seen(points):
    return np.ones((*points.shape[:-1], points.shape[-1] // 2), bool)


def to_grid(points, step, origin=0.0):
    return origin + np.round((points - origin) / step) * step


def test_rounding_std_equals_the_rounding_error_and_is_0_without_a_grid():
    points = scattered(np.random.default_rng(0), 10, 40, 8)
    assert rounding_std(points, seen(points)) == 0.0
    for step, origin, kind in product((0.25, 4 / 3, 1.0, 20 / 7), (0.0, 0.37), (np.float32, np.float64)):
        rounded = to_grid(points, step, origin)
        made = np.sqrt(np.mean((rounded - points) ** 2))
        found = rounding_std(rounded.astype(kind), seen(points))
        assert found == pytest.approx(made, rel=0.05) and found == pytest.approx(step / np.sqrt(12))
