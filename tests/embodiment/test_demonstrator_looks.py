"""Every look at a demonstrator that stands still counts: servos get their mean, and the noise that they show."""

import numpy as np
import pytest

from viewimit import Session, Settings
from viewimit.loop.learner import average_looks

NOISY = {"noise_px": 0.25, "frames": 25}


def looks(rng, count, noise_px, points=40):
    exact, seen = rng.uniform(0, 200, (points, 4)), np.ones((points, 2), bool)
    return exact, [(exact + rng.normal(0, noise_px, exact.shape), seen) for _ in range(count)]


@pytest.mark.parametrize("ratio", [0.3, 1.0, 3.0])
def test_the_noise_of_the_mean_is_measured_by_what_the_looks_differ(ratio):
    exact, pictures = looks(np.random.default_rng(1), 16, 0.2 * ratio)
    (mean, visible), noise_px = average_looks(pictures, 0.2, 0.0)
    assert visible.all() and noise_px == pytest.approx(0.2 * ratio / 4, rel=0.15)
    assert np.sqrt(((mean - exact) ** 2).mean()) == pytest.approx(noise_px, rel=0.2)
    assert average_looks(pictures, 0.2, 0.5)[1] > 0.5


def test_a_session_collects_looks_until_the_demonstrator_moves():
    session = Session(Settings(seed=1, servo="likelihood", start_deg=(70, -140), **NOISY))
    for k in range(4):
        assert len(session.snapshot.demo_looks) == k + 1
        session.step()
    seen = session.observation(session.snapshot)
    exact = Session(Settings(servo="likelihood")).observation(Session(Settings()).snapshot).demo
    rms = lambda demo: float(np.sqrt(((demo - exact) ** 2).mean()))
    assert rms(seen.demo_average) < 0.75 * rms(seen.demo) and seen.demo_noise_px < 0.75 * seen.noise_px
    session.pose(np.radians((40, -80)))
    assert len(session.snapshot.demo_looks) == 1 and session.observation(session.snapshot).demo_average is None
    session.look()
    assert len(session.snapshot.demo_looks) == 2


def test_swaps_hold_for_the_mean_too():
    session = Session(Settings(seed=1, servo="likelihood", swapped=0.2, start_deg=(70, -140), **NOISY))
    session.run(30)
    seen = session.observation(session.snapshot)
    assert session.snapshot.exchanged and np.nanmax(np.abs(seen.demo_average - seen.demo)) < 1
