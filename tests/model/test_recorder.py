"""Recording and replaying the demonstrator: even steps from uneven ticks, real time, files, and other scenes."""

import json

import msgspec
import numpy as np
import pytest
from viewimit.app.model.motions import FILE, MOST_BYTES, Motions, Recorder

from viewimit.analysis.trajectory import MOTIONS, STEP_S, decode_motion, encode_motion
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene

SCENE = load_scene("panda")


def recorded(times, degrees):
    """A recording of postures (k, 2) sampled at these times."""
    theta = np.radians(degrees)
    recorder = Recorder(SCENE, theta[0], times[0])
    for now, posture in zip(times[1:], theta[1:]):
        recorder.sample(posture, now)
    return recorder


def line(times):
    """A motion at 10°/s and −20°/s, (k, 2) degrees."""
    return np.stack([20 + 10 * np.asarray(times), -30 - 20 * np.asarray(times)], -1)


class TestRecorder:
    @pytest.mark.parametrize("seed", range(5))
    def test_ticks_that_jitter_make_even_steps(self, seed):
        rng = np.random.default_rng(seed)
        times = 100 + np.cumsum(rng.uniform(0.02, 0.15, 60))
        made = recorded(times, line(times - times[0])).finish()
        frames = np.array(made.theta_deg)
        assert made.step_s == STEP_S
        np.testing.assert_allclose(frames[:-1], line(STEP_S * np.arange(len(frames) - 1)), atol=1e-5)
        np.testing.assert_allclose(frames[-1], line(times[-1] - times[0]), atol=1e-5)  # where it ended
        assert 0 <= STEP_S * (len(frames) - 1) - (times[-1] - times[0]) < STEP_S


class Desk:
    """Motions of a session with a clock of one's own; what is made aside waits until `make`."""

    def __init__(self):
        self.session, self.now = Session(Settings.paper()), 10.0
        self.aside, self.sent = [], []
        aside, send = lambda *asked: self.aside.append(asked), lambda *file: self.sent.append(file)
        self.motions = Motions(self.session, self.session.pose, aside, send, lambda: self.now)

    def make(self):
        waiting, self.aside[:] = list(self.aside), []
        for make, take in waiting:
            take(make())

    def tick(self, count=1, seconds=STEP_S):
        for _ in range(count):
            self.now += seconds
            self.motions.tick()

    def pose(self, *degrees):
        self.session.pose(np.radians(degrees))

    @property
    def demonstrator(self):
        return self.session.settings.demonstrator_deg

    def record(self, degrees):
        self.motions.record()
        for posture in degrees:
            self.tick()
            self.pose(*posture)
        self.tick()
        self.motions.record()


@pytest.fixture
def desk():
    return Desk()


WAVE = [(45.0 + k, -90.0 - 2 * k) for k in range(1, 21)]


class TestMotions:
    def test_a_recording_is_replayed_in_real_time_and_the_learner_moves_on(self, desk):
        desk.record(WAVE)
        assert desk.motions.name == "recorded" and desk.motions.recorded.seconds == pytest.approx(1.0)
        desk.pose(10, -10)
        desk.motions.replay()
        assert desk.demonstrator == pytest.approx((45, -90))
        desk.tick(5)
        assert desk.demonstrator == pytest.approx(WAVE[4], abs=1e-4) and desk.motions.moment == (0.25, 1.0)
        desk.session.step()
        desk.tick(20)
        assert desk.demonstrator == pytest.approx(WAVE[-1], abs=1e-4)
        assert not desk.motions.replaying and desk.session.snapshot.motion == 1

    def test_saved_and_loaded_it_is_the_same_motion(self, desk):
        desk.record(WAVE)
        made = desk.motions.recorded
        desk.motions.save()
        ((name, data),) = desk.sent
        assert name == FILE and json.loads(data)["theta_deg"][-1] == list(WAVE[-1])
        other = Desk()
        other.motions.load(data)
        assert other.motions.recorded == made == decode_motion(data, SCENE) and other.motions.name == "recorded"
        assert other.motions.asked_for() == made

    @pytest.mark.parametrize("name", MOTIONS)
    def test_made_up_motions_are_made_aside_about_the_present_posture(self, desk, name):
        desk.pose(60, -60)
        desk.motions.choose(name)
        desk.motions.replay()
        assert desk.demonstrator == (60, -60) and len(desk.aside) == 1
        desk.make()
        assert desk.motions.replaying and desk.motions.moment == (0, 5.95)
        expected = np.array(MOTIONS[name](desk.session.world, np.radians([60.0, -60.0])).theta_deg)
        desk.tick(30)
        assert desk.demonstrator == pytest.approx(expected[30], abs=1e-3)
        desk.motions.scrub(4.5)  # of the same motion, not of one about this posture
        assert desk.demonstrator == pytest.approx(expected[90], abs=1e-4) and not desk.aside
        assert desk.motions.asked_for() == name

    def test_whoever_moves_the_demonstrator_ends_the_replay(self, desk):
        desk.record(WAVE)
        desk.motions.replay()
        desk.tick(3)
        desk.pose(10, -10)
        desk.tick(3)
        assert desk.demonstrator == (10, -10) and not desk.motions.replaying

    def test_a_refused_file_changes_nothing(self, desk):
        desk.record(WAVE)
        kept = desk.motions.recorded
        others = msgspec.structs.replace(kept, joints=(1, 2))
        for data, words in (
            (b"not json", "not a recorded motion"),
            (b"", "not a recorded motion: the file is empty"),
            (b"\xff\xfe", "not a recorded motion"),
            (b'{"format": "viewimit motion 1"}', "missing required field"),
            (encode_motion(others), "it moves joints 1, 2"),
            (encode_motion(msgspec.structs.replace(kept, step_s=0.0)), "step_s must be"),
            (MOST_BYTES + 1, "at most 1 MB"),
        ):
            with pytest.raises(ValueError, match=words):
                desk.motions.load(data)
        assert desk.motions.recorded is kept and desk.motions.name == "recorded"
