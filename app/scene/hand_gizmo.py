"""The arrows at the demonstrator's hand, by which it is dragged."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle

from ..control.commands.session import PoseHand
from ..control.queue import CommandQueue


class HandGizmo:
    """The demonstrator's hand follows while it is dragged. drops: how often it was let go, after which it is to be
    shown where the hand could come to."""

    def __init__(self, client: ClientHandle, queue: CommandQueue):
        self.drops = 0
        self._dragging = False
        self._shown: NDArray | None = None  # posture at whose hand it is
        self._gizmo = client.scene.add_transform_controls(
            "/demonstrator_hand", scale=0.22, disable_rotations=True, disable_sliders=True, opacity=0.7
        )

        @self._gizmo.on_update
        async def _(event) -> None:
            self._dragging = event.phase != "end"
            queue.put_value(PoseHand.parse, event.target.position)
            if not self._dragging:
                self._shown = None
                self.drops += 1

    def show(self, visible: bool, theta_demo: NDArray, hand_position: Callable[[NDArray], NDArray]) -> None:
        """At the hand in this posture, hand_position(theta_demo), unless the visitor holds it somewhere else."""
        self._gizmo.visible = visible
        if not self._dragging and (self._shown is None or not np.array_equal(self._shown, theta_demo)):
            self._gizmo.position, self._shown = hand_position(theta_demo), theta_demo
