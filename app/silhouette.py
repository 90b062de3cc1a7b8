"""Silhouettes of an arm in two images: the hull of each link, from the vertices that are extreme in some direction.

A hull's support function is the largest projection onto a direction. Few directions, and the vertex
that is extreme in each, give a polygon inside the hull that lacks at most 2 px at its corners.
"""

import numpy as np
from numpy.typing import NDArray

from viewimit.camera import Camera
from viewimit.geometry.rigid import rotation_about_axis
from viewimit.robot import Joint
from viewimit.world import World

DIRECTIONS = 12  # corners of a polygon at most
NEAR = 0.05  # m
KEPT = 48  # directions in 3-D in which a link's vertices are kept


class Silhouettes:
    """Polygons and skeletons of arms. meshes: by link (0 = base), vertices (V, 3) m in the link's frame.

    Without meshes, as of a robot from a user's own URDF, there are skeletons only.
    """

    def __init__(self, meshes: dict[int, NDArray], world: World):
        self.world = world
        self._links = np.array(sorted(meshes), int)
        chosen = [_extreme_vertices(np.asarray(meshes[link], float)) for link in self._links]
        most = max(map(len, chosen), default=0)
        # short lists are filled up with their first vertex, which changes no hull
        filled = [np.concatenate([v, np.repeat(v[:1], most - len(v), axis=0)]) for v in chosen]
        self._vertices = np.array(filled).reshape(len(chosen), most, 3)
        self._turns = np.array([_turning(joint) for joint in world.robot.joints])  # (n, 3, 4, 4)
        self.memory: dict = {}  # what was drawn last of each arm, kept by those who draw

    def link_frames(self, theta: NDArray, T_world_base: NDArray) -> NDArray:
        """T_world_link of every link, (n + 1, 4, 4): as Robot.link_frames, with all joints turned at once."""
        angles = np.array([float(angle) for angle in self.world.joint_angles(theta)])[:, None, None]
        steps = self._turns[:, 0] + np.sin(angles) * self._turns[:, 1] + (1 - np.cos(angles)) * self._turns[:, 2]
        frames = np.empty((len(steps) + 1, 4, 4))
        frames[0] = T_world_base
        for i, step in enumerate(steps):
            np.matmul(frames[i], step, out=frames[i + 1])
        return frames

    def outlines(self, T_world_links: NDArray, cameras: tuple[Camera, ...]) -> NDArray:
        """(cameras, links, DIRECTIONS, 2) px: closed polygons, whose corners may repeat."""
        if len(self._links) == 0:
            return np.empty((len(cameras), 0, DIRECTIONS, 2))
        T = T_world_links[self._links]
        vertices = self._vertices @ np.swapaxes(T[:, :3, :3], 1, 2) + T[:, None, :3, 3]
        image = project(vertices, cameras)
        largest = (image @ _COMPASS.T).argmax(2)  # (cameras, links, DIRECTIONS)
        views, links = np.ogrid[: len(cameras), : len(largest[0])]
        return image[views[..., None], links[..., None], largest]

    def skeleton(self, T_world_links: NDArray, cameras: tuple[Camera, ...]) -> NDArray:
        """(cameras, n + 1, 2) px: the links' origins."""
        return project(T_world_links[:, :3, 3], cameras)


def project(points_world: NDArray, cameras: tuple[Camera, ...]) -> NDArray:
    """points_world: (..., 3) m → (cameras, ..., 2) px. All cameras at once; nothing is nearer to one than NEAR."""
    shape = (len(cameras),) + (1,) * (points_world.ndim - 1)
    T = np.array([camera.T_world_camera for camera in cameras])
    focal = np.array([camera.focal for camera in cameras]).reshape(shape)
    centre = np.array([camera.centre for camera in cameras]).reshape(shape + (2,))
    flat = points_world.reshape(-1, 3)
    in_camera = (flat - T[:, None, :3, 3]) @ T[:, :3, :3]
    in_camera = in_camera.reshape((len(cameras),) + points_world.shape)
    depth = np.maximum(in_camera[..., 2], NEAR)
    return in_camera[..., :2] * (focal / depth)[..., None] + centre


def _turning(joint: Joint) -> NDArray:
    """(3, 4, 4): what a joint's transform is made of by 1, sin and 1 - cos of its angle (Rodrigues)."""
    parts = np.zeros((3, 4, 4))
    quarter, half = (rotation_about_axis(joint.axis, angle) for angle in (np.pi / 2, np.pi))
    square = (half - np.eye(3)) / 2  # half a turn: I + 2 K²
    parts[0], parts[1, :3, :3], parts[2, :3, :3] = np.eye(4), quarter - np.eye(3) - square, square
    return joint.T_parent_joint @ parts


def _extreme_vertices(vertices: NDArray) -> NDArray:
    """Those that reach farthest in some of KEPT directions spread over the sphere (Fibonacci's spiral)."""
    i = np.arange(KEPT) + 0.5
    z, turn = 1 - 2 * i / KEPT, np.pi * (1 + 5**0.5) * i
    level = np.sqrt(1 - z * z)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), z])
    return vertices[np.unique((vertices @ directions).argmax(0))]


_ANGLES = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
_COMPASS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)
