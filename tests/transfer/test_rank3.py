"""Rank-3 factorisation: E is the part of the four views' singular values that affine cameras cannot have."""

import numpy as np
import pytest

from viewimit.analysis.landscape import landscape_over
from viewimit.estimation.residuals import conflict
from viewimit.estimation.transfers import rank3
from viewimit.estimation.views import FourViews
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World


def seen(demo, own):
    return FourViews(demo, own, np.ones(own.shape[:-1] + (4,), bool))


def affine_views(rng, count=9):
    shape = rng.normal(size=(count, 3))
    images = shape @ rng.normal(size=(3, 8)) * 40 + rng.uniform(0, 240, 8)
    return images[:, :4], images[:, 4:]


def test_affine_views_of_one_body_leave_nothing_and_are_recovered():
    views = seen(*affine_views(np.random.default_rng(0)))
    fitted = rank3.fit(views)
    assert fitted.conflict(views) < 1e-20 * 240**2 and np.abs(fitted.residual(views)).max() < 1e-9
    np.testing.assert_allclose(fitted.recover(views.demo_left, views.demo_right), views.own, atol=1e-8)


@pytest.mark.parametrize("seed", range(20))
def test_E_is_never_less_than_nothing(seed):
    views = seen(*affine_views(np.random.default_rng(seed)))
    assert rank3.fit(views).conflict(views) >= 0


def test_E_is_what_singular_values_beyond_the_third_hold():
    rng = np.random.default_rng(1)
    demo, own = rng.normal(0, 30, (11, 4)), rng.normal(0, 30, (5, 11, 4))
    views = seen(demo, own)
    fitted = rank3.fit(views)
    for k in range(5):
        both = np.hstack([demo, own[k]])
        sigma = np.linalg.svd(both - both.mean(0), compute_uv=False)
        assert fitted.conflict(views)[k] == pytest.approx((sigma[3:] ** 2).sum() / 22)
    np.testing.assert_allclose(conflict(fitted.residual(views)), fitted.conflict(views), rtol=1e-9)


def test_known_figures_of_the_panda():
    """A prototype's: minimum, E there, at the demonstrator and at most."""
    world = World(load_scene("panda"))
    demo, _ = world.demo_images(np.radians([45, -90]))
    found = landscape_over(world, rank3.fit, demo, np.ones((10, 2), bool))
    np.testing.assert_allclose(np.degrees(found.minimum), [42, -91], atol=1e-9)
    assert (found.E.min(), found.E[45, 90], found.E.max()) == pytest.approx((0.60, 0.61, 63), rel=0.01)
    assert len(found.local_minima()) == 1 and found.basin_fraction() == 1.0


def test_coplanar_points_are_told():
    rng = np.random.default_rng(2)
    plane = rng.normal(size=(12, 2)) @ rng.normal(size=(2, 4)) * 30
    assert rank3.fit(seen(plane, rng.normal(0, 30, (12, 4)))).condition == np.inf
