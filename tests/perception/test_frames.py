"""Frames of the same are averaged, gross errors in them set aside, and their noise measured."""

import numpy as np
import pytest

from viewimit.loop.settings import Settings
from viewimit.sensing.frames import average_frames, noise_std
from viewimit.simulation.disturbances import ImageDisturbance, disturbed_frames

TRUE = np.random.default_rng(0).uniform(0, 240, (200, 4))
SEEN = np.ones((200, 2), bool)


def looks(count, seed=3, **disturbed):
    return disturbed_frames(Settings.paper(**disturbed).amounts(ImageDisturbance), TRUE, SEEN, [seed], count)


@pytest.mark.parametrize("count", [2, 5, 25])
def test_the_mean_of_many_has_less_noise(count):
    points, seen = average_frames(*looks(count, noise_px=0.5))
    assert seen.all() and (points - TRUE).std() == pytest.approx(0.5 / np.sqrt(count), rel=0.1)


def test_one_frame_is_itself():
    points, visible = looks(1, noise_px=0.5, missing=0.2)
    merged, seen = average_frames(points, visible)
    np.testing.assert_array_equal(merged, points[0])
    np.testing.assert_array_equal(seen, visible[0])


def test_a_point_is_seen_if_one_frame_shows_it_and_is_the_mean_of_those_that_do():
    points, visible = looks(4, missing=0.6)
    merged, seen = average_frames(points, visible)
    assert (seen == visible.any(0)).all() and 0 < (~seen).sum() < 200 * 2 * 0.3  # 0.6⁴ = 0.13 expected
    np.testing.assert_allclose(merged[np.repeat(seen, 2, -1)], TRUE[np.repeat(seen, 2, -1)])


@pytest.mark.parametrize("noise_px", [0.0, 0.5])
def test_gross_errors_are_set_aside(noise_px):
    """With 10 % wrong, half of 15 frames agree on a wrong place once in a million: none of 400 is far off."""
    points, seen = average_frames(*looks(15, noise_px=noise_px, outliers=0.1))
    assert seen.all() and np.abs(points - TRUE).max() < 5 * noise_px / np.sqrt(10) + 1e-9
    plain = looks(15, noise_px=noise_px, outliers=0.1)[0].mean(0)
    assert np.abs(plain - TRUE).max() > 5


@pytest.mark.parametrize("outliers", [0.0, 0.1])
def test_the_noise_is_told_from_gross_errors(outliers):
    """A tenth of wrong points moves the median of the steps by a quarter."""
    assert noise_std(*looks(8, noise_px=0.5, missing=0.1, outliers=outliers)) == pytest.approx(
        0.5, rel=0.05 + 3 * outliers
    )
    assert noise_std(*looks(8, outliers=outliers)) < 1e-9
    assert noise_std(*looks(1, noise_px=0.5)) == 0.0
