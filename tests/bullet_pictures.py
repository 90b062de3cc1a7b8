"""The scene of `viewimit.simulation.rendering` drawn by PyBullet's renderer instead: an oracle of its pictures."""

import tempfile
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import trimesh
from viewimit.assets import ROOT

from viewimit.simulation.physics import connect, quiet, write_urdf
from viewimit.simulation.rendering import (
    ARM_GREY,
    FLOOR_GREY,
    HEIGHT_M,
    MARGIN_M,
    PEDESTAL_GREY,
    PEDESTAL_M,
    SAMPLES,
    STEM_GREY,
    STEM_RADIUS_M,
    WALL_GREY,
)
from viewimit.simulation.robot import colours, load_markers

NEAR_M, FAR_M, THICK_M = 0.05, 20.0, 0.05
LIGHT = {
    "lightDirection": (-1.5, 0.5, 3.0),
    "lightColor": (1.0, 1.0, 1.0),
    "lightAmbientCoeff": 0.55,
    "lightDiffuseCoeff": 0.4,
    "lightSpecularCoeff": 0.0,
    "shadow": 0,
}


class BulletStudio:
    """Draws as `viewimit.simulation.rendering.Studio`."""

    def __init__(self, scene):
        self._client = connect()
        with tempfile.TemporaryDirectory() as folder, quiet():
            urdf = write_visible_urdf(scene, load_markers(scene.robot), Path(folder))
            bodies = []
            for base in (scene.demonstrator, scene.learner):
                half = np.radians(base.yaw_deg) / 2
                turn = (0, 0, np.sin(half), np.cos(half))
                bodies.append(self._client.loadURDF(str(urdf), base.position, turn, useFixedBase=True))
        self._bodies = bodies
        revolute = self._client.JOINT_REVOLUTE
        joints = range(self._client.getNumJoints(bodies[0]))
        self._joints = [k for k in joints if self._client.getJointInfo(bodies[0], k)[2] == revolute]
        self._build_room(scene)

    def picture(self, camera, theta_demo, theta_own):
        """(height, width, 3) RGB"""
        samples, _ = self._draw(camera, theta_demo, theta_own)
        parts = samples.reshape(camera.height, SAMPLES, camera.width, SAMPLES, 3)
        return np.floor(parts.mean((1, 3)) + 0.5).astype(np.uint8)

    def depth_m(self, camera, theta_demo, theta_own):
        """Of arms and room: (SAMPLES height, SAMPLES width) m"""
        _, depth = self._draw(camera, theta_demo, theta_own)
        return FAR_M * NEAR_M / (FAR_M - depth * (FAR_M - NEAR_M))

    def _draw(self, camera, theta_demo, theta_own):
        for body, theta in zip(self._bodies, (theta_demo, theta_own)):
            for joint, angle in zip(self._joints, theta, strict=True):
                self._client.resetJointState(body, joint, float(angle))
        view, projection = opengl_matrices(camera, SAMPLES)
        width, height = SAMPLES * camera.width, SAMPLES * camera.height
        options = {"renderer": self._client.ER_TINY_RENDERER, "flags": self._client.ER_NO_SEGMENTATION_MASK, **LIGHT}
        _, _, colour, depth, _ = self._client.getCameraImage(width, height, view, projection, **options)
        return np.reshape(colour, (height, width, 4))[..., :3].astype(int), np.reshape(depth, (height, width))

    def _build_room(self, scene):
        bases = (scene.demonstrator, scene.learner)
        places = np.array([scene.head.position, *(base.position for base in bases)])
        low, high = places.min(0) - MARGIN_M, places.max(0) + MARGIN_M
        (x, y), (half_x, half_y) = (low + high)[:2] / 2, (high - low)[:2] / 2
        self._box((x, y, -THICK_M), (half_x, half_y, THICK_M), FLOOR_GREY)
        for side in (-1, 1):
            wall_x, wall_y = x + side * (half_x + THICK_M), y + side * (half_y + THICK_M)
            self._box((wall_x, y, HEIGHT_M / 2), (THICK_M, half_y, HEIGHT_M / 2), WALL_GREY)
            self._box((x, wall_y, HEIGHT_M / 2), (half_x, THICK_M, HEIGHT_M / 2), WALL_GREY)
        for x, y, height in (base.position for base in bases):
            if height > 0:
                self._box((x, y, height / 2), (PEDESTAL_M, PEDESTAL_M, height / 2), PEDESTAL_GREY)

    def _box(self, centre, half, grey):
        client, colour = self._client, (grey, grey, grey, 1)
        shape = client.createVisualShape(client.GEOM_BOX, halfExtents=[float(m) for m in half], rgbaColor=colour)
        client.createMultiBody(0, -1, shape, [float(m) for m in centre])


def opengl_matrices(camera, samples):
    """OpenGL's view and projection matrices, column by column, for `samples` rays in each pixel and axis.

    The renderer sends each ray through the upper right corner of its sample instead of the centre. The projection
    shifts by half a sample, so that points are drawn where `Camera.project` puts them.
    """
    width, height, half = camera.width, camera.height, 0.5 / samples
    view = np.diag([1.0, -1.0, -1.0, 1.0]) @ np.linalg.inv(camera.T_world_camera)
    projection = np.zeros((4, 4))
    (fx, fy), (cx, cy) = camera.lens.focal, camera.lens.centre
    projection[0, 0], projection[1, 1] = 2 * fx / width, 2 * fy / height
    projection[0, 2] = 1 - 2 * (cx - half) / width
    projection[1, 2] = 2 * (cy + half) / height - 1
    projection[2, 2:] = -(FAR_M + NEAR_M) / (FAR_M - NEAR_M), -2 * FAR_M * NEAR_M / (FAR_M - NEAR_M)
    projection[3, 2] = -1
    return view.T.ravel().tolist(), projection.T.ravel().tolist()


def write_visible_urdf(scene, markers, folder):
    """The URDF of `viewimit.simulation.physics` with meshes, balls and stems."""
    path = write_urdf(scene, folder)
    root = ElementTree.parse(path).getroot()
    shapes = trimesh.load_scene(ROOT / "robots" / scene.robot / f"{scene.robot}.glb").geometry
    source = ElementTree.parse(ROOT / "robots" / scene.robot / f"{scene.robot}.urdf").getroot()
    turning = [joint for joint in source.iter("joint") if joint.get("type") == "revolute"]
    children = {child.get("link") for joint in source.iter("joint") for child in joint.iter("child")}
    (base,) = (link.get("name") for link in source.findall("link") if link.get("name") not in children)
    numbers = {base: 0} | {joint.find("child").get("link"): k for k, joint in enumerate(turning, 1)}
    for link in root.findall("link"):
        number = numbers.get(link.get("name"))
        if number is None:
            continue
        mesh = folder / f"link{number}.obj"
        shapes[f"link{number}"].export(mesh)
        _show(link, ElementTree.Element("mesh", filename=str(mesh)), [ARM_GREY] * 3)
        for (owner, *centre, _), colour in zip(markers.balls, colours(markers.hue_deg)):
            if owner == number:
                _show(link, ElementTree.Element("sphere", radius=str(markers.radius)), colour, centre)
                _show_stem(link, np.array(centre), shapes[f"link{number}"].vertices)
    ElementTree.ElementTree(root).write(path)
    return path


def _show(link, shape, colour, centre=(0, 0, 0), rpy=(0, 0, 0)):
    visual = ElementTree.SubElement(link, "visual")
    text = lambda numbers: " ".join(f"{number:.17g}" for number in np.asarray(numbers, float).tolist())
    ElementTree.SubElement(visual, "origin", xyz=text(centre), rpy=text(rpy))
    ElementTree.SubElement(visual, "geometry").append(shape)
    name = f"{link.get('name')}-{len(link)}"  # a name means one colour throughout the file
    material = ElementTree.SubElement(visual, "material", name=name)
    ElementTree.SubElement(material, "color", rgba=text([*np.asarray(colour), 1.0]))


def _show_stem(link, centre, vertices):
    """A rod from the centre of a ball, (3,) m, to the nearest of the link's vertices, (V, 3) m."""
    along = vertices[np.linalg.norm(vertices - centre, axis=1).argmin()] - centre
    length = np.linalg.norm(along)
    x, y, z = along / length
    rod = ElementTree.Element("cylinder", radius=str(STEM_RADIUS_M), length=str(length))
    _show(link, rod, [STEM_GREY] * 3, centre + along / 2, (0.0, np.arccos(z), np.arctan2(y, x)))
