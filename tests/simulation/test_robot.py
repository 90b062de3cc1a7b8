"""Forward kinematics against PyBullet, grids against single postures, and what a URDF may not be."""

import numpy as np
import pytest

from viewimit.simulation.robot import Robot
from viewimit.simulation.scene import load_robot

ORIGINAL_URDF = {"panda": "franka_panda/panda.urdf", "iiwa": "kuka_iiwa/model.urdf"}


@pytest.mark.parametrize("name", ORIGINAL_URDF)
def test_link_frames_are_pybullets(name):
    """getLinkState item 4 is the link's frame, item 0 its centre of mass. PyBullet works in single precision."""
    p = pytest.importorskip("pybullet")
    data = pytest.importorskip("pybullet_data")
    path = f"{data.getDataPath()}/{ORIGINAL_URDF[name]}"
    robot = load_robot(name)
    client = p.connect(p.DIRECT)
    try:
        body = p.loadURDF(path, useFixedBase=True, physicsClientId=client)
        infos = [p.getJointInfo(body, j, physicsClientId=client) for j in range(p.getNumJoints(body, client))]
        arm = [info[0] for info in infos if info[2] == p.JOINT_REVOLUTE][: len(robot.joints)]
        assert len(robot.joints) == 7
        rng = np.random.default_rng(0)
        for _ in range(20):
            angles = rng.uniform(robot.lower, robot.upper)
            for joint, angle in zip(arm, angles):
                p.resetJointState(body, joint, angle, physicsClientId=client)
            frames = robot.link_frames(angles)
            for k, joint in enumerate(arm, start=1):
                state = p.getLinkState(body, joint, computeForwardKinematics=True, physicsClientId=client)
                np.testing.assert_allclose(frames[k][:3, 3], state[4], atol=1e-6)
                rotation = np.reshape(p.getMatrixFromQuaternion(state[5]), (3, 3))
                np.testing.assert_allclose(frames[k][:3, :3], rotation, atol=1e-6)
    finally:
        p.disconnect(client)


def joint(name, parent, child, kind="revolute", axis="0 0 1", more=""):
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<axis xyz="{axis}"/><limit lower="-1" upper="2"/>{more}</joint>'
    )


def read(tmp_path, *joints, root="robot", tip=None):
    path = tmp_path / "arm.urdf"
    path.write_text(f"<{root}>{''.join(joints)}</{root}>")
    return Robot.from_urdf(path, tip)


def test_fixed_joints_are_merged_and_the_longest_chain_is_taken(tmp_path):
    robot = read(
        tmp_path,
        joint("a", "base", "one"),
        joint("bolt", "one", "plate", "fixed", more='<origin xyz="0 0 1"/>'),
        joint("b", "plate", "two", "continuous", more='<origin xyz="1 0 0"/>'),
        joint("finger", "one", "tip"),
        joint("c", "two", "three", axis="0 1 0"),
    )
    assert [j.name for j in robot.joints] == ["a", "b", "c"]
    np.testing.assert_allclose(robot.joints[1].T_parent_joint[:3, 3], [1, 0, 1])
    np.testing.assert_allclose(robot.lower, [-1, -np.pi, -1])
    np.testing.assert_allclose(robot.upper, [2, np.pi, 2])


@pytest.mark.parametrize(
    "joints, options, message",
    [
        ([joint("a", "base", "one", "fixed")], {}, "no revolute joint"),
        ([], {}, "no revolute joint"),
        ([joint("a", "base", "one", axis="0 0 0")], {}, "joint 'a': its axis is zero"),
        ([joint("a", "base", "one", axis="0 zero 1")], {}, "joint 'a'.*is not numbers"),
        ([joint("a", "base", "one", axis="0 1")], {}, "joint 'a'.*is not numbers"),
        ([joint("a", "", "one")], {}, "joint 'a' has no <parent"),
        ([joint("a", "base", "one")], {"tip": "hand"}, "no link 'hand'"),
        ([joint("a", "two", "one"), joint("b", "one", "two")], {"tip": "one"}, "loop"),
        ([joint("a", "two", "one"), joint("b", "one", "two"), joint("c", "two", "hand")], {}, "loop"),
        ([joint("a", "base", "one")], {"root": "html"}, "root element is <html>"),
        ([joint("a", "base", "one"), '<link name="base"/>'], {}, "joint 'a' names the link 'one', which is not there"),
        ([joint("a", "base", "one"), '<link name="one"/>'], {}, "joint 'a' names the link 'base', which is not there"),
    ],
)
def test_errors_name_the_file_and_the_fault(tmp_path, joints, options, message):
    with pytest.raises(ValueError, match=rf"arm\.urdf: .*{message}"):
        read(tmp_path, *joints, **options)


def test_a_file_that_does_not_parse_or_is_not_there(tmp_path):
    path = tmp_path / "arm.urdf"
    with pytest.raises(ValueError, match=r"arm\.urdf: cannot be read"):
        Robot.from_urdf(path)
    path.write_text("<robot><joint></robot>")
    with pytest.raises(ValueError, match=r"arm\.urdf: not a URDF that parses"):
        Robot.from_urdf(path)
