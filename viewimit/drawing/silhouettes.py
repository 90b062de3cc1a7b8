"""Silhouettes of an arm in two images: the hull of each link, from the vertices that are extreme in some direction.

A hull's support function is the largest projection onto a direction. Few directions, and the vertex
that is extreme in each, give a polygon inside the hull that lacks at most 2 px at its corners.
"""

import numpy as np
from numpy.typing import NDArray

from ..simulation.camera import Cameras
from ..simulation.world import World

DIRECTIONS = 12  # corners of a polygon at most
NEAR = 0.05  # m, to which what is nearer to a camera is set back
KEPT = 48  # directions in 3-D in which a link's vertices are kept


class Silhouettes:
    """Polygons and skeletons of arms. meshes: by link (0 = base), vertices (V, 3) m in the link's frame.

    Without meshes, as of a robot from a user's own URDF, there are skeletons only.
    """

    def __init__(self, meshes: dict[int, NDArray], world: World):
        self.world = world
        self._links = np.array(sorted(meshes), int)
        chosen = [_extreme_vertices(np.asarray(meshes[link], float)) for link in self._links]
        most = max(map(len, chosen), default=1)
        # short lists are filled up with their first vertex, which changes no hull
        filled = [np.concatenate([v, np.repeat(v[:1], most - len(v), axis=0)]) for v in chosen]
        self._vertices = np.array(filled).reshape(len(chosen), most, 3)
        self._shape = 2, len(chosen), most, 2
        self._pair, self._link = np.ogrid[:2, : len(chosen), :1][:2]
        self.memory: dict = {}  # what was drawn last of each arm, kept by those who draw

    def seen(self, T_world_links: NDArray, cameras: Cameras) -> tuple[NDArray, NDArray]:
        """By a stereo pair: closed polygons of the links, (2, links, DIRECTIONS, 2) px, whose corners may repeat, and
        the origins of all links, (2, n + 1, 2) px."""
        T = T_world_links[self._links]
        vertices = self._vertices @ np.swapaxes(T[:, :3, :3], 1, 2) + T[:, None, :3, 3]
        images, _ = cameras.images(np.concatenate([vertices.reshape(-1, 3), T_world_links[:, :3, 3]]), NEAR)
        corners = images[:, : -len(T_world_links)].reshape(self._shape)
        largest = (corners @ _COMPASS.T).argmax(2)  # (2, links, DIRECTIONS)
        return corners[self._pair, self._link, largest], images[:, -len(T_world_links) :]


def _extreme_vertices(vertices: NDArray) -> NDArray:
    """Those that reach farthest in some of KEPT directions spread over the sphere (Fibonacci's spiral)."""
    i = np.arange(KEPT) + 0.5
    z, turn = 1 - 2 * i / KEPT, np.pi * (1 + 5**0.5) * i
    level = np.sqrt(1 - z * z)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), z])
    return vertices[np.unique((vertices @ directions).argmax(0))]


_ANGLES = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
_COMPASS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)
