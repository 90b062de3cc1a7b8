"""Pictures of both arms in a plain room, drawn by numpy alone, and image points detected in them.

Only detections reach the method.
"""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import VIEWS
from ..geometry.arrays import Floats
from ..sensing.detection import Detections, detect, hit_range, reject_partly_hidden
from .camera import Camera
from .depth_buffer import DepthBuffer, Triangles, illumination
from .meshes import Mesh
from .robot import Angles, Markers, colours, link_meshes, load_markers
from .scene import Scene
from .world import SimulatedEyes, World

SAMPLES = 2  # for each pixel and axis, as a sensor gathers light over the whole pixel
PEDESTAL_M = 0.16  # half the width
MARGIN_M, HEIGHT_M = 2.5, 3.0  # of the room, around the bases and the head
FLOOR_GREY, WALL_GREY, PEDESTAL_GREY, SKY_GREY = 0.55, 0.8, 0.4, 1.0
ARM_GREY, STEM_GREY = 0.75, 0.5
STEM_RADIUS_M, STEM_SIDES = 0.003, 12
SEARCHED_WIDTH = 0.56  # fraction of a picture's width: the head turns to the body that it watches
NOISE_PX = 0.08  # standard deviation of a coordinate, as studies/detection.py measures it

Visible = NDArray[np.bool_]
Picture = NDArray[np.uint8]
Colours = NDArray[np.uint32]
Layer = tuple[NDArray[np.floating], Colours]  # inverse depths [1/m] and packed colours of all samples


class Studio:
    """A room in which an arm stands at each of two bases. The room is drawn once for each camera.

    markers: the balls that both arms wear.
    """

    def __init__(self, world: World, markers: Markers):
        self._world, self._markers, self._colours = world, markers, colours(markers.hue_deg)
        self._skin, self._room = Skin(link_meshes(world.scene.robot), markers), Room(world.scene)
        self._empty: dict[bytes, tuple[Layer, Picture]] = {}  # samples and picture of the room, by camera

    def picture(self, camera: Camera, theta_demo: Floats, theta_own: Floats) -> Picture:
        """Draw both arms at postures, (m,) rad each: (height, width, 3) RGB, each pixel the mean of SAMPLES²."""
        key = camera.T_world_camera.tobytes()
        if key not in self._empty:
            layer = self._room.seen_by(camera)
            self._empty[key] = layer, _mean(layer[1])
        (behind, room), empty = self._empty[key]
        buffer = self.arms(camera, theta_demo, theta_own)
        nearer, arms, picture = buffer.inverse_depth > behind, buffer.colours, empty.copy()
        if nearer.any():  # elsewhere the picture is that of the empty room
            rows, columns = (hit_range(np.any(np.reshape(nearer.any(axis), (-1, SAMPLES)), 1)) for axis in (1, 0))
            part = tuple(slice(SAMPLES * pixels.start, SAMPLES * pixels.stop) for pixels in (rows, columns))
            picture[rows, columns] = _mean(np.where(nearer[part], arms[part], room[part]))
        return picture

    def arms(self, camera: Camera, theta_demo: Floats, theta_own: Floats) -> DepthBuffer:
        """Draw both arms without the room, as `picture`."""
        buffer, world = DepthBuffer(camera, SAMPLES), self._world
        for theta, T_world_base in ((theta_demo, world.T_world_demo), (theta_own, world.T_world_own)):
            frames = world.link_frames(theta, T_world_base)
            buffer.add_triangles(self._skin.at(frames))
            buffer.add_balls(self._markers.body.at(frames), self._colours, self._markers.radius)
        return buffer


class Skin:
    """The triangles of an arm, and thin stems that hold its balls."""

    def __init__(self, meshes: Mapping[int, Mesh], markers: Markers):
        parts = [(link, mesh, ARM_GREY) for link, mesh in meshes.items()]
        for link, centre in zip(markers.body.link.tolist(), markers.body.local):
            nearest = np.linalg.norm(meshes[link].vertices - centre, axis=1).argmin()
            parts.append((link, _rod(centre, meshes[link].vertices[nearest]), STEM_GREY))
        sizes = [len(mesh.vertices) for _, mesh, _ in parts]
        first = np.cumsum([0, *sizes[:-1]])
        self._link = np.repeat([link for link, _, _ in parts], sizes)
        self._grey = np.repeat([grey for _, _, grey in parts], sizes)
        self._local = np.concatenate([mesh.vertices for _, mesh, _ in parts])
        self._normals = np.concatenate([mesh.vertex_normals for _, mesh, _ in parts])
        self._faces = np.concatenate([mesh.faces + start for (_, mesh, _), start in zip(parts, first)])

    def at(self, T_world_links: Floats) -> Triangles:
        """Return the triangles in the world, given the frames of all links, (n + 1, 4, 4)."""
        R, t = T_world_links[self._link, :3, :3], T_world_links[self._link, :3, 3]
        vertices, normals = ((R @ vectors[..., None])[..., 0] for vectors in (self._local, self._normals))
        return Triangles(vertices + t, self._faces, normals, self._grey)


def _rod(start: Floats, end: Floats) -> Mesh:
    """A prism without ends between two points, (3,) m each."""
    along = (end - start) / np.linalg.norm(end - start)
    across = np.cross(along, np.eye(3)[np.abs(along).argmin()])
    across *= STEM_RADIUS_M / np.linalg.norm(across)
    turn = 2 * np.pi * np.arange(STEM_SIDES) / STEM_SIDES
    ring = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * np.cross(along, across)
    here, after = np.arange(STEM_SIDES), (np.arange(STEM_SIDES) + 1) % STEM_SIDES
    there = here + STEM_SIDES
    faces = np.concatenate([np.stack([here, after, there], -1), np.stack([after, after + STEM_SIDES, there], -1)])
    return Mesh(np.concatenate([start + ring, end + ring]), faces)


class Room:
    """A floor, four walls, and a pedestal below each base that is not on the floor."""

    def __init__(self, scene: Scene):
        bases = np.array([scene.demonstrator.position, scene.learner.position])
        places = np.array([scene.head.position, *bases])
        low, high = places.min(0) - MARGIN_M, places.max(0) + MARGIN_M
        self._inside = np.array([[*low[:2], 0.0], [*high[:2], np.inf]])
        half = np.array([PEDESTAL_M, PEDESTAL_M, 0.0])
        self._pedestals = [np.array([base * (1, 1, 0) - half, base + half]) for base in bases if base[2] > 0]

    def seen_by(self, camera: Camera) -> Layer:
        """Draw it: arrays of (SAMPLES height, SAMPLES width)."""
        rows, columns = (np.arange(SAMPLES * size) + 0.5 for size in (camera.height, camera.width))
        ray, eye = camera.ray(np.stack(np.meshgrid(columns, rows), -1) / SAMPLES), camera.T_world_camera[:3, 3]
        with np.errstate(divide="ignore", invalid="ignore"):
            depth, axis = _leaves(self._inside, eye, ray)
            above = (eye + depth[..., None] * ray)[..., 2] > HEIGHT_M
            greys = np.where(axis == 2, FLOOR_GREY, WALL_GREY)
            shade = np.where(above, SKY_GREY, greys * _lit(axis, -ray))
            depth[above] = np.inf
            for pedestal in self._pedestals:
                enters, axis = _enters(pedestal, eye, ray)
                nearer = enters < depth
                depth = np.where(nearer, enters, depth)
                shade = np.where(nearer, PEDESTAL_GREY * _lit(axis, -ray), shade)
        grey = (255 * shade + 0.5).astype(np.uint32)
        return 1 / depth, grey * np.uint32(0x010101)


def _leaves(box: Floats, eye: Floats, ray: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Depth at which rays (..., 3) from inside leave a box, (2, 3) m, and the axis of the face there."""
    depths = (np.where(ray > 0, box[1], box[0]) - eye) / ray
    return depths.min(-1), depths.argmin(-1)


def _enters(box: Floats, eye: Floats, ray: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Depth at which rays from outside enter a box, inf if they miss it, and the axis of the face there."""
    first = (np.where(ray > 0, box[0], box[1]) - eye) / ray
    last, _ = _leaves(box, eye, ray)
    enters = first.max(-1)
    return np.where((enters > 0) & (enters < last), enters, np.inf), first.argmax(-1)


def _lit(axis: NDArray[np.intp], towards: Floats) -> Floats:
    """Illumination of faces across an axis, whose normals point `towards` (..., 3)."""
    return illumination(np.sign(towards) * np.eye(3)[axis])


def _mean(samples: Colours) -> Picture:
    """Mean over each pixel, rounded: (SAMPLES h, SAMPLES w) packed colours -> (h, w, 3)."""
    channels = np.ascontiguousarray(samples)[..., None].view(np.uint8)[..., :3]
    total = np.full((samples.shape[0] // SAMPLES, samples.shape[1] // SAMPLES, 3), SAMPLES**2 // 2, np.uint16)
    for row in range(SAMPLES):
        for column in range(SAMPLES):
            total += channels[row::SAMPLES, column::SAMPLES]
    return (total // SAMPLES**2).astype(np.uint8)


class RenderedEyes(SimulatedEyes):
    """Detects marked points in rendered pictures.

    pictures, detections: by view l, r, L, R, the latest picture, (height, width, 3) RGB, and the markers detected in
    it; theta: by pair of views, the posture (m,) rad at which its arm was last seen; at first `rest`.
    """

    noise_px = NOISE_PX

    def __init__(self, scene: Scene):
        self.markers = load_markers(scene.robot)
        super().__init__(scene, body=self.markers.body)
        self.studio = Studio(self.world, self.markers)
        self.cameras: dict[str, Camera] = dict(zip(VIEWS, (*self.world.demo_cameras, *self.world.own_cameras)))
        rest = np.radians(scene.posture_deg)[scene.moving]
        self.rest = {"lr": rest, "LR": rest}
        self.theta = dict(self.rest)
        self.pictures: dict[str, Picture] = {}
        self.detections: dict[str, Detections] = {}

    def demo_images(self, theta: Angles) -> tuple[Floats, Visible]:
        return self._images("lr", theta)

    def own_images(self, theta: Angles) -> tuple[Floats, Visible]:
        return self._images("LR", theta)

    def look(self, view: str) -> Picture:
        """Render one view, detect its markers, and return the picture."""
        self.pictures[view] = self.studio.picture(self.cameras[view], self.theta["lr"], self.theta["LR"])
        self.detections[view] = detect(self.pictures[view], self.markers.hue_deg, SEARCHED_WIDTH)
        return self.pictures[view]

    def look_at(self, pair: str) -> None:
        """Render a pair of views and detect the markers that are not partly hidden in either."""
        for view in pair:
            self.look(view)
        both = reject_partly_hidden(*(self.detections[view] for view in pair))
        self.detections.update(zip(pair, both))

    def _images(self, pair: str, theta: Angles) -> tuple[Floats, Visible]:
        """Images at one posture after another, for m arrays broadcast against each other."""
        theta = np.stack(np.broadcast_arrays(*theta), -1)
        points, visible = [], []
        for posture in theta.reshape(-1, theta.shape[-1]):
            self.theta[pair] = posture
            self.look_at(pair)
            points.append(np.concatenate([self.detections[view].points for view in pair], -1))
            visible.append(np.stack([self.detections[view].found for view in pair], -1))
        shape = theta.shape[:-1] + (len(self.world.body),)
        return np.array(points).reshape((*shape, 4)), np.array(visible).reshape((*shape, 2))
