"""Rectified matches lie in equal rows and epipoles at infinity; images that need no rectification get none."""

import numpy as np
import pytest
from stereo_heads import EQUAL, UNLIKE, head, matches

from viewimit.geometry.affine import image_unit
from viewimit.geometry.fundamental import epipoles, fit_fundamental
from viewimit.geometry.rectification import (
    MIN_DENOMINATOR,
    MIN_RMS_PX,
    Rectification,
    affine_squared_error,
    fit_rectification,
    has_equal_rows,
    rectify,
    rectify_affine,
)

NEEDED = [head(12), head(3, *UNLIKE), head(20, *UNLIKE)]
PARALLEL = [head(0), head(0, *UNLIKE)]


@pytest.mark.parametrize("stereo", NEEDED)
def test_other_matches_get_equal_rows_too(stereo):
    rng = np.random.default_rng(0)
    found = fit_rectification(*matches(stereo, rng)[:2])
    left, right, _ = matches(stereo, rng)
    images = np.concatenate([left, right], 1)
    rows = found.apply(images)[:, 1::2]
    np.testing.assert_allclose(rows[:, 0], rows[:, 1], atol=1e-8)
    assert np.abs(np.diff(images[:, 1::2])).max() > 1  # px, before
    np.testing.assert_allclose(found.restore(found.apply(images)), images, atol=1e-9)


@pytest.mark.parametrize("stereo", PARALLEL)
@pytest.mark.parametrize("roll_deg", [0, 8])
def test_similarities_rectify_parallel_axes(stereo, roll_deg):
    left, right, _ = matches(stereo, np.random.default_rng(0))
    turn = np.radians([roll_deg, -2 * roll_deg])
    left, right = (
        (points - 200) @ [[np.cos(by), np.sin(by)], [-np.sin(by), np.cos(by)]] + 200
        for points, by in zip((left, right), turn)
    )
    rows = rectify_affine(left[:40], right[:40]).apply(np.concatenate([left, right], 1))
    np.testing.assert_allclose(rows[:, 1], rows[:, 3], atol=1e-8)
    for before, after in ((left, rows[:, :2]), (right, rows[:, 2:])):  # turned and scaled, not mirrored
        (into, *_), scale = np.linalg.lstsq(np.c_[before, np.ones(len(before))], after, rcond=None), after.std(0)
        assert np.linalg.det(into[:2]) > 0 and (scale > 1).all()


@pytest.mark.parametrize("stereo", NEEDED)
def test_epipoles_are_at_infinity_along_the_rows(stereo):
    left, right, _ = matches(stereo, np.random.default_rng(1))
    found = fit_rectification(left, right)
    for epipole, H in zip(epipoles(fit_fundamental(left, right)), (found.left, found.right)):
        x, y, w = H @ epipole
        assert abs(y) < 1e-8 * abs(x) and abs(w) < 1e-8 * abs(x)


@pytest.mark.parametrize("stereo", NEEDED)
def test_pixels_keep_size_and_orientation_in_the_middle_of_the_right_image(stereo):
    left, right, _ = matches(stereo, np.random.default_rng(2))
    found, middle, small = fit_rectification(left, right), right.mean(0), 1e-4
    around = middle + small * np.array([[0, 0], [1, 0], [0, 1]])
    images = found.apply(np.concatenate([np.tile(left[:1], (3, 1)), around], 1))[:, 2:]
    derivative = (images[1:] - images[0]).T / small
    np.testing.assert_allclose(derivative @ derivative.T, np.eye(2), atol=1e-3)
    assert np.linalg.det(derivative) > 0 and derivative[0, 0] > 0.7


def test_equal_parallel_cameras_keep_the_right_image_and_the_rows_of_the_left():
    left, right, _ = matches(head(0), np.random.default_rng(3))
    found = rectify(fit_fundamental(left, right), left, right)
    np.testing.assert_allclose(found.right, np.eye(3), atol=1e-6)
    np.testing.assert_allclose(found.left[1:], np.eye(3)[1:], atol=1e-6)


@pytest.mark.parametrize("stereo", PARALLEL)
@pytest.mark.parametrize("noise_px", [0.0, 0.25, 2.0])
def test_parallel_axes_need_no_rectification_even_of_unlike_cameras_with_noise(stereo, noise_px):
    rng = np.random.default_rng(4)
    assert all(fit_rectification(*matches(stereo, rng, 40, noise_px)[:2]) is None for _ in range(20))


def test_toed_in_cameras_are_rectified_despite_noise_and_wrong_matches():
    rng = np.random.default_rng(5)
    for _ in range(20):
        left, right, _ = matches(head(12), rng, 60, 0.25)
        right[:3] += rng.uniform(-60, 60, (3, 2))
        assert fit_rectification(left, right) is not None
    assert fit_rectification(left[:10], right[:10]) is None  # too few to tell


def test_seven_perturbed_rectifications_give_equal_rows_as_well_as_noise_allows():
    rng = np.random.default_rng(7)
    assert fit_rectification(*matches(head(12), rng)[:2]).perturbed == ()
    left, right, _ = matches(head(12), rng, 60, 0.25)
    found = fit_rectification(left, right)
    off = lambda by: np.diff(by.apply(np.concatenate([left, right], 1))[:, 1::2]).ravel() / np.sqrt(2)
    assert len(found.perturbed) == 7
    for other in found.perturbed:
        apart = ((off(other) - off(found)) ** 2).sum()  # one standard deviation of one parameter
        assert apart == pytest.approx(0.25**2, rel=0.5)


def test_a_batch_equals_a_loop():
    left, right, _ = matches(head(8, EQUAL, UNLIKE[1]), np.random.default_rng(6))
    found, images = fit_rectification(left, right), np.concatenate([left, right], 1)
    together = found.apply(np.stack([images[:20], images[20:40]])[:, None])
    np.testing.assert_allclose(together.reshape(40, 4), found.apply(images[:40]))


@pytest.mark.parametrize("apart_px", [0.0, 1e-3, 3.4e-3, 4.4e-3, 1e-2])
def test_nearly_equal_rows_are_near_an_affine_geometry(apart_px):
    rng = np.random.default_rng(4)
    left = rng.uniform(0, 640, (40, 2))
    right = np.stack([left[:, 0] - rng.uniform(10, 60, 40), left[:, 1] + apart_px * rng.choice([-1, 1], 40)], 1)
    least_px = MIN_RMS_PX * image_unit(np.concatenate([left, right], 1))
    near = affine_squared_error(left, right) < len(left) * least_px**2
    assert has_equal_rows(left, right) == (apart_px < np.sqrt(2) * least_px)
    assert near or not has_equal_rows(left, right)


def test_points_beyond_the_line_at_infinity_stay_finite():
    """With the denominator 1 - x/100, points from x = 90 on are divided by MIN_DENOMINATOR."""
    H = np.array([[1.0, 0, 0], [0, 1, 0], [-0.01, 0, 1]])
    points = np.array([[50.0, 8], [100, 8], [300, 8]])
    mapped = Rectification(H, H).apply(np.concatenate([points, points], 1))
    np.testing.assert_allclose(mapped[:, :2], points / [[0.5], [MIN_DENOMINATOR], [MIN_DENOMINATOR]])
