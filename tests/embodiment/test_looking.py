"""What a learner gets to see: how often it looks at whom, how noise is known, and which look shows a motion."""

import msgspec
import numpy as np
import pytest

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.simulated_robot import SimulatedObserver
from viewimit.sensing.frames import MAX_LATENCY_LOOKS
from viewimit.simulation.eyes import SimulatedEyes
from viewimit.simulation.scene import load_scene

START, DEMO = np.radians((25, -45)), np.radians((45, -90))


class CountingEyes(SimulatedEyes):
    """Remember what they were asked for."""

    def __init__(self):
        super().__init__(load_scene("panda"), 10)
        self.asked = []

    def demo_images(self, theta):
        self.asked.append("demo")
        return super().demo_images(theta)

    def own_images(self, theta):
        self.asked.append("own")
        return super().own_images(theta)


@pytest.fixture
def eyes():
    return CountingEyes()


@pytest.fixture
def observer(eyes):
    return SimulatedObserver(eyes, START)


def test_the_demonstrator_is_looked_at_again_only_when_it_or_its_disturbance_has_changed(eyes, observer):
    settings = Settings.paper(noise_px=0.1)
    for look in range(3):
        observer.four_views(settings, START, DEMO, look)
    assert eyes.asked.count("demo") == 1 and eyes.asked.count("own") == 3
    observer.four_views(settings, START, DEMO + 0.1, 3)
    assert eyes.asked.count("demo") == 2
    for change in ({"noise_px": 0.2}, {"missing": 0.1}, {"outliers": 0.1}, {"frames": 2}, {"seed": 8}):
        before = observer.demo(settings, DEMO)
        assert observer.demo(settings, DEMO) is before
        assert observer.demo(msgspec.structs.replace(settings, **change), DEMO) is not before, change


@pytest.mark.parametrize("frames", [1, 3])
def test_every_posture_of_the_demonstrator_has_noise_of_its_own_and_repeats_itself(eyes, frames):
    settings = Settings.paper(noise_px=0.3, frames=frames)
    postures = DEMO, DEMO + 0.1, DEMO, DEMO + 1e-12  # the last is the same but for rounding
    noise = [SimulatedObserver(eyes, START).demo(settings, one)[0] - eyes.demo_images(one)[0] for one in postures]
    np.testing.assert_array_equal(noise[0], noise[2])
    np.testing.assert_allclose(noise[0], noise[3], atol=1e-6)
    assert abs(np.corrcoef(noise[0].ravel(), noise[1].ravel())[0, 1]) < 0.5  # of 40 coordinates: 3 deviations


@pytest.mark.parametrize("delay", range(MAX_LATENCY_LOOKS + 1))
def test_the_first_motion_tells_how_late_images_come_and_later_ones_are_not_asked(eyes, observer, delay):
    now = Session(Settings.paper(start_deg=(25, -45), delay=delay)).snapshot
    assert observer.wait_for_motion(now, START + 0.1) == (delay, delay)
    assert observer.wait_for_motion(now, START) == (MAX_LATENCY_LOOKS, None)  # no motion that could show
    asked = len(eyes.asked)
    assert observer.wait_for_motion(now.with_fields(lag=2), START + 0.1) == (2, 2) and len(eyes.asked) == asked


def test_the_noise_is_measured_at_rest():
    for noise_px, frames in ((0.0, 1), (0.5, 1), (0.5, 25)):
        session = Session(Settings.paper(noise_px=noise_px, frames=frames, points=20, missing=0.1))
        told = session.observation(session.snapshot).noise_px
        assert told == pytest.approx(noise_px / np.sqrt(frames), rel=0.1, abs=1e-9)  # 560 degrees of freedom: 3 %
