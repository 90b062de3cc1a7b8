"""A disturbance against its settings."""

import numpy as np
import pytest

from viewimit.perception.disturbance import GROSS_PX, Disturbance


def test_noise_has_its_standard_deviation_and_grows_in_place():
    points, visible = np.zeros((5000, 4)), np.ones((5000, 2), bool)

    def noise(sigma):
        return Disturbance(noise_px=sigma).apply(points, visible, [1])[0]

    # the standard deviation of 20000 draws is known to 1/√40000, five times that is allowed
    assert noise(0.5).std() == pytest.approx(0.5, rel=0.025)
    np.testing.assert_allclose(noise(1.0), 2 * noise(0.5), atol=1e-14)


def test_a_larger_share_of_missing_points_loses_the_same_ones_first():
    points, visible = np.zeros((5000, 4)), np.ones((5000, 2), bool)

    def seen(share):
        return Disturbance(missing=share).apply(points, visible, [1])[1]

    assert seen(0.0).all() and not seen(1.0).any()
    assert np.mean(~seen(0.1)) == pytest.approx(0.1, abs=0.015)  # five standard deviations
    assert not (seen(0.3) & ~seen(0.1)).any()


def test_a_share_of_points_is_found_anywhere_within_gross_px():
    points, visible = np.zeros((5000, 4)), np.ones((5000, 2), bool)
    found, seen = Disturbance(outliers=0.1).apply(points, visible, [1])
    wrong = found.reshape(5000, 2, 2).any(-1)
    assert seen.all() and wrong.mean() == pytest.approx(0.1, abs=0.015)
    assert 0.9 * GROSS_PX < np.abs(found).max() <= GROSS_PX


def test_frames_are_looks_of_their_own_and_the_first_is_the_only_one_of_a_single_look():
    points, visible = np.zeros((10, 4)), np.ones((10, 2), bool)
    spoilt = Disturbance(noise_px=1.0, missing=0.2)
    frames, seen = spoilt.frames(points, visible, [3, 1], 4)
    alone, alone_seen = spoilt.apply(points, visible, [3, 1])
    assert frames.shape == (4, 10, 4) and seen.shape == (4, 10, 2)
    np.testing.assert_array_equal(frames[0], alone)
    np.testing.assert_array_equal(seen[0], alone_seen)
    assert len({frame.tobytes() for frame in frames}) == 4
