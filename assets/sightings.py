"""Where balls on an arm would be seen, and whether: by the renderer's depth, before any is put there."""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..simulation.camera import Camera
from ..simulation.rendering import SAMPLES, Studio
from ..simulation.world import World

BEHIND_M = 0.004  # that a surface may lie before the ball's own without hiding it


@dataclass(frozen=True)
class Sightings:
    """Of K places in G postures, in both views of a body: image (G, K, 4) px, depth_m and radius_px (G, K, 2),
    clear (G, K, 2): nothing of the arm is before it."""

    image: NDArray[np.float64]
    depth_m: NDArray[np.float64]
    radius_px: NDArray[np.float64]
    clear: NDArray[np.bool_]

    def of(self, chosen: NDArray[np.intp]) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Images (G, N, 4) and seen (G, N): in both views, no nearer ball of the chosen before it."""
        image = self.image[:, chosen].reshape(len(self.image), -1, 2, 2)
        apart = np.linalg.norm(image[:, :, None] - image[:, None], axis=-1)
        touch = apart < self.radius_px[:, chosen, None] + self.radius_px[:, None, chosen]
        nearer = self.depth_m[:, None, chosen] < self.depth_m[:, chosen, None]
        return self.image[:, chosen], (self.clear[:, chosen] & ~(touch & nearer).any(2)).all(-1)


def sightings(studio: Studio, world: World, radius_m: float, postures: NDArray[np.float64], demo: bool) -> Sightings:
    """Of the world's body points, of the demonstrator or the learner. postures: (G, m) rad."""
    scene_rest = world.scene.lower
    found = []
    for theta in postures:
        both = (theta, scene_rest) if demo else (scene_rest, theta)
        points = world.points_world(theta, world.T_world_demo if demo else world.T_world_own)
        cameras = world.demo_cameras if demo else world.own_cameras
        found.append([_sight(studio.depth_m(camera, *both), camera, points, radius_m) for camera in cameras])
    image, depth, radius, clear = (np.array([[side[k] for side in pair] for pair in found]) for k in range(4))
    image = np.moveaxis(image, 1, -2).reshape(len(postures), -1, 4)
    return Sightings(image, *(np.moveaxis(each, 1, -1) for each in (depth, radius, clear)))


def _sight(
    surface_m: NDArray, camera: Camera, points: NDArray, radius_m: float
) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Of balls at (K, 3) m: image (K, 2), depth (K,), radius (K,) px, clear (K,)."""
    image, inside = camera.project(points.T)
    depth = (points - camera.T_world_camera[:3, 3]) @ camera.T_world_camera[:3, 2]
    radius = camera.lens.focal[0] * radius_m / depth
    clear = inside.copy()
    for share, angle in product((0.0, 0.5, 0.9), np.arange(0, 2 * np.pi, np.pi / 4)):
        x, y = image + share * radius * np.array([[np.cos(angle)], [np.sin(angle)]])
        column = np.clip((SAMPLES * x).astype(int), 0, surface_m.shape[1] - 1)
        row = np.clip((SAMPLES * y).astype(int), 0, surface_m.shape[0] - 1)
        front = depth - radius_m * np.sqrt(1 - share**2)
        clear &= surface_m[row, column] > front - BEHIND_M
    return image.T, depth, radius, clear
