"""Late pictures: the lag is found from the first motion that shows, and then costs no motion and no accuracy."""

import numpy as np
import pytest

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.sensing.frames import MAX_LATENCY_LOOKS, estimate_latency
from viewimit.simulation.disturbances import ImageDisturbance, disturb

BEFORE = np.random.default_rng(0).uniform(0, 240, (10, 4))
SEEN = np.ones((10, 2), bool)


def late(by, moved_px=5.0, **disturbed):
    def look(k):
        true = BEFORE + (moved_px if k >= by else 0.0)
        return disturb(Settings.paper(**disturbed).amounts(ImageDisturbance), true, SEEN, [1, k])

    return look


@pytest.mark.parametrize("by", range(MAX_LATENCY_LOOKS + 1))
def test_the_lag_is_how_many_looks_show_nothing_new(by):
    assert estimate_latency((BEFORE, SEEN), late(by), 0.0) == by
    assert estimate_latency((BEFORE, SEEN), late(by, noise_px=0.5, outliers=0.1, missing=0.1), 0.5) == by


def test_a_motion_that_does_not_show_tells_nothing():
    assert estimate_latency((BEFORE, SEEN), late(1, moved_px=0.0), 0.0) is None
    assert estimate_latency((BEFORE, SEEN), late(1, moved_px=1.0, noise_px=0.5), 0.5) is None
    assert estimate_latency((BEFORE, SEEN & False), late(0), 0.0) is None


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


def test_what_was_found_of_one_camera_is_not_believed_of_another():
    session = Session(Settings())
    session.step()
    assert session.snapshot.lag == 0
    session.change(delay=2)
    assert session.snapshot.lag is None and session.snapshot.motion == 0
