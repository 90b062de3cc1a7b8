"""PyBullet: a private connection, an arm with mass and motors, and the URDF that it loads.

This is the only module that imports pybullet. PyBullet prints to the standard output of the process, past Python, so
every call that prints is silenced.
"""

import contextlib
import copy
import os
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import ArrayLike, NDArray

from ..assets import ROOT
from ..geometry.rigid import rigid_transform, rotation_about_axis
from .robot import Joint, Markers, colours
from .scene import Scene, load_robot

STEP_S = 1 / 240  # PyBullet's own step, for which its motors are tuned
GRAVITY = 9.81  # m/s²
STIFFNESS, DAMPING = 0.1, 0.5  # gains of PyBullet's motors: a Panda sags by 0.1° to 0.3°
MAX_REST_SPEED, MAX_MOTION_S = 1e-4, 20.0  # rad/s; s of simulated time
CHECK_EVERY = 10  # steps
ARM_GREY, STEM_GREY = 0.75, 0.5
STEM_RADIUS_M = 0.003
NO_OFFSET = (0.0, 0.0, 0.0)
INERTIA = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")

Floats = NDArray[np.float64]


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


class Arm:
    """One arm of a URDF on a fixed base, driven by motors of limited torque and speed.

    The motors hold it against gravity, a little below the commanded posture. Its joints are the revolute ones, base
    to tip.
    """

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

    def drive(self, theta: Floats, command: Floats) -> Floats:
        """Move from rest at theta to a commanded posture, and return where the arm comes to rest; (m,) rad each."""
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
        for _ in range(round(MAX_MOTION_S / STEP_S / CHECK_EVERY)):
            for _ in range(CHECK_EVERY):
                self._client.stepSimulation()
            states = self._client.getJointStates(self._body, self._joints)
            if all(abs(state[1]) < MAX_REST_SPEED for state in states):
                break
        return np.array([state[0] for state in states])


def write_urdf(scene: Scene, markers: Markers, folder: Path) -> Path:
    """Write the arm of a scene with a shipped robot, its meshes and its markers into a folder, and return the URDF.

    Only the scene's moving joints remain; the others are fixed at the scene's posture.
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
                _fix(joint, robot.joints[number - 1], np.radians(scene.posture_deg[number - 1]))
        elif joint is not None:
            joint.set("type", "fixed")  # fingers too: their shapes belong to the hand's mesh
        _add_zero_mass(link)
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


def _fix(element: ElementTree.Element, joint: Joint, angle: float) -> None:
    T = joint.T_parent_joint @ rigid_transform(rotation_about_axis(joint.axis, angle))
    element.set("type", "fixed")
    origin = element.find("origin")
    if origin is None:
        origin = ElementTree.SubElement(element, "origin")
    origin.set("xyz", _text(T[:3, 3]))
    origin.set("rpy", _text(trimesh.transformations.euler_from_matrix(T, "sxyz")))


def _add_zero_mass(link: ElementTree.Element) -> None:
    """PyBullet assumes 1 kg for a link without inertia."""
    if link.find("inertial") is None:
        inertial = ElementTree.SubElement(link, "inertial")
        ElementTree.SubElement(inertial, "mass", value="0")
        ElementTree.SubElement(inertial, "inertia", dict.fromkeys(INERTIA, "0"))


def _add_visual(
    link: ElementTree.Element,
    shape: ElementTree.Element,
    colour: ArrayLike,
    centre: ArrayLike = NO_OFFSET,
    rpy: ArrayLike = NO_OFFSET,
) -> None:
    visual = ElementTree.SubElement(link, "visual")
    ElementTree.SubElement(visual, "origin", xyz=_text(centre), rpy=_text(rpy))
    ElementTree.SubElement(visual, "geometry").append(copy.copy(shape))
    name = f"{link.get('name')}-{len(link)}"  # a name means one colour throughout the file
    material = ElementTree.SubElement(visual, "material", name=name)
    ElementTree.SubElement(material, "color", rgba=_text([*np.asarray(colour), 1.0]))


def _add_stem(link: ElementTree.Element, centre: Floats, vertices: Floats) -> None:
    """Add a rod from the centre of a ball, (3,) m, to the nearest of the link's vertices, (V, 3) m."""
    along = vertices[np.linalg.norm(vertices - centre, axis=1).argmin()] - centre
    length = np.linalg.norm(along)
    x, y, z = along / length
    rod = ElementTree.Element("cylinder", radius=str(STEM_RADIUS_M), length=str(length))
    _add_visual(link, rod, [STEM_GREY] * 3, centre + along / 2, (0.0, np.arccos(z), np.arctan2(y, x)))


def _text(numbers: ArrayLike) -> str:
    return " ".join(f"{number:.17g}" for number in np.asarray(numbers, float).tolist())
