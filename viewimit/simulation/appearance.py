"""What both arms look like in the four views, and the learner in the demonstrator's posture: silhouettes, skeletons.

This is ground truth, for viewers only. A silhouette is the convex hull of each link's image. The vertices that are
extreme in a few directions make a polygon inside the hull, at most 2 px smaller at its corners.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..estimation.transfers import FittedTransfer
from ..geometry.arrays import Floats
from .camera import Cameras
from .world import World

DIRECTIONS = 12  # corners of a polygon at most
MIN_DEPTH_M = 0.05  # nearer vertices are moved back to it
HULL_DIRECTIONS = 48  # directions in 3-D in which a link's extreme vertices are kept


@dataclass(frozen=True, eq=False)
class ArmImages:
    """An arm in the two images of a stereo pair."""

    hulls: Floats  # (2, links, DIRECTIONS, 2) px, closed polygons whose corners may repeat
    origins: Floats  # (2, n + 1, 2) px, of all links
    points: Floats  # (2, N, 2) px, without noise
    memory: dict[Any, Any] = field(default_factory=dict)  # cache of the drawing code


@dataclass(frozen=True)
class Bodies:
    """Both arms in all four images."""

    demo: ArmImages  # in l, r
    own: ArmImages  # in L, R
    recovered: Floats | None  # (2, n + 1, 2) px in L, R: the demonstrator's links by the transfer, None without one
    frame: tuple[int, int]  # width and height of the images [px]
    goal: ArmImages  # in L, R: the learner as it would look in the demonstrator's posture


class Silhouettes:
    """Projects the polygons and skeletons of both arms.

    meshes: vertices by link (0 = base), (V, 3) m in the link's frame. Without meshes there are skeletons only.
    """

    def __init__(self, meshes: Mapping[int, Floats], world: World):
        self._world = world
        self._links = np.array(sorted(meshes), int)
        chosen = {link: extreme_vertices(np.asarray(meshes[link], float)) for link in self._links.tolist()}
        most = max(map(len, chosen.values()), default=1)
        # homogeneous origin and vertices of every link, (n + 1, 1 + most, 4); short lists repeat their first vertex
        self._vertices = np.zeros((len(world.robot.joints) + 1, 1 + most, 4))
        self._vertices[..., 3] = 1.0
        for link, vertices in chosen.items():
            self._vertices[link, 1:, :3] = vertices[0]
            self._vertices[link, 1 : 1 + len(vertices), :3] = vertices
        self._pair, self._link = np.ogrid[:2, : len(chosen), :1][:2]
        self._latest: dict[str, tuple[bytes, ArmImages]] = {}  # by arm: the demonstrator mostly stands still

    def bodies(self, theta_demo: Floats, theta: Floats, transfer: FittedTransfer | None) -> Bodies:
        """Return both arms at postures, (m,) rad. The images of an arm that has not moved are the same object.

        transfer: that of these postures, None if there are too few points to fit one.
        """
        world = self._world
        demo = self._arm("demonstrator", theta_demo, world.T_world_demo, world.demo_pair)
        own = self._arm("learner", theta, world.T_world_own, world.own_pair)
        goal = self._arm("goal", theta_demo, world.T_world_own, world.own_pair)
        found = None
        if transfer is not None:
            recovered = transfer.recover(demo.origins[0], demo.origins[1])
            found = np.stack([recovered[:, :2], recovered[:, 2:]])
        return Bodies(demo, own, found, world.scene.head.image, goal)

    def _arm(self, arm: str, theta: Floats, T_world_base: Floats, cameras: Cameras) -> ArmImages:
        key, latest = theta.tobytes(), self._latest.get(arm)
        if latest is None or latest[0] != key:
            hulls, origins = self.seen(self._world.link_frames(theta, T_world_base), cameras)
            images = self._world.demo_images if arm == "demonstrator" else self._world.own_images
            points = images(theta)[0].reshape(-1, 2, 2).swapaxes(0, 1)
            latest = self._latest[arm] = key, ArmImages(hulls, origins, points)
        return latest[1]

    def seen(self, T_world_links: Floats, cameras: Cameras) -> tuple[Floats, Floats]:
        """Return polygons (2, links, DIRECTIONS, 2) px and the links' origins (2, n + 1, 2) px in a stereo pair."""
        images = cameras.images_on(T_world_links, self._vertices, MIN_DEPTH_M)
        corners = images[:, self._links, 1:]
        largest = (corners @ _COMPASS.T).argmax(2)  # (2, links, DIRECTIONS)
        return corners[self._pair, self._link, largest], images[:, :, 0]


def extreme_vertices(vertices: Floats) -> Floats:
    """Return the vertices that are farthest in some direction of a Fibonacci spiral on the sphere: (V, 3) -> (K, 3)."""
    i = np.arange(HULL_DIRECTIONS) + 0.5
    z, turn = 1 - 2 * i / HULL_DIRECTIONS, np.pi * (1 + 5**0.5) * i
    level = np.sqrt(1 - z * z)
    directions = np.stack([level * np.cos(turn), level * np.sin(turn), z])
    return vertices[np.unique((vertices @ directions).argmax(0))]


_ANGLES = 2 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
_COMPASS = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], -1)


def points_in_images(bodies: Bodies) -> dict[str, Floats]:
    """Return what is drawn of both arms and of the goal, (k, 2) px by view, moved to the frame's edge if outside."""
    shown = {}
    for views, arms in (("lr", (bodies.demo,)), ("LR", (bodies.own, bodies.goal))):
        for k, view in enumerate(views):
            parts = [part for arm in arms for part in (arm.hulls[k].reshape(-1, 2), arm.origins[k], arm.points[k])]
            shown[view] = np.clip(np.concatenate(parts), 0, bodies.frame)
    return shown
