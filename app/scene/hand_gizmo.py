"""The arrows at the demonstrator's hand, by which it is dragged."""

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle, ImageHandle

from viewimit.simulation.world import World, hand_position

from ..control.commands.session import PoseHand
from ..control.queue import CommandQueue
from .lettering import add_text
from .nodes import Nodes

NODE = "/demonstrator_hand"
SIZE = 0.22  # m, of its arrows
ABOVE, LINE = np.array([0, 0, SIZE + 0.07]), 0.07  # m from the hand to its name; the height of a line


class HandGizmo:
    """The demonstrator's hand follows while it is dragged. drops: how often it was let go, after which it is to be
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
            queue.put_value(PoseHand.parse, event.target.position)
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
