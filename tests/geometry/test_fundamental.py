"""The F of matches is that of the cameras that made them, and OpenCV's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from stereo_heads import UNLIKE, fundamental_of, head, matches, up_to_scale

from viewimit.geometry.fundamental import epipoles, fit_fundamental, fit_fundamental_with_prior, sampson_distance


@pytest.mark.parametrize("stereo", [head(0), head(12), head(3, *UNLIKE), head(20, *UNLIKE)])
def test_without_noise_F_is_that_of_the_cameras(stereo):
    left, right, cameras = matches(stereo, np.random.default_rng(0))
    F = fit_fundamental(left, right)
    np.testing.assert_allclose(up_to_scale(F), up_to_scale(fundamental_of(cameras)), atol=1e-9)
    assert np.linalg.svd(F)[1][2] < 1e-12 * np.linalg.norm(F)
    assert np.abs(sampson_distance(F, left, right)).max() < 1e-9


def test_without_reweighting_it_is_opencvs_eight_point_algorithm():
    cv2 = pytest.importorskip("cv2")
    left, right, _ = matches(head(12, *UNLIKE), np.random.default_rng(1))
    theirs, _ = cv2.findFundamentalMat(left, right, cv2.FM_8POINT)
    np.testing.assert_allclose(
        up_to_scale(fit_fundamental(left, right, n_reweightings=0)), up_to_scale(theirs), atol=1e-7
    )


def flat_matches(rng, noise_px=0.25):
    """Of points at nearly equal depth, which determine F poorly."""
    left, right, _ = matches(head(12, *UNLIKE), np.random.default_rng(8), 200)
    near = np.abs(right[:, 0] - left[:, 0] - np.median(right[:, 0] - left[:, 0])) < 15
    return (images[near] + noise_px * rng.standard_normal((near.sum(), 2)) for images in (left, right))


def test_F_is_the_matrix_of_rank_2_nearest_to_the_matches():
    """Their distances rise alike to all sides of it; not so of the one that is nearest to a matrix of rank 3."""
    rng = np.random.default_rng(9)
    for _ in range(5):
        left, right = flat_matches(rng)
        F = fit_fundamental(left, right)
        first, _, last = np.linalg.svd(F, compute_uv=False)
        assert last < 1e-12 * first
        cost = lambda matrix, left=left, right=right: (sampson_distance(matrix, left, right) ** 2).sum()
        U, sizes, Vt = np.linalg.svd(F)
        for across in rng.normal(size=(6, 3)):  # turned a little, and so of rank 2 as well
            turn = Rotation.from_rotvec(1e-4 * across).as_matrix()
            assert cost(turn @ F) > cost(F) and cost(F @ turn) > cost(F)
            assert cost(U @ np.diag(sizes * (1, 1 + 1e-3 * across[0], 1)) @ Vt) > cost(F)


def test_sampsons_distance_is_that_moved_across_the_epipolar_line():
    """To first order; the line of the other image takes its share."""
    left, right, cameras = matches(head(12), np.random.default_rng(3))
    F = fundamental_of(cameras)
    lines = np.column_stack([left, np.ones(len(left))]) @ F.T
    across = lines[:, :2] / np.linalg.norm(lines[:, :2], axis=1)[:, None]
    other = np.column_stack([right, np.ones(len(right))]) @ F
    share = np.linalg.norm(lines[:, :2], axis=1) / np.hypot(
        *(np.linalg.norm(each[:, :2], axis=1) for each in (lines, other))
    )
    np.testing.assert_allclose(sampson_distance(F, left, right + 0.01 * across), 0.01 * share, rtol=1e-3)


def test_epipoles_are_the_images_of_the_other_camera():
    left, right, (camera_left, camera_right) = matches(head(15, *UNLIKE), np.random.default_rng(4))
    of_left, of_right = epipoles(fit_fundamental(left, right))
    for epipole, camera, other in ((of_left, camera_left, camera_right), (of_right, camera_right, camera_left)):
        image, _ = camera.project(other.T_world_camera[:3, 3][:, None])
        np.testing.assert_allclose(epipole[:2] / epipole[2], image[:, 0], rtol=1e-6)


def test_seven_matches_are_refused():
    left, right, _ = matches(head(5), np.random.default_rng(5))
    with pytest.raises(ValueError, match="at least 8 matches .*, got 7"):
        fit_fundamental(left[:7], right[:7])


@pytest.mark.parametrize("toe_in_deg", [0, 2, 12])
def test_the_prior_brings_other_matches_nearer_to_the_F_of_few_noisy_ones(toe_in_deg):
    """Exact ones, of 60 draws on average and of the worst tenth."""
    away = {fit_fundamental: [], fit_fundamental_with_prior: []}
    for seed in range(60):
        rng = np.random.default_rng(seed)
        left, right, _ = matches(head(toe_in_deg), rng, 20, 1.5)
        others = matches(head(toe_in_deg), rng, 200)[:2]
        for fit, found in away.items():
            found.append(np.sqrt(np.mean(sampson_distance(fit(left, right), *others) ** 2)))
    without, with_prior = away.values()
    assert np.mean(with_prior) < 0.95 * np.mean(without)
    assert np.percentile(with_prior, 90) < 0.85 * np.percentile(without, 90)
