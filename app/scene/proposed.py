"""The body point that is proposed, hollow, on both arms."""

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, SceneNodeHandle

from viewimit.drawing.theme import rgb
from viewimit.simulation.robot import BodyPoints
from viewimit.simulation.world import World

from .arms import ALWAYS_SEEN, link_name
from .nodes import Nodes

RADIUS, SIDES = 0.024, 24  # m, in a scene of size 1; of a circle


class ProposedPoint:
    """Of one page in one world; dark on the arms, which are pale in every scheme."""

    def __init__(self, client: ClientHandle, nodes: Nodes, world: World):
        self._client, self._keep, self._world, self._colour = client, nodes.keep, world, rgb("ink")
        self._point: BodyPoints | None = None
        self._shown: list[SceneNodeHandle] = []

    def show(self, point: BodyPoints | None) -> None:
        """A single one, or none."""
        if point is self._point:
            return
        self._point = point
        for node in self._shown:
            node.visible = False
        self._shown = [] if point is None else [self._added(arm, point) for arm in ALWAYS_SEEN]

    def _added(self, arm: str, point: BodyPoints) -> SceneNodeHandle:
        scene = self._world.scene
        return self._keep(
            self._client.scene.add_line_segments(
                f"{link_name(scene, arm, int(point.link[0]))}/proposed",
                _circles(RADIUS * scene.size),
                self._colour,
                thickness=2,
                thickness_units="screen",
                position=point.local[0],
            )
        )


def _circles(radius: float) -> NDArray:
    """(3 SIDES, 2, 3) m: three great circles of a sphere, which so is hollow."""
    angles = 2 * np.pi * np.arange(SIDES + 1) / SIDES
    circle = radius * np.stack([np.cos(angles), np.sin(angles), np.zeros(SIDES + 1)], -1)
    sides = np.stack([circle[:-1], circle[1:]], 1)
    return np.concatenate([np.roll(sides, axis, -1) for axis in range(3)]).astype(np.float32)
