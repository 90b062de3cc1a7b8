"""The paper's transfer: theorems about affine views, its equations built plainly, its misprints, its degeneracies."""

import numpy as np
import pytest
from test_transfers import PX, affine_views

from viewimit.estimation.transfers import epipolar
from viewimit.estimation.views import FourViews
from viewimit.geometry.affine import fit_affine_fundamental


def plain_system(views):
    """A: (5, 4), B: (5, 6), c: (6, N) of Eq. (4), row by row, with f33."""
    l, r, L, R = views.demo_left, views.demo_right, views.own_left, views.own_right
    A, B = np.zeros((5, 4)), np.zeros((5, 6))
    for row, (p, q) in enumerate(((l, L), (r, L), (l, R), (r, R))):
        f, f33 = fit_affine_fundamental(p, q)
        A[row, 2 * (row // 2) : 2 * (row // 2) + 2] = f[2:]
        B[row, 3 * (row % 2) : 3 * (row % 2) + 3] = [*f[:2], f33]
    f, f33 = fit_affine_fundamental(L, R)
    A[4], B[4, 5] = f, f33
    one = np.ones(len(l))
    return A, B, np.stack([*l.T, one, *r.T, one])


@pytest.fixture(params=range(5))
def noisy(request):
    return affine_views(np.random.default_rng(request.param), noise=2.0)


def test_recovers_the_least_squares_solution_of_eq_4(noisy):
    A, B, c = plain_system(noisy)
    expected = np.linalg.lstsq(A, -B @ c, rcond=None)[0].T
    transfer = epipolar.fit(noisy)
    np.testing.assert_allclose(transfer.recover(noisy.demo_left, noisy.demo_right), expected, atol=1e-7)
    assert transfer.condition == pytest.approx(np.linalg.cond(A), rel=1e-9)


def test_eq_5_as_printed_lacks_a_minus(noisy):
    A, B, c = plain_system(noisy)
    printed = (np.linalg.inv(A.T @ A) @ A.T @ B @ c).T
    recovered = epipolar.fit(noisy).recover(noisy.demo_left, noisy.demo_right)
    np.testing.assert_allclose(recovered, -printed, atol=1e-6)
    assert np.abs(recovered - printed).max() > 100


def test_last_row_of_A_as_printed_swaps_L_and_R():
    """With exact views the true system has the learner's points for its solution; the printed one has not."""
    views = affine_views(np.random.default_rng(11))
    A, B, c = plain_system(views)
    np.testing.assert_allclose(A @ views.own.T, -B @ c, atol=1e-8)
    A[4] = np.roll(A[4], 2)  # f31 f32 f13 f23
    printed = np.linalg.lstsq(A, -B @ c, rcond=None)[0].T
    assert np.abs(printed - views.own).max() > 1
    recovered = epipolar.fit(views).recover(views.demo_left, views.demo_right)
    np.testing.assert_allclose(recovered, views.own, atol=1e-7)


def lines_system(rng, angle):
    """Five constraints whose lines of [l] and [r] in [L] meet at `angle`: f (4, 5, 1)."""
    f = rng.normal(size=(4, 5, 1))
    f[2:, 0, 0] = 1, 0
    f[2:, 1, 0] = np.cos(angle), np.sin(angle)
    return f / np.linalg.norm(f, axis=0)


@pytest.mark.parametrize("angle", [1.0, 1e-1, 3e-3, 1e-3, 1e-5, 1e-7])
def test_nearly_parallel_lines_are_solved_as_by_lstsq_and_flagged(angle):
    f = lines_system(np.random.default_rng(9), angle)
    A, B = (matrix[0] for matrix in epipolar.linear_system(f))
    expected = np.linalg.lstsq(A, -B, rcond=None)[0]
    found = epipolar.solve(f)[:, :, 0]
    cond = np.linalg.cond(A)
    rounding = np.finfo(float).eps / 1e-3  # of the determinant that is still inverted, however parallel the lines are
    np.testing.assert_allclose(found, expected, rtol=0, atol=rounding * cond * np.abs(expected).max())
    assert epipolar.condition(f)[0] == pytest.approx(cond, rel=1e-15 * cond**2 + 1e-9)


def test_coplanar_points_leave_f_undetermined_and_the_transfer_finite():
    """[l] and [L] of a plane are affine images of each other: W has rank 2, and any vector of its kernel will do."""
    rng = np.random.default_rng(12)
    plane = rng.normal(size=(10, 2)) * PX
    images = [plane @ rng.normal(size=(2, 2)) + rng.uniform(0, 300, 2) for _ in range(4)]
    W = np.cov(np.hstack(images[::2]).T)
    assert np.linalg.eigvalsh(W)[1] < 1e-10 * np.trace(W)
    assert np.isfinite(epipolar.fit(FourViews.from_images(*images)).matrix).all()
