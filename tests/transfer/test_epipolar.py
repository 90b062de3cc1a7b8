"""The paper's transfer: theorems about affine views, its equations built plainly, its misprints, its degeneracies."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from viewimit.estimation.residuals import conflict
from viewimit.estimation.transfers import TRANSFERS, epipolar
from viewimit.estimation.views import FourViews
from viewimit.geometry.affine import fit_affine_fundamental

PX = 60.0  # size of the random bodies


def affine_views(rng, count=10, batch=(), noise=0.0):
    """Four exact affine images of one random body, or of a batch of learners' postures, px."""
    body = rng.normal(size=(count, 3)) * PX
    learners = body if batch == () else rng.normal(size=batch + (count, 3)) * PX
    images = [points @ rng.normal(size=(3, 2)) + rng.uniform(0, 300, 2) for points in (body, body, learners, learners)]
    return FourViews.from_images(*(image + noise * rng.normal(size=image.shape) for image in images))


def conflict_of(fit, views):
    return conflict(fit(views).residual(views))


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


@pytest.mark.parametrize("fit", TRANSFERS.values(), ids=TRANSFERS)
@pytest.mark.parametrize("count", [5, 6, 10, 20])
def test_E_vanishes_for_exact_affine_views(fit, count):
    """Rounding leaves 1e-16 of 300 px, squared about 1e-27; ill-conditioned random cameras amplify it."""
    E = [conflict_of(fit, affine_views(np.random.default_rng(seed), count)) for seed in range(100)]
    assert np.median(E) < 1e-23
    assert max(E) < 1e-16


@pytest.mark.parametrize("fit", TRANSFERS.values(), ids=TRANSFERS)
def test_an_affine_motion_of_the_body_is_invisible(fit):
    """Affine cameras of a moved body are other affine cameras: E stays 0, and stays what it is with noise."""
    rng = np.random.default_rng(3)
    body, motion, shift = rng.normal(size=(10, 3)) * PX, rng.normal(size=(3, 3)), rng.normal(size=3) * PX
    cameras = [(rng.normal(size=(3, 2)), rng.uniform(0, 300, 2)) for _ in range(4)]
    moved = body @ motion + shift
    images = [points @ M + t for points, (M, t) in zip((body, body, moved, moved), cameras)]
    assert conflict_of(fit, FourViews.from_images(*images)) < 1e-18


@pytest.mark.parametrize("fit", TRANSFERS.values(), ids=TRANSFERS)
@given(scale=st.floats(0.01, 100), seed=st.integers(0, 50))
def test_E_scales_with_the_square_of_the_image(fit, scale, seed):
    views = affine_views(np.random.default_rng(seed), noise=3.0)
    scaled = FourViews(scale * views.demo, scale * views.own, views.visible)
    assert conflict_of(fit, scaled) == pytest.approx(scale**2 * conflict_of(fit, views), rel=1e-6)


@pytest.mark.parametrize("fit", TRANSFERS.values(), ids=TRANSFERS)
def test_shifted_images_shift_what_is_recovered_and_leave_E(fit):
    rng = np.random.default_rng(5)
    views = affine_views(rng, noise=3.0)
    shift_demo, shift_own = rng.uniform(-500, 500, (2, 4))
    shifted = FourViews(views.demo + shift_demo, views.own + shift_own, views.visible)
    before = fit(views).recover(views.demo_left, views.demo_right)
    after = fit(shifted).recover(shifted.demo_left, shifted.demo_right)
    np.testing.assert_allclose(after, before + shift_own, atol=1e-7)
    assert conflict_of(fit, shifted) == pytest.approx(conflict_of(fit, views), rel=1e-7)


@pytest.mark.parametrize("fit", TRANSFERS.values(), ids=TRANSFERS)
def test_points_that_were_not_fitted_are_recovered_too(fit):
    """Section 5.4: the frozen transfer maps any point of [l], [r]."""
    views = affine_views(np.random.default_rng(6), count=15)
    transfer = fit(views.select(np.arange(10)))
    np.testing.assert_allclose(transfer.recover(views.demo_left, views.demo_right), views.own, atol=1e-7)


@pytest.mark.parametrize("fit", TRANSFERS.values(), ids=TRANSFERS)
def test_a_batch_is_each_posture_alone(fit):
    views = affine_views(np.random.default_rng(7), batch=(2, 3), noise=1.0)
    one_demo = FourViews(views.demo[0, 0], views.own, views.visible)
    for batch in (views, one_demo):
        transfer = fit(batch)
        assert transfer.condition.shape == (2, 3)
        recovered = transfer.recover(batch.demo_left, batch.demo_right)
        for index in np.ndindex(2, 3):
            alone = FourViews(one_demo.demo, views.own[index], views.visible[index])
            single = fit(alone)
            expected = single.recover(alone.demo_left, alone.demo_right)
            np.testing.assert_allclose(recovered[index], expected, rtol=1e-8, atol=1e-7)
            assert transfer.condition[index] == pytest.approx(float(single.condition), rel=1e-7)


@pytest.mark.parametrize("fit", TRANSFERS.values(), ids=TRANSFERS)
def test_four_points_raise(fit):
    with pytest.raises(ValueError, match="need at least 5 points, got 4"):
        fit(affine_views(np.random.default_rng(8), count=4))


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


def test_a_singular_system_says_so():
    f = lines_system(np.random.default_rng(10), 0.0)
    f[:2, 4] = f[3:1:-1, 0] * [[1], [0]]  # (L, R) repeats the one line that [l] and [r] share in [L]
    f[2:, 4] = 0
    assert epipolar.condition(f)[0] > 1e7


def test_coplanar_points_leave_f_undetermined():
    """[l] and [L] of a plane are affine images of each other: W has rank 2, any vector of its kernel will do,
    and the transfer stays exact for the points of that plane. Its condition does not tell: see `linear`."""
    rng = np.random.default_rng(12)
    plane = rng.normal(size=(10, 2)) * PX
    images = [plane @ rng.normal(size=(2, 2)) + rng.uniform(0, 300, 2) for _ in range(4)]
    views = FourViews.from_images(*images)
    W = np.cov(np.hstack(images[::2]).T)
    assert np.linalg.eigvalsh(W)[1] < 1e-10 * np.trace(W)
    transfer = epipolar.fit(views)
    assert np.isfinite(transfer.matrix).all()
    accuracy = 1e-9 * float(transfer.condition)
    np.testing.assert_allclose(transfer.recover(views.demo_left, views.demo_right), views.own, atol=accuracy)
