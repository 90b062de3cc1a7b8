"""Which joints of a URDF are the arm, and that they carry what PyBullet says they carry."""

import numpy as np
import pytest
from urdfs import arm, gripper, joint, link, write

from viewimit.simulation.robot import BodyPoints, Robot
from viewimit.simulation.urdf.chain import carrier_frames, find_arm
from viewimit.simulation.urdf.tree import read_tree


def names(path, tip=None, base=None):
    return [joint.name for joint in Robot.from_urdf(path, tip, base).joints]


def leg(side, xyz):
    return (
        joint(f"{side}_hip", "pelvis", f"{side}_thigh", xyz=xyz),
        joint(f"{side}_knee", f"{side}_thigh", f"{side}_shin", xyz="0 0 -0.4"),
    )


def torso_arm(side, xyz):
    return (
        joint(f"{side}_shoulder", "chest", f"{side}_upper", xyz=xyz),
        joint(f"{side}_elbow", f"{side}_upper", f"{side}_lower", xyz="0 0 -0.3"),
        joint(f"{side}_wrist", f"{side}_lower", f"{side}_hand", xyz="0 0 -0.3"),
    )


@pytest.mark.parametrize(
    "fingers",
    [
        gripper("lower"),
        (joint("jaw", "lower", "beak", xyz="0 0 0.3"),),
        (joint("hand_slide", "lower", "plate", "prismatic", xyz="0 0 0.3"),),
        (joint("grip_close", "lower", "pad", xyz="0 0 0.3"),),
        (
            joint("bolt", "lower", "gripper_body", "fixed", xyz="0 0 0.3"),
            joint("servo 4", "gripper_body", "gripper_moving_side"),
        ),
        (joint("bolt", "lower", "LeftHand", "fixed"), joint("m4", "LeftHand", "hand_plate", "continuous", more="")),
    ],
)
def test_fingers_are_not_joints_of_the_arm(tmp_path, fingers):
    assert names(write(tmp_path, *arm(*fingers))) == ["yaw", "lift", "elbow"]


def test_of_a_humanoid_the_chain_with_most_joints_is_taken_or_the_one_that_is_asked_for(tmp_path):
    path = write(
        tmp_path,
        *leg("left", "0 0.1 0"), *leg("right", "0 -0.1 0"),
        joint("waist", "pelvis", "chest", xyz="0 0 0.3"),
        *torso_arm("left", "0 0.2 0"), *torso_arm("right", "0 -0.2 0"),
    )  # fmt: skip
    assert names(path) == ["waist", "left_shoulder", "left_elbow", "left_wrist"]
    assert names(path, tip="right_hand") == ["waist", "right_shoulder", "right_elbow", "right_wrist"]
    assert names(path, tip="right_shin") == ["right_hip", "right_knee"]
    assert names(path, base="chest") == ["left_shoulder", "left_elbow", "left_wrist"]
    assert names(path, tip="right_lower", base="chest") == ["right_shoulder", "right_elbow"]
    with pytest.raises(ValueError, match="link 'left_shin' does not hang on link 'chest'"):
        names(path, tip="left_shin", base="chest")
    with pytest.raises(ValueError, match="no link 'tail'; its links are chest, left_hand"):
        names(path, base="tail")


def test_a_prismatic_joint_is_fixed_inside_its_limits(tmp_path):
    """A torso that slides from 0.1 to 0.6 m along an axis of any length rests a fifth above its lower end."""
    lift = joint(
        "torso", "rail", "base", "prismatic", axis="0 0 2", xyz="0 0 1", more='<limit lower="0.1" upper="0.6"/>'
    )
    robot = Robot.from_urdf(write(tmp_path, lift, *arm()))
    assert [one.name for one in robot.joints] == ["yaw", "lift", "elbow"]
    np.testing.assert_allclose(robot.joints[0].T_parent_joint[:3, 3], [0, 0, 1 + 0.2 + 0.1])


def test_a_mimic_joint_follows_its_leader_alone_and_in_the_chain(tmp_path):
    path = write(
        tmp_path,
        joint("a", "base", "one", axis="0 0 1", xyz="0 0 0.1"),
        joint(
            "b",
            "one",
            "two",
            xyz="0.2 0 0",
            more='<limit lower="-3" upper="3"/><mimic joint="a" multiplier="-2" offset="0.3"/>',
        ),
        joint("c", "two", "three", axis="1 0 0", xyz="0.2 0 0"),
    )
    robot = Robot.from_urdf(path, tip="three")
    assert robot.has_mimics and robot.movable_joints == (1, 3)
    told = np.array([0.4, 99.0, -0.2])  # what is said of the follower is not heeded
    np.testing.assert_array_equal(
        robot.link_frames(robot.with_mimics(told))[2], robot.link_frames([0.4, -0.5, -0.2])[2]
    )
    body = BodyPoints(np.array([0, 1, 2, 3]), np.full((4, 3), 0.1))
    for moving in ([0, 2], [0], [2]):
        chain, links = robot.with_fixed_joints(np.array([0.4, 99.0, -0.2]), moving)
        points = links.points(body)
        theta = [told[k] + 0.3 for k in moving]
        whole = told.copy()
        whole[moving] = theta
        for index, xyz in chain.place_points(chain.expand_mimics(theta), points):
            T = robot.link_frames(robot.with_mimics(whole))[body.link[index]]
            np.testing.assert_allclose(xyz.T, T[:, :3, 3] + 0.1 * T[:, :3, :3].sum(2), atol=1e-14)
        carried = links.link_frames(chain.link_frames(chain.expand_mimics(theta)))
        np.testing.assert_allclose(carried, robot.link_frames(robot.with_mimics(whole)), atol=1e-14)


def test_link_frames_equal_pybullets(tmp_path):
    """Every link of a tree with a slide, fingers and a second arm, at rest and with the arm turned."""
    p = pytest.importorskip("pybullet")
    lift = joint("torso", "rail", "base", "prismatic", axis="0 0 1", more='<limit lower="-0.2" upper="0.6"/>')
    other = joint("head", "base", "face", axis="0 0 1", xyz="0.1 0 0.5", more='<limit lower="0.4" upper="1"/>')
    path = write(tmp_path, link("rail"), lift, *arm(*gripper("lower"), other, link("face", "0.1 0.1 0.1")))
    tree = read_tree(path)
    chain = find_arm(tree)
    robot, frames = Robot.from_urdf(path), carrier_frames(tree, chain)
    assert set(frames) == set(tree.links)
    client = p.connect(p.DIRECT)
    try:
        body = p.loadURDF(str(path), useFixedBase=True, physicsClientId=client)
        infos = [p.getJointInfo(body, k, physicsClientId=client) for k in range(p.getNumJoints(body, client))]
        at_rest = {one.name: tree.rest(one, 0.2 if one in chain.joints else 0.0) for one in tree.joints}
        for angles in ([0.0, 0.0, 0.0], [0.3, -0.7, 1.1]):
            turned = dict(zip(["yaw", "lift", "elbow"], angles))
            for info in infos:
                name = info[1].decode()
                p.resetJointState(body, info[0], (at_rest | turned)[name], physicsClientId=client)
            T_base_links = robot.link_frames(angles)
            for info in infos:
                number, T_carrier_link = frames[info[12].decode()]
                state = p.getLinkState(body, info[0], computeForwardKinematics=True, physicsClientId=client)
                T = T_base_links[number] @ T_carrier_link
                np.testing.assert_allclose(T[:3, 3], state[4], atol=1e-6)
                np.testing.assert_allclose(
                    T[:3, :3], np.reshape(p.getMatrixFromQuaternion(state[5]), (3, 3)), atol=1e-6
                )
    finally:
        p.disconnect(client)


@pytest.mark.parametrize(
    "parts, message",
    [
        (
            (joint("a", "base", "one", more='<limit lower="1" upper="-1"/>'),),
            "joint 'a': its limits lower=1 upper=-1 .*swap",
        ),
        ((joint("a", "base", "one"), joint("b", "two", "one")), "link 'one' hangs on two joints, 'a' and 'b'"),
        ((joint("a", "base", "one", xyz="$(arg x) 0 0"),), "joint 'a': .* is xacro: run it through xacro"),
        ((joint("a", "base", "one", "prismatic"),), "no revolute joint between the root link and any tip"),
        (tuple(joint(f"j{k}", f"l{k}", f"l{k + 1}") for k in range(600)), "600 joints, more than 500"),
        ((joint("a", "base", "one"), joint("a", "one", "two")), "2 joints are named 'a': give each a name of its own"),
        ((joint("a", "base", "one"), link("one"), link("one")), "2 links are named 'one'"),
    ],
)
def test_errors_name_file_joint_and_limit(tmp_path, parts, message):
    with pytest.raises(ValueError, match=rf"small\.urdf: .*{message}"):
        Robot.from_urdf(write(tmp_path, *parts))


def test_an_entity_bomb_is_refused(tmp_path):
    bomb = "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 12))
    path = tmp_path / "bomb.urdf"
    path.write_text(f'<!DOCTYPE robot [<!ENTITY a0 "lol">{bomb}]><robot name="&a11;"/>')
    with pytest.raises(ValueError, match=r"bomb\.urdf: not a URDF that parses"):
        Robot.from_urdf(path)
