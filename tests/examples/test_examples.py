"""The examples run as they stand, cameras and robots in them replaced by pictures and numbers."""

import re
import runpy
import sys
from importlib import import_module

import numpy as np
import pytest

from viewimit import Session


def error_deg(last, demonstrator_deg):
    return np.abs(np.degrees(last.theta) - demonstrator_deg).max()


def test_the_fake_robot_arrives_from_anywhere():
    module, rng = import_module("fake_robot"), np.random.default_rng(3)
    for _ in range(4):
        start, demo = rng.uniform(module.FakeRobot.lower + 0.1, module.FakeRobot.upper - 0.1, (2, 3))
        robot = module.FakeRobot(np.degrees(demo))
        robot.start = start
        last = Session.of(robot, robot).run(60).last
        assert last.status == "converged" and error_deg(last, np.degrees(demo)) < 0.1


def test_the_fake_robot_says_how_noisy_runs_end(examples, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["fake_robot.py", "--noise-px", "0.1", "--runs", "3"])
    runpy.run_path(str(examples / "fake_robot.py"), run_name="__main__")
    said = capsys.readouterr().out
    assert said.startswith("3 of 3 converged\n")
    median, most = map(float, re.search(r"error: median (.+)°, at most (.+)°", said).groups())
    assert 0 < median <= most < 1


def test_a_recorded_run_is_repeated_to_the_last_bit(tmp_path):
    module = import_module("recorded_run")
    robot = module.FakeRobot((30, -45, 80))
    recorder = module.Recorder(robot, robot)
    one = Session.of(recorder, recorder)
    one.run()
    recorder.save(tmp_path / "run.npz")
    replay = module.Replay(tmp_path / "run.npz")
    other = Session.of(replay, replay)
    other.run()
    assert len(one.history) == len(other.history)
    for there, here in zip(one.history, other.history):
        assert there.E == here.E and np.array_equal(there.theta, here.theta)
    replay = module.Replay(tmp_path / "run.npz")
    with pytest.raises(ValueError, match="the recorded arm went elsewhere"):
        Session.of(replay, replay).change(servo="broyden", start_deg=(0, 0, 50))


class Picture:
    """In place of a camera: pictures of the fake robot and its demonstrator, with markers on their points."""

    scale = 2  # of the fake robot's pictures

    def __init__(self, robot, side):
        self.robot, self.side, self.shown = robot, side, (None, None)

    def read(self):
        if self.shown[0] is not self.robot.theta:
            self.shown = self.robot.theta, self.taken()
        return True, self.shown[1]

    def taken(self):
        from tags import picture_of

        from viewimit.sensing.detection import Fiducials

        fake, webcams = import_module("fake_robot"), import_module("webcams")
        own = fake.picture_points(self.robot.theta, (-0.5, 2.2, -0.2), 0.2)[self.side]
        demo = fake.picture_points(self.robot.demonstrator, (0.25, 2.3, -0.2), -0.3)[self.side]
        middles = dict(enumerate(own)) | {webcams.DEMONSTRATOR + k: xy for k, xy in enumerate(demo)}
        middles = {number: self.scale * middle for number, middle in middles.items()}
        return picture_of(Fiducials("4x4_50").dictionary, middles, shape=(1920, 2560))


def test_webcams_and_printed_markers_imitate(monkeypatch, capsys):
    pytest.importorskip("cv2")
    module, fake = import_module("webcams"), import_module("fake_robot")
    robot = fake.FakeRobot((25, -40, 70))
    arm = module.ArmByHand()
    asked = []

    def by_hand(prompt):
        asked.append(np.radians([float(word) for word in re.findall(r"-?\d+\.\d*", prompt)]))
        robot.theta = asked[-1]

    detect, found = module.Fiducials.detect, {}

    def once(markers, picture):
        """The five pictures of a look are one array."""
        if id(picture) not in found:
            found[id(picture)] = picture, detect(markers, picture)
        return found[id(picture)][1]

    monkeypatch.setattr("builtins.input", by_hand)
    monkeypatch.setattr(module.Fiducials, "detect", once)
    session = module.main(arm, Picture(robot, 0), Picture(robot, 1))
    last = session.snapshot
    assert error_deg(last, (25, -40, 70)) < 1.5 and len(asked) == last.motion + 1
    assert f"after {last.motion} motions" in capsys.readouterr().out


def test_a_video_is_followed(tmp_path):
    fake, module = import_module("fake_robot"), import_module("video_demonstrator")
    t = np.linspace(0, 1, 60)[:, None]
    postures = np.radians(np.concatenate([-20 + 40 * t, -45 + 20 * np.sin(3 * t), 80 - 30 * t], 1))
    seen = np.array([fake.picture_points(theta, (0.3, 3.0, -0.2), 2.8) for theta in postures])
    for k, side in enumerate(("left", "right")):
        visible = np.ones((len(t), 20), bool)
        visible[:, 7] = k == 0  # one is lost in the right picture
        np.savez(tmp_path / f"{side}.npz", pred_tracks=seen[:, k], pred_visibility=visible)
    robot = fake.FakeRobot((0, 0, 0))
    followed = module.main(robot, robot, tmp_path / "left.npz", tmp_path / "right.npz")
    away = np.degrees(np.abs(followed - postures)).max(1)
    assert len(followed) == len(t) and away[0] < 0.1
    assert away.max() < 1.5  # a frame is up to a degree on from the one before, and it looks ahead by one
    assert np.degrees(np.abs(followed[3:-1] - postures[4:])).max() < 0.2
