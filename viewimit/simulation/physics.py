"""A connection to PyBullet of one's own, and silence: it prints to the process's standard output, past Python."""

import contextlib
import copy
import os
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from ..assets import ROOT
from ..geometry.rigid import rigid_transform, rotation_about_axis
from .markers import Markers, colours
from .scene import Scene, load_robot


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """What C code prints meanwhile, on either stream, goes nowhere: standard output belongs to the commands."""
    sys.stdout.flush()
    sys.stderr.flush()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    kept = [(stream, os.dup(stream)) for stream in (1, 2)]
    try:
        for stream, _ in kept:
            os.dup2(nowhere, stream)
        yield
    finally:
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)
        os.close(nowhere)


with quiet():
    import pybullet  # noqa: F401 - says when it was built
    from pybullet_utils.bullet_client import BulletClient


def connect() -> BulletClient:
    """A world of its own, without a window; it ends with the last reference to it."""
    with quiet():
        return BulletClient(pybullet.DIRECT)


# An arm with weight: motors of limited torque and speed drive it, and hold it against gravity, a little below.

STEP_S = 1 / 240  # PyBullet's own, for which its motors are made
GRAVITY = 9.81
STIFFNESS, DAMPING = 0.1, 0.5  # of PyBullet's motors; they let a Panda sag by 0.1° to 0.3°
STILL, LONGEST_S = 1e-4, 20.0  # rad/s; of simulated time
LOOK_EVERY = 10  # steps


class Arm:
    """One arm of a URDF on a fixed base, standing somewhere at rest. Joints are its revolute ones, base to tip."""

    def __init__(self, urdf: Path):
        self._client = connect()
        with quiet():
            self._body = self._client.loadURDF(str(urdf), useFixedBase=True)
        self._client.setGravity(0, 0, -GRAVITY)
        self._client.setTimeStep(STEP_S)
        infos = [self._client.getJointInfo(self._body, k) for k in range(self._client.getNumJoints(self._body))]
        infos = [info for info in infos if info[2] == self._client.JOINT_REVOLUTE]
        self._joints = [info[0] for info in infos]
        self._effort, self._speed = [info[10] for info in infos], [info[11] for info in infos]

    def drive(self, theta: NDArray, command: NDArray) -> NDArray:
        """From rest at theta to where it comes to rest once told to go to `command`; (m,) rad each."""
        for joint, angle in zip(self._joints, theta, strict=True):
            self._client.resetJointState(self._body, joint, float(angle))
        for joint, angle, effort, speed in zip(self._joints, command, self._effort, self._speed, strict=True):
            self._client.setJointMotorControl2(
                self._body,
                joint,
                self._client.POSITION_CONTROL,
                targetPosition=float(angle),
                force=effort,
                maxVelocity=speed,
                positionGain=STIFFNESS,
                velocityGain=DAMPING,
            )
        for _ in range(round(LONGEST_S / STEP_S / LOOK_EVERY)):
            for _ in range(LOOK_EVERY):
                self._client.stepSimulation()
            states = self._client.getJointStates(self._body, self._joints)
            if all(abs(state[1]) < STILL for state in states):
                break
        return np.array([state[0] for state in states])


# A scene's arm as a URDF that PyBullet loads: masses, motors, shapes and markers; joints at rest are braked.

ARM_GREY, STEM_GREY = 0.75, 0.5
STEM_M = 0.003  # radius
NOWHERE = (0.0, 0.0, 0.0)


def write_urdf(scene: Scene, markers: Markers, folder: Path) -> Path:
    """Write the arm of a scene, and its meshes, into a folder → its URDF.

    Of a shipped robot. Only the scene's moving joints are left; the others are braked at the scene's posture.
    """
    source = ROOT / "robots" / scene.robot
    root = ElementTree.parse(source / f"{scene.robot}.urdf").getroot()
    shapes = trimesh.load_scene(source / f"{scene.robot}.glb")
    joint_to = {child.get("link"): joint for joint in root.iter("joint") for child in joint.iter("child")}
    robot, revolute = load_robot(scene.robot), 0
    for link in root.findall("link"):
        joint = joint_to.get(link.get("name"))
        number = 0 if joint is None else None
        if joint is not None and joint.get("type") == "revolute":
            revolute += 1
            number = revolute
            if number not in scene.moving_joints:
                _brake(joint, robot.joints[number - 1], np.radians(scene.posture_deg[number - 1]))
        elif joint is not None:
            joint.set("type", "fixed")  # fingers too: their shapes belong to the hand's
        _give_mass(link)
        if number is not None:
            mesh = folder / f"link{number}.obj"
            shapes.geometry[f"link{number}"].export(mesh)
            _add_visual(link, ElementTree.Element("mesh", filename=str(mesh)), [ARM_GREY] * 3)
            for (owner, *centre, _), colour in zip(markers.balls, colours(markers.hue_deg)):
                if owner == number:
                    _add_visual(link, ElementTree.Element("sphere", radius=str(markers.radius)), colour, centre)
                    _add_stem(link, np.array(centre), shapes.geometry[f"link{number}"].vertices)
    path = folder / "arm.urdf"
    ElementTree.ElementTree(root).write(path)
    return path


def _brake(joint: ElementTree.Element, geometry, angle: float) -> None:
    T = geometry.T_parent_joint @ rigid_transform(rotation_about_axis(geometry.axis, angle))
    joint.set("type", "fixed")
    origin = joint.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(joint, "origin")
    origin.set("xyz", _text(T[:3, 3]))
    origin.set("rpy", _text(trimesh.transformations.euler_from_matrix(T, "sxyz")))


def _give_mass(link: ElementTree.Element) -> None:
    """PyBullet takes 1 kg where nothing is said."""
    if link.find("inertial") is None:
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "mass", value="0")
        ElementTree.SubElement(inertial, "inertia", dict.fromkeys(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), "0"))


def _add_visual(link: ElementTree.Element, shape: ElementTree.Element, colour, centre=NOWHERE, rpy=NOWHERE) -> None:
    visual = ElementTree.SubElement(link, "visual")
    ElementTree.SubElement(visual, "origin", xyz=_text(centre), rpy=_text(rpy))
    ElementTree.SubElement(visual, "geometry").append(copy.copy(shape))
    name = f"{link.get('name')}-{len(link)}"  # one name is one colour throughout the file
    material = ElementTree.SubElement(visual, "material", name=name)
    ElementTree.SubElement(material, "color", rgba=_text(np.array([*colour, 1.0])))


def _add_stem(link: ElementTree.Element, centre: NDArray, vertices: NDArray) -> None:
    """A rod from a ball's middle to the nearest of the link's vertices (V, 3) m."""
    along = vertices[np.linalg.norm(vertices - centre, axis=1).argmin()] - centre
    length = np.linalg.norm(along)
    x, y, z = along / length
    rod = ElementTree.Element("cylinder", radius=str(STEM_M), length=str(length))
    _add_visual(link, rod, [STEM_GREY] * 3, centre + along / 2, (0.0, np.arccos(z), np.arctan2(y, x)))


def _text(numbers: NDArray) -> str:
    return " ".join(f"{float(number):.17g}" for number in numbers)
