"""The linear combination against plain least squares, and rank 3 against plain singular values."""

import numpy as np
import pytest

from viewimit.analysis.landscape import grid_axes, landscape_over
from viewimit.estimation.transfers import linear, rank3
from viewimit.estimation.transfers.transfer import conflict
from viewimit.estimation.views import FourViews
from viewimit.simulation.scene import load_scene
from viewimit.simulation.world import World

# Linear combination


def perspective_views(rng, count=10, flat=1.0):
    """Four perspective images of one body, px; `flat` shrinks it along one axis."""
    body = rng.normal(size=(count, 3)) * [0.2, 0.2, 0.2 * flat]
    images = []
    for _ in range(4):
        rotation, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        in_camera = body @ rotation + [0, 0, 2.0]
        images.append(256 * in_camera[:, :2] / in_camera[:, 2:] + [320, 120])
    return FourViews.from_images(*images)


def by_least_squares(views):
    """ŷ = a_0 + A u with u of the SVD, by lstsq."""
    X = views.demo - views.demo.mean(0)
    U, _, _ = np.linalg.svd(X, full_matrices=False)
    H = np.column_stack([np.ones(len(X)), U[:, :3]])
    return H @ np.linalg.lstsq(H, views.own, rcond=None)[0]


@pytest.mark.parametrize("seed", range(5))
def test_recovers_the_least_squares_fit_on_the_affine_shape(seed):
    views = perspective_views(np.random.default_rng(seed))
    transfer = linear.fit(views)
    expected = by_least_squares(views)
    np.testing.assert_allclose(transfer.recover(views.demo_left, views.demo_right), expected, atol=1e-9)
    E = np.sum((views.own - expected) ** 2) / (2 * 10)
    assert conflict(transfer.residual(views)) == pytest.approx(E, rel=1e-9)
    sigma = np.linalg.svd(views.demo - views.demo.mean(0), compute_uv=False)
    assert transfer.condition == pytest.approx(sigma[0] / sigma[2])


def test_an_affine_motion_of_the_demonstrators_shape_changes_nothing():
    """E depends on the span of the affine shape alone: [l r] times any 4 x 4 matrix that keeps rank 3."""
    rng = np.random.default_rng(6)
    shape = rng.normal(size=(10, 3))
    own = rng.normal(size=(10, 4)) * 60

    def E(demo):
        views = FourViews(demo, own, np.ones((10, 4), bool))
        return conflict(linear.fit(views).residual(views))

    assert E(shape @ rng.normal(size=(3, 4)) * 50) == pytest.approx(E(shape @ rng.normal(size=(3, 4)) * 80), rel=1e-9)


def test_condition_grows_as_the_body_flattens():
    rng = np.random.default_rng(8)
    body, cameras = rng.normal(size=(10, 3)) * 60, rng.normal(size=(4, 3, 2))
    conditions = []
    for flat in (1, 1e-2, 1e-4):
        views = FourViews.from_images(*(body * [1, 1, flat] @ camera for camera in cameras))
        conditions.append(float(linear.fit(views).condition))
    assert conditions[1] > 10 * conditions[0]
    assert conditions[2] == pytest.approx(100 * conditions[1], rel=0.05)


# Rank 3


def seen(demo, own):
    return FourViews(demo, own, np.ones(own.shape[:-1] + (4,), bool))


def test_E_of_rank_3_is_the_sum_of_squared_singular_values_beyond_the_third():
    rng = np.random.default_rng(1)
    demo, own = rng.normal(0, 30, (11, 4)), rng.normal(0, 30, (5, 11, 4))
    views = seen(demo, own)
    fitted = rank3.fit(views)
    for k in range(5):
        both = np.hstack([demo, own[k]])
        sigma = np.linalg.svd(both - both.mean(0), compute_uv=False)
        assert fitted.conflict(views)[k] == pytest.approx((sigma[3:] ** 2).sum() / 22)
    np.testing.assert_allclose(conflict(fitted.residual(views)), fitted.conflict(views), rtol=1e-9)


def test_rank_3_reproduces_known_figures_of_the_panda():
    """A prototype's: minimum, E there, at the demonstrator and at most."""
    world = World(load_scene("panda"))
    demo, _ = world.demo_images(np.radians([45, -90]))
    found = landscape_over(world, rank3.fit, demo, np.ones((10, 2), bool), grid_axes(world))
    np.testing.assert_allclose(np.degrees(found.minimum), [42, -91], atol=1e-9)
    assert (found.E.min(), found.E[45, 90], found.E.max()) == pytest.approx((0.60, 0.61, 63), rel=0.01)
    assert len(found.local_minima()) == 1 and found.basin_fraction() == 1.0
