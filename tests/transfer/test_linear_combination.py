"""Linear combination of views against plain least squares; its condition against coplanar bodies."""

import numpy as np
import pytest

from viewimit.estimation.residuals import conflict
from viewimit.estimation.transfers import linear
from viewimit.estimation.views import FourViews


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


def test_coplanar_points_are_recognised():
    """Affine images of a plane have σ3 = 0; in perspective a body flattened 1e9 times comes near."""
    rng = np.random.default_rng(7)
    plane = rng.normal(size=(10, 2)) * 60
    views = FourViews.from_images(*(plane @ rng.normal(size=(2, 2)) + rng.uniform(0, 300, 2) for _ in range(4)))
    transfer = linear.fit(views)
    assert transfer.condition > 1e8
    np.testing.assert_allclose(transfer.recover(views.demo_left, views.demo_right), views.own, atol=1e-7)


def test_condition_grows_as_the_body_flattens():
    rng = np.random.default_rng(8)
    body, cameras = rng.normal(size=(10, 3)) * 60, rng.normal(size=(4, 3, 2))
    conditions = []
    for flat in (1, 1e-2, 1e-4):
        views = FourViews.from_images(*(body * [1, 1, flat] @ camera for camera in cameras))
        conditions.append(float(linear.fit(views).condition))
    assert conditions[1] > 10 * conditions[0]
    assert conditions[2] == pytest.approx(100 * conditions[1], rel=0.05)
