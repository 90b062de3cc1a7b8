"""PyBullet: a private connection, arms with mass and motors, and the URDF that it loads.

This is the only module that imports pybullet. PyBullet prints to the standard output of the process, past Python, so
every call that prints is silenced.
"""

import contextlib
import os
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import ArrayLike

from ..assets import ROOT
from ..geometry.arrays import Floats
from ..geometry.rigid import rigid_transform, rotation_about_axis
from .disturbances import ArmAmounts, SimulatedArm
from .disturbances import drive as disturbed
from .robot import Joint
from .scene import Scene, load_robot

STEP_S = 1 / 240  # PyBullet's own step, for which its motors are tuned
GRAVITY = 9.81  # m/s²
STIFFNESS, DAMPING = 0.1, 0.5  # gains of PyBullet's motors: a Panda sags by 0.1° to 0.3°
MAX_REST_SPEED, MAX_MOTION_S = 1e-4, 20.0  # rad/s; s of simulated time
CHECK_EVERY = 10  # steps
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Discard what C code prints to standard output and standard error meanwhile."""
    sys.stdout.flush()
    sys.stderr.flush()
    null = os.open(os.devnull, os.O_WRONLY)
    saved = [(stream, os.dup(stream)) for stream in (1, 2)]
    try:
        for stream, _ in saved:
            os.dup2(null, stream)
        yield
    finally:
        for stream, duplicate in saved:
            os.dup2(duplicate, stream)
            os.close(duplicate)
        os.close(null)


with quiet():
    import pybullet  # noqa: F401 - prints its build date
    from pybullet_utils.bullet_client import BulletClient


def connect() -> BulletClient:
    """Return a new simulation without a window. It ends with the last reference to it."""
    with quiet():
        return BulletClient(pybullet.DIRECT)


class PhysicalArm(SimulatedArm):
    """An arm that its motors, of limited torque and speed, hold a little below the commanded posture."""

    def __init__(self, scene: Scene):
        super().__init__(scene)
        self._client = connect()
        with tempfile.TemporaryDirectory() as folder, quiet():
            self._body = self._client.loadURDF(str(write_urdf(scene, Path(folder))), useFixedBase=True)
        self._client.setGravity(0, 0, -GRAVITY)
        self._client.setTimeStep(STEP_S)
        infos = [self._client.getJointInfo(self._body, k) for k in range(self._client.getNumJoints(self._body))]
        infos = [info for info in infos if info[2] == self._client.JOINT_REVOLUTE]  # base to tip
        self._joints = [info[0] for info in infos]
        self._effort, self._speed = [info[10] for info in infos], [info[11] for info in infos]

    def settle(self, theta: Floats) -> Floats:
        return self._move(theta, theta)

    def drive(self, amounts: ArmAmounts, start: Floats, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        """The disturbed command is the goal of the motors; `sent` is not used."""
        goal = disturbed(amounts, start, commanded)
        return self._move(theta, np.clip(goal, self._scene.lower, self._scene.upper))

    def _move(self, theta: Floats, command: Floats) -> Floats:
        """Move from rest at theta to a commanded posture, and return where the arm comes to rest; (m,) rad each."""
        for joint, angle in zip(self._joints, theta, strict=True):
            self._client.resetJointState(self._body, joint, float(angle))
        for joint, angle, effort, speed in zip(self._joints, command, self._effort, self._speed, strict=True):
            self._client.setJointMotorControl2(
                self._body, joint, self._client.POSITION_CONTROL, targetPosition=float(angle), force=effort,
                maxVelocity=speed, positionGain=STIFFNESS, velocityGain=DAMPING,
            )  # fmt: skip
        for _ in range(round(MAX_MOTION_S / STEP_S / CHECK_EVERY)):
            for _ in range(CHECK_EVERY):
                self._client.stepSimulation()
            states = self._client.getJointStates(self._body, self._joints)
            if all(abs(state[1]) < MAX_REST_SPEED for state in states):
                break
        return np.array([state[0] for state in states])


def write_urdf(scene: Scene, folder: Path) -> Path:
    """Write the arm of a scene with a shipped robot into a folder, without shapes, and return the URDF.

    Only the scene's moving joints remain; the others are fixed at the scene's posture.
    """
    path, robot, revolute = ROOT / "robots" / scene.robot / f"{scene.robot}.urdf", load_robot(scene.robot), 0
    root = ElementTree.parse(path).getroot()
    joint_to = {child.get("link"): joint for joint in root.iter("joint") for child in joint.iter("child")}
    for link in root.findall("link"):
        joint = joint_to.get(link.get("name"))
        if joint is not None and joint.get("type") == "revolute":
            revolute += 1
            if revolute not in scene.moving_joints:
                _fix(joint, robot.joints[revolute - 1], np.radians(scene.posture_deg[revolute - 1]))
        elif joint is not None:
            joint.set("type", "fixed")  # fingers too
        if link.find("inertial") is None:  # for which PyBullet assumes 1 kg
            inertial = ElementTree.SubElement(link, "inertial")
            ElementTree.SubElement(inertial, "mass", value="0")
            ElementTree.SubElement(inertial, "inertia", dict.fromkeys(INERTIA, "0"))
    path = folder / "arm.urdf"
    ElementTree.ElementTree(root).write(path)
    return path


def _fix(element: ElementTree.Element, joint: Joint, angle: float) -> None:
    T = joint.T_parent_joint @ rigid_transform(rotation_about_axis(joint.axis, angle))
    element.set("type", "fixed")
    origin = element.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(element, "origin")
    origin.set("xyz", _text(T[:3, 3]))
    origin.set("rpy", _text(trimesh.transformations.euler_from_matrix(T, "sxyz")))


def _text(numbers: ArrayLike) -> str:
    return " ".join(f"{number:.17g}" for number in np.asarray(numbers, float).tolist())
