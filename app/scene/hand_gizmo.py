"""The arrows at the demonstrator's hand, by which it is dragged."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle

from ..control.inbox import Inbox


class HandGizmo:
    """Puts "hand", (3,) m, into the inbox while it is dragged, and "hand dropped" afterwards."""

    def __init__(self, client: ClientHandle, inbox: Inbox):
        self._dragging = False
        self._shown: NDArray | None = None  # posture at whose hand it is
        self._gizmo = client.scene.add_transform_controls(
            "/demonstrator_hand", scale=0.22, disable_rotations=True, disable_sliders=True, opacity=0.7
        )

        @self._gizmo.on_update
        async def _(event) -> None:
            self._dragging = event.phase != "end"
            inbox.put("hand", np.array(event.target.position, float))
            if not self._dragging:
                self._shown = None
                inbox.put("hand dropped", True)

    def show(self, visible: bool, theta_demo: NDArray, hand_position: Callable[[NDArray], NDArray]) -> None:
        """At the hand in this posture, hand_position(theta_demo), unless the visitor holds it somewhere else."""
        self._gizmo.visible = visible
        if not self._dragging and not np.array_equal(self._shown, theta_demo):
            self._gizmo.position, self._shown = hand_position(theta_demo), theta_demo
