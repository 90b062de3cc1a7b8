"""The arrows at the demonstrator's hand, by which it is dragged."""

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, ImageHandle, SceneNodeHandle

from viewimit.drawing.theme import rgb
from viewimit.simulation.robot import BodyPoints
from viewimit.simulation.world import World, hand_position

from ..model.queue import CommandQueue
from .arms import ALWAYS_SEEN, link_name
from .nodes import Nodes, add_text

NODE = "/demonstrator_hand"
SIZE = 0.22  # m, of its arrows
ABOVE, LINE = np.array([0, 0, SIZE + 0.07]), 0.07  # m from the hand to its name; the height of a line


class HandGizmo:
    """The demonstrator's hand follows while it is dragged. drops: how often it was released, after which it is to be
    shown where the hand could come to."""

    def __init__(self, client: ClientHandle, queue: CommandQueue):
        self.drops, self._size = 0, 1.0
        self._client, self._dragging, self._let_go = client, False, False
        self._hand: tuple[World, NDArray, NDArray] | None = None  # where, in which posture, and so at which place
        self._name: ImageHandle | None = None  # before the first world
        self._visible: bool | None = None  # None: as it was made
        self._gizmo = client.scene.add_transform_controls(
            NODE, scale=SIZE, disable_rotations=True, disable_sliders=True, opacity=0.7
        )

        @self._gizmo.on_update
        async def _(event) -> None:
            self._dragging = event.phase != "end"
            queue.call("pose_hand", event.target.position)
            if not self._dragging:
                self.drops, self._let_go = self.drops + 1, True

    def furnish(self, nodes: Nodes, dark: bool, size: float) -> None:
        """Give it its name, in the colours of a scheme, in a scene of that size."""
        nothing, self._size = np.zeros(3), size
        if self._gizmo.scale != SIZE * size:
            self._gizmo.scale = SIZE * size
        self._name = nodes.keep(
            add_text(self._client.scene, f"{NODE}_name", "hand", "demonstrator", dark, nothing, LINE * size)
        )
        self._hand = self._visible = None

    def show(self, visible: bool, world: World, theta_demo: NDArray) -> None:
        """At the hand in this posture, unless the visitor holds it somewhere else."""
        assert self._name is not None
        if visible != self._visible:
            self._visible = self._gizmo.visible = self._name.visible = visible
        if self._hand is None or self._hand[0] is not world or not np.array_equal(self._hand[1], theta_demo):
            self._hand, self._let_go = (world, theta_demo, hand_position(world, theta_demo, world.T_world_demo)), True
            self._name.position = self._hand[2] + self._size * ABOVE
        if self._let_go and not self._dragging:
            self._gizmo.position, self._let_go = self._hand[2], False


# Which point a click in the 3-D scene means.

REACH = 0.02  # of the canvas's height that a click may be off: a fingertip, 12 px of 600


def picked(
    points: NDArray, radius: NDArray, origin: NDArray, direction: NDArray, fov: float, surface: float = np.inf
) -> int | None:
    """Index of the one of (k, 3) points that a click at this ray means, None if all are too far from it.

    radius: (k,) m, as they are drawn; origin (3,) m, direction (3,): the ray; fov: rad, of the canvas's height;
    surface: m from the origin, where the ray ends: drawings behind that are hidden.
    Of points that are drawn under the click it is the one nearest to the eye, else the one nearest to the click.
    """
    away = points - origin
    depth = away @ (direction / np.linalg.norm(direction))
    offset = np.sqrt(np.maximum((away**2).sum(-1) - depth**2, 0))
    height = 2 * np.tan(fov / 2) * np.maximum(depth, 1e-6)  # m of the canvas at that depth
    off = np.where((depth > 0) & (depth - radius <= surface), np.maximum(offset - radius, 0) / height, np.inf)
    nearest = int(np.lexsort((depth, off))[0])
    return nearest if off[nearest] <= REACH else None


# The body point that is proposed, hollow, on both arms.

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
