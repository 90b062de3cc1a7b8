"""Rectified matches lie in equal rows and epipoles at infinity; images that need no rectification get none."""

import numpy as np
import pytest
from stereo_heads import EQUAL, UNLIKE, head, matches

from viewimit.geometry.fundamental import epipoles, fit_fundamental
from viewimit.geometry.rectification import fit_rectification, rectify

NEEDED = [head(12), head(3, *UNLIKE), head(20, *UNLIKE)]
PARALLEL = [head(0), head(0, *UNLIKE)]


@pytest.mark.parametrize("stereo", NEEDED)
def test_epipoles_are_at_infinity_along_the_rows(stereo):
    left, right, _ = matches(stereo, np.random.default_rng(1))
    found = fit_rectification(left, right)
    for epipole, H in zip(epipoles(fit_fundamental(left, right)), (found.left, found.right)):
        x, y, w = H @ epipole
        assert abs(y) < 1e-8 * abs(x) and abs(w) < 1e-8 * abs(x)


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


def test_a_batch_equals_a_loop():
    left, right, _ = matches(head(8, EQUAL, UNLIKE[1]), np.random.default_rng(6))
    found, images = fit_rectification(left, right), np.concatenate([left, right], 1)
    together = found.apply(np.stack([images[:20], images[20:40]])[:, None])
    np.testing.assert_allclose(together.reshape(40, 4), found.apply(images[:40]))


def test_noise_is_enlarged_as_the_derivatives_of_the_rectified_images_say():
    left, right, _ = matches(head(20, *UNLIKE), np.random.default_rng(7))
    found, images, step = fit_rectification(left, right), np.concatenate([left, right], 1), 1e-4
    J = np.stack([found.apply(images + one) - found.apply(images - one) for one in step * np.eye(4)], -1) / (2 * step)
    squares = (J**2).sum(-1)  # of the four rectified coordinates, for noise of 1 px
    np.testing.assert_allclose(found.magnification(images) ** 2, (squares[:, ::2] + squares[:, 1::2]) / 2, rtol=1e-6)
