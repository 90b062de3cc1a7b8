"""Affine fundamental matrices against LAPACK, exact affine views and the paper's own equations."""

import numpy as np
import pytest

from viewimit.geometry.affine import fit_affine_fundamental


def affine_pair(rng, count=8, batch=()):
    """Two exact affine images of the same points, px."""
    points = rng.normal(size=batch + (count, 3)) * 60
    return [points @ rng.normal(size=(3, 2)) + rng.uniform(0, 300, 2) for _ in range(2)]


def by_eigh(p, q):
    """Eqs. (2), (3), one pair of images."""
    u = np.hstack([p, q])
    centroid = u.mean(0)
    values, vectors = np.linalg.eigh((u - centroid).T @ (u - centroid))
    return values, vectors[:, 0], -centroid @ vectors[:, 0]


def test_f_agrees_with_lapack():
    rng = np.random.default_rng(1)
    p, q = (np.cumsum(rng.normal(size=(200, 9, 2)) * 40, 1) + 200 for _ in range(2))
    f, f33 = fit_affine_fundamental(p, q)
    assert f.shape == (200, 4) and f33.shape == (200,)
    np.testing.assert_allclose(np.linalg.norm(f, axis=1), 1, atol=1e-14)
    for k in range(200):
        values, expected, expected_f33 = by_eigh(p[k], q[k])
        sign = np.sign(f[k] @ expected)
        # an eigenvector is as exact as rounding divided by the gap to the next eigenvalue
        tolerance = 1e-13 * values[3] / (values[1] - values[0])
        np.testing.assert_allclose(sign * f[k], expected, atol=tolerance)
        assert sign * f33[k] == pytest.approx(expected_f33, abs=1e3 * tolerance)


def test_exact_affine_views_obey_the_constraint():
    p, q = affine_pair(np.random.default_rng(2))
    f, f33 = fit_affine_fundamental(p, q)
    np.testing.assert_allclose(p @ f[:2] + q @ f[2:] + f33, 0, atol=1e-10)


def test_eq_3_needs_the_centroid_and_eq_2_one_over_N():
    """(f, f33) minimise Σ (uᵀf + f33)². With one of the points for u_0, or another count for N, they do not."""
    rng = np.random.default_rng(3)
    p, q = (points + rng.normal(size=points.shape) for points in affine_pair(rng))
    f, f33 = fit_affine_fundamental(p, q)
    u = np.hstack([p, q])

    def error(f, f33):
        return np.sum((u @ f + f33) ** 2)

    values, expected, expected_f33 = by_eigh(p, q)
    assert error(f, f33) == pytest.approx(values[0], rel=1e-9) == error(expected, expected_f33)
    assert all(error(f, f33) < (1 - 1e-6) * error(f, -point @ f) for point in u)
    misread = u - u.sum(0) / 4  # n = 4 components in place of N = 8 points
    _, vectors = np.linalg.eigh(misread.T @ misread)
    printed = vectors[:, 0]
    assert error(f, f33) < (1 - 1e-6) * error(printed, -u.mean(0) @ printed)


def test_four_points_raise():
    p, q = affine_pair(np.random.default_rng(4), count=4)
    with pytest.raises(ValueError, match="at least 5 points, got 4"):
        fit_affine_fundamental(p, q)


def test_batches_broadcast_against_one_image():
    rng = np.random.default_rng(5)
    p, q = affine_pair(rng, batch=(2, 3))
    f, f33 = fit_affine_fundamental(p[0, 0], q)
    assert f.shape == (2, 3, 4) and f33.shape == (2, 3)
    for index in np.ndindex(2, 3):
        alone, alone_f33 = fit_affine_fundamental(p[0, 0], q[index])
        np.testing.assert_allclose(f[index] * f33[index], alone * alone_f33, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("batch", [1, 40], ids=["short", "long"])
@pytest.mark.parametrize("coordinate", [np.nan, np.inf])
@pytest.mark.filterwarnings("ignore:invalid value")
def test_a_coordinate_that_is_not_finite_is_refused(batch, coordinate):
    p, q = np.random.default_rng(9).uniform(0, 500, (2, batch, 8, 2))
    p[-1, 3, 0] = coordinate
    with pytest.raises(ValueError):
        fit_affine_fundamental(p, q)
