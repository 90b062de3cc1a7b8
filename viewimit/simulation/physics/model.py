"""A scene's arm as a URDF that PyBullet loads: masses, motors, shapes and markers; joints at rest are braked."""

import copy
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray

from ...assets import ROOT
from ...geometry.rigid import rigid_transform, rotation_about_axis
from ..markers import Markers, colours
from ..scene import Scene, load_robot

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
