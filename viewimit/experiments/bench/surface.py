"""Points anywhere on the surface of a robot's links, which hides those that are turned away from a camera."""

from collections.abc import Sequence
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ...simulation.camera import Camera
from ...simulation.eyes import ProjectedEyes
from ...simulation.robot import Angles, BodyPoints, link_meshes
from ...simulation.scene import Scene
from ...simulation.world import World


class SurfaceEyes(ProjectedEyes):
    """Points on the surface, hidden where that is turned away. normals: (N, 3) of length 1, in the links' frames; None:
    all are seen; hidden: the cosine between normal and way to a camera up to which a point is hidden."""

    def __init__(self, scene: Scene, body: BodyPoints, normals: NDArray | None, hidden: float = 0.0):
        self.world, self._hidden = World(scene, body=body), hidden
        self._tips = None if normals is None else World(scene, body=BodyPoints(body.link, body.local + normals))

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        images, visible = super().demo_images(theta)
        return images, visible & self._facing(theta, self.world.T_world_demo, self.world.demo_cameras)

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        images, visible = super().own_images(theta)
        return images, visible & self._facing(theta, self.world.T_world_own, self.world.own_cameras)

    def _facing(self, theta: Angles, T_world_base: NDArray, cameras: Sequence[Camera]) -> NDArray:
        """(N, 2) bool"""
        if self._tips is None:
            return np.ones((len(self.world.body), len(cameras)), bool)
        points = self.world.points_world(theta, T_world_base)
        normals = self._tips.points_world(theta, T_world_base) - points
        to_camera = [camera.T_world_camera[:3, 3] - points for camera in cameras]
        facing = [(normals * to).sum(-1) / np.linalg.norm(to, axis=-1) for to in to_camera]
        return np.stack(facing, -1) > self._hidden


def surface_points(
    robot: str, links: Sequence[int], count: int, rng: np.random.Generator
) -> tuple[BodyPoints, NDArray]:
    """Even over the surface of these links, and the normals there, (count, 3)."""
    corners, normals, areas, link = _faces(robot)
    among = np.flatnonzero(np.isin(link, links))
    chosen = rng.choice(among, count, p=areas[among] / areas[among].sum())
    weights = rng.dirichlet(np.ones(3), count)
    return BodyPoints(link[chosen], np.einsum("nc,ncx->nx", weights, corners[chosen])), normals[chosen]


@cache
def _faces(robot: str) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Of all links: corners (f, 3, 3) m, normals (f, 3), areas (f,), links (f,)."""
    meshes = link_meshes(robot).items()
    corners = np.concatenate([mesh.triangles for _, mesh in meshes])
    normals = np.concatenate([mesh.face_normals for _, mesh in meshes])
    areas = np.concatenate([mesh.area_faces for _, mesh in meshes])
    return corners, normals, areas, np.concatenate([np.full(len(mesh.faces), link) for link, mesh in meshes])
