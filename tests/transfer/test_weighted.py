"""Near the demonstrator's posture the weighted fit is exact, knows the noise that it leaves, and reaches the bound."""

import numpy as np
import pytest

from viewimit.estimation.noise import HomographyResiduals
from viewimit.estimation.residuals import conflict
from viewimit.estimation.views import FourViews
from viewimit.experiments.bench.bound import bound
from viewimit.geometry.rectification import fit_rectification
from viewimit.servo.least_squares import minimise
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

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


def test_E_is_zero_in_the_demonstrators_posture_and_there_only(world, rectification):
    views = world.look(THERE, THERE)
    around = THERE + np.radians(np.stack(np.meshgrid(*[np.arange(-10, 11, 2.0)] * 2, indexing="ij"), -1))
    E = conflict(
        HomographyResiduals.whitened_at(views, rectification, 0.1).residual(views.with_own(own_at(world, around)))
    )
    assert E[5, 5] < 1e-18
    assert np.delete(E.ravel(), 60).min() > 1e-3


def half_seen(views, rng, share=0.3):
    """The same, some points of the demonstrator without one of their images."""
    visible = views.visible.copy()
    points = rng.choice(len(visible), int(share * len(visible)), replace=False)
    visible[points, rng.integers(2, size=len(points))] = False
    demo = np.where(np.repeat(visible[:, :2], 2, 1), views.demo, np.nan)
    return FourViews(demo, views.own, visible)


def test_a_point_that_one_camera_alone_sees_tells_too_and_what_the_other_would_see_has_no_part(world, rectification):
    views = half_seen(world.look(THERE, THERE), np.random.default_rng(5))
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


def test_points_half_seen_tell_a_joint_that_the_others_leave_open(world, rectification):
    """Without a whole point of the base, the first joint turns all that is seen."""
    views = world.look(THERE, THERE)
    base = world.body.link < world.scene.moving[0] + 1
    assert 0 < base.sum() < 16 - 5
    turned = own_at(world, THERE + np.radians([[0.0, 0.0], [15.0, 0.0]]))
    visible = views.visible.copy()
    visible[base, :2] = False
    without = FourViews(views.demo, views.own, visible).select(~base)
    assert (
        conflict(
            HomographyResiduals.unweighted(without, rectification).residual(without.with_own(turned[:, ~base]))
        ).max()
        < 1e-12
    )
    visible[base, 0] = True
    lines = FourViews(views.demo, views.own, visible)
    E = conflict(HomographyResiduals.unweighted(lines, rectification).residual(lines.with_own(turned)))
    assert E[0] < 1e-18 and E[1] > 0.1


def test_images_of_a_batch_are_answered_as_each_of_them(world, rectification):
    views = world.look(THERE, THERE)
    by = HomographyResiduals.whitened_at(views, rectification, 0.1)
    own = own_at(world, THERE + np.random.default_rng(1).uniform(-0.2, 0.2, (2, 3, 2)))
    together = by.residual(views.with_own(own))
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(together[index], by.residual(views.with_own(own[index])), atol=1e-7)


def test_what_noise_leaves_is_that_noise_but_for_the_fifteen_parameters_of_G(world, rectification):
    exact, rng, px = world.look(THERE, THERE), np.random.default_rng(2), 0.1
    by = HomographyResiduals.whitened_at(exact, rectification, 1.0)
    squares = [np.square(by.residual(noisy(exact, rng, px, px))).sum() for _ in range(100)]
    assert np.mean(squares) == pytest.approx(px**2 * (4 * 16 - 15), rel=0.06)
    half = half_seen(exact, np.random.default_rng(5))  # four points, each with half of its images
    by = HomographyResiduals.whitened_at(half, rectification, 1.0)
    squares = [np.square(by.residual(noisy(half, rng, px, px))).sum() for _ in range(100)]
    assert np.mean(squares) == pytest.approx(px**2 * (4 * 16 - 2 * 4 - 15), rel=0.06)


def test_where_only_the_demonstrator_is_noisy_it_reaches_the_cramer_rao_bound(world, rectification):
    exact, rng, px = world.look(THERE, THERE), np.random.default_rng(3), 0.05
    errors = [found_near(world, noisy(exact, rng, px, 0.0), rectification, 0.0) - THERE for _ in range(60)]
    least = bound(world, THERE, px)
    rms = np.sqrt(np.mean(np.square(errors), 0))
    assert (rms < 1.25 * least).all() and (rms > 0.75 * least).all()
    np.testing.assert_allclose(bound(world, THERE, 3 * px), 3 * least)
