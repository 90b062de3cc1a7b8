"""Adapters to other packages run where these are installed; the ROS 2 node also with a stand-in of rclpy."""

import collections
import re
import subprocess
import sys
from importlib import import_module

import numpy as np
import pytest

from viewimit import Session, Settings

SETTINGS = Settings(demonstrator_deg=(45, -90), start_deg=(25, -45))


def test_a_rerun_recording_holds_all_motions(tmp_path):
    pytest.importorskip("rerun")
    session = Session(SETTINGS)
    session.run()
    import_module("to_rerun").main(str(tmp_path / "run.rrd"), session)
    command = [sys.executable, "-m", "rerun", "rrd"]
    said = subprocess.run([*command, "print", tmp_path / "run.rrd"], capture_output=True, text=True).stdout
    rows = collections.Counter[str]()
    for count, path in re.findall(r"with (\d+) rows .*? - /(\S+) - data", said):  # a path may have several chunks
        rows[path] += int(count)
    looks = len(session.history)
    views = [f"{view}/seen" for view in ("demo_left", "demo_right", "own_left", "own_right")]
    for path in (*views, "own_left/recovered", "own_right/residual", "E", "joints/0", "joints/1", "status"):
        assert rows[path] == looks, path


def test_a_lerobot_data_set_is_read_back_as_it_was_written(tmp_path):
    pytest.importorskip("lerobot")
    module, sessions = import_module("to_lerobot"), [Session(SETTINGS), Session(Settings(demonstrator_deg=(60, -60)))]
    for session in sessions:
        session.run()
    module.main(str(tmp_path / "runs"), sessions)
    back = module.LeRobotDataset("viewimit/runs", root=tmp_path / "runs")
    assert back.num_episodes == 2 and back.num_frames == sum(session.snapshot.motion for session in sessions)
    moments = list(sessions[0].history)
    for k, (now, after) in enumerate(zip(moments, moments[1:])):
        frame = back[k]
        np.testing.assert_allclose(frame["observation.state"], now.commanded, atol=1e-6)
        np.testing.assert_allclose(frame["action"], after.commanded, atol=1e-6)
        np.testing.assert_allclose(frame["observation.points.own"], now.views.own, rtol=1e-6)
        assert frame["task"] == "imitate the demonstrator's posture"


@pytest.mark.slow
def test_the_ros_2_node_imitates_over_topics(monkeypatch):
    """With a stand-in of rclpy, whose messages have the fields of the real definitions."""
    pytest.importorskip("rosbags")
    pytest.importorskip("cv2")
    import stand_in_rclpy
    from test_examples import Picture

    wire = stand_in_rclpy.installed(monkeypatch)
    module, fake = import_module("ros2_node"), import_module("fake_robot")
    robot = fake.FakeRobot((25, -40, 70))
    joints = ["a", "b", "c"]
    wire.parameters = {
        "joints": joints, "lower_deg": [-60.0, -70.0, 10.0], "upper_deg": [60.0, 20.0, 110.0],
        "start_deg": [-20.0, -20.0, 40.0], "noise_px": 0.05, "max_step_deg": 30.0,
    }  # fmt: skip
    cameras, commands = [Picture(robot, side) for side in (0, 1)], []

    def follow(trajectory):
        commands.append(trajectory)
        (point,) = trajectory.points
        assert trajectory.joint_names == joints and point.time_from_start.sec == 4
        robot.theta = np.array(point.positions)

    def on_spin():
        state = module.JointState(name=[*reversed(joints), "finger"], position=[*robot.theta[::-1], 0.04])
        wire.publish("joint_states", state)
        for side, camera in zip(("left", "right"), cameras):
            wire.publish(f"{side}/image_raw", stand_in_rclpy.image_message(module.Image, camera.read()[1]))

    wire.subscriptions["joint_trajectory"] = [(module.JointTrajectory, follow)]
    wire.on_spin = on_spin
    module.main()
    assert np.abs(np.degrees(robot.theta) - (25, -40, 70)).max() < 1.5 and len(commands) > 4


def test_the_ros_2_node_waits_for_pictures_it_can_read(monkeypatch):
    pytest.importorskip("rosbags")
    pytest.importorskip("cv2")
    import stand_in_rclpy

    wire = stand_in_rclpy.installed(monkeypatch)
    module = import_module("ros2_node")
    wire.parameters = {"joints": ["a"], "lower_deg": [-60.0], "upper_deg": [60.0], "start_deg": [0.0], "noise_px": 0.05}
    wire.parameters["max_step_deg"] = 30.0
    monkeypatch.setattr(module, "TIMEOUT_S", 0.0)
    wire.on_spin = lambda: None
    with pytest.raises(TimeoutError, match="a picture of each camera"):
        module.Robot().look()
    with pytest.raises(ValueError, match="bayer_rggb8"):
        module.picture_of(module.Image(encoding="bayer_rggb8", height=2, width=2, step=2, data=b"0000"))
