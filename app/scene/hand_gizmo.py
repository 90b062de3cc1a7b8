"""The arrows at the demonstrator's hand, by which it is dragged."""

import numpy as np
from numpy.typing import NDArray
from viser import ClientHandle

from viewimit.simulation.kinematics import hand_position
from viewimit.simulation.world import World

from ..control.commands.session import PoseHand
from ..control.queue import CommandQueue


class HandGizmo:
    """The demonstrator's hand follows while it is dragged. drops: how often it was let go, after which it is to be
    shown where the hand could come to."""

    def __init__(self, client: ClientHandle, queue: CommandQueue):
        self.drops = 0
        self._dragging = False
        self._shown: tuple[World, NDArray] | None = None  # where, and the posture at whose hand it is
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

    def show(self, visible: bool, world: World, theta_demo: NDArray) -> None:
        """At the hand in this posture, unless the visitor holds it somewhere else."""
        self._gizmo.visible = visible
        if not self._dragging and not self._is_at(world, theta_demo):
            self._gizmo.position = hand_position(world, theta_demo, world.T_world_demo)
            self._shown = world, theta_demo

    def _is_at(self, world: World, theta_demo: NDArray) -> bool:
        return self._shown is not None and self._shown[0] is world and np.array_equal(self._shown[1], theta_demo)
