"""Frames are averaged without outliers; noise, latency, missing values and far outliers are found."""

import numpy as np
import pytest

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.sensing.frames import MAX_LATENCY_LOOKS, average_frames, estimate_latency
from viewimit.simulation.disturbances import ImageDisturbance, disturb, disturbed_frames

TRUE = np.random.default_rng(0).uniform(0, 240, (200, 4))
SEEN = np.ones((200, 2), bool)


def looks(count, seed=3, **disturbed):
    return disturbed_frames(Settings.paper(**disturbed).amounts(ImageDisturbance), TRUE, SEEN, [seed], count)


@pytest.mark.parametrize("count", [2, 5, 25])
def test_the_mean_of_many_has_less_noise(count):
    points, seen = average_frames(*looks(count, noise_px=0.5))
    assert seen.all() and (points - TRUE).std() == pytest.approx(0.5 / np.sqrt(count), rel=0.1)


def test_a_point_is_seen_if_one_frame_shows_it_and_is_the_mean_of_those_that_do():
    points, visible = looks(4, missing=0.6)
    merged, seen = average_frames(points, visible)
    assert (seen == visible.any(0)).all() and 0 < (~seen).sum() < 200 * 2 * 0.3  # 0.6⁴ = 0.13 expected
    np.testing.assert_allclose(merged[np.repeat(seen, 2, -1)], TRUE[np.repeat(seen, 2, -1)])


BEFORE = np.random.default_rng(0).uniform(0, 240, (10, 4))
VISIBLE = np.ones((10, 2), bool)


def late(by, moved_px=5.0, **disturbed):
    def look(k):
        true = BEFORE + (moved_px if k >= by else 0.0)
        return disturb(Settings.paper(**disturbed).amounts(ImageDisturbance), true, VISIBLE, [1, k])

    return look


@pytest.mark.parametrize("by", range(MAX_LATENCY_LOOKS + 1))
def test_latency_is_the_number_of_looks_before_the_motion_shows(by):
    assert estimate_latency((BEFORE, VISIBLE), late(by), 0.0) == by
    assert estimate_latency((BEFORE, VISIBLE), late(by, noise_px=0.5, outliers=0.1, missing=0.1), 0.5) == by


@pytest.mark.parametrize("settings", [Settings.paper(), Settings()])
@pytest.mark.parametrize("delay", [1, MAX_LATENCY_LOOKS])
def test_a_learner_with_late_pictures_moves_as_one_without(settings, delay):
    runs = []
    for late_by in (0, delay):
        session = Session(settings)
        session.change(delay=late_by)
        session.run()
        at_rest = "settled" if settings.servo == "broyden" else "converged"
        assert session.snapshot.lag == late_by and session.snapshot.status == at_rest
        runs.append([moment.theta for moment in session.history])
    np.testing.assert_array_equal(*runs)
