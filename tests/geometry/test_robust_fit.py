"""Outliers among matches are found, and no inliers, checked against the F of known cameras."""

import numpy as np
import pytest
from stereo_heads import UNLIKE, fundamental_of, head, matches

from viewimit.geometry.fundamental import sampson_distance
from viewimit.geometry.robust_fit import MIN_THRESHOLD_PX, OUTLIER_SIGMA, all_inliers, detect_outliers

HEADS = {"parallel": head(0), "parallel, unlike": head(0, *UNLIKE), "toed-in": head(12), "both": head(9, *UNLIKE)}
CLEAR = 4 * OUTLIER_SIGMA  # times the noise: nothing between OUTLIER_SIGMA and that is judged here


@pytest.mark.parametrize("noise_px", [0.0, 0.25, 1.0])
@pytest.mark.parametrize("stereo", HEADS.values(), ids=HEADS)
def test_a_fifth_of_wrong_matches_is_found_and_nothing_else(stereo, noise_px):
    for seed in range(6):
        rng = np.random.default_rng(seed)
        left, right, cameras = matches(stereo, rng, 60, noise_px)
        wrong = rng.random(len(left)) < 0.2
        right = right + wrong[:, None] * rng.uniform(-60, 60, right.shape)
        away = np.abs(sampson_distance(fundamental_of(cameras), left, right))
        found = detect_outliers(left, right, noise_px, rng)
        assert not (found & ~wrong).any()
        assert found[away > max(5 * MIN_THRESHOLD_PX, CLEAR * noise_px)].all()


@pytest.mark.parametrize("stereo", HEADS.values(), ids=HEADS)
def test_no_outlier_is_found_among_few_inliers(stereo):
    for seed in range(10):
        rng = np.random.default_rng(seed)
        left, right, _ = matches(stereo, rng, 20, 0.25)
        assert not detect_outliers(left, right, 0.25, rng).any()
        assert not detect_outliers(left[:8], right[:8], 0.25, rng).any()


def test_no_outlier_is_found_where_no_geometry_fits():
    rng = np.random.default_rng(0)
    left, right = rng.uniform(0, 300, (2, 60, 2))
    assert not detect_outliers(left, right, 0.25, rng).any() and not all_inliers(left, right, 0.25)


@pytest.mark.parametrize("noise_px", [0.0, 0.25])
def test_matches_of_parallel_cameras_are_inliers_until_one_is_moved_out_of_its_row(noise_px):
    left, right, _ = matches(HEADS["parallel, unlike"], np.random.default_rng(1), 40, noise_px)
    assert all_inliers(left, right, noise_px) and all_inliers(left[:5], right[:5] + 20, noise_px)
    along, across = right.copy(), right.copy()
    along[3, 0] += 20
    across[3, 1] += 20
    assert all_inliers(left, along, noise_px) and not all_inliers(left, across, noise_px)
