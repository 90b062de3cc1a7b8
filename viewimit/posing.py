"""Posing the demonstrator by its hand: the posture whose hand is nearest to where the gizmo was dragged."""

import numpy as np
from numpy.typing import NDArray

from viewimit.world import World

from .arms import skeleton_frames

ROUNDS, DIFFERENCE, DAMPING = 12, 1e-4, 1e-4


def pose_for_hand(world: World, target: NDArray, theta: NDArray) -> NDArray:
    """target: (3,) m in the world; theta: (m,) rad, where to begin → (m,) rad within the limits.

    Damped least squares on the hand's position with difference quotients. This poses the demonstrator, a
    puppet of the page; no servo may use it.
    """

    def hand(posture: NDArray) -> NDArray:
        return skeleton_frames(world, posture, world.T_world_demo)[-1][:3, 3]

    for _ in range(ROUNDS):
        here = hand(theta)
        J = np.stack([(hand(theta + DIFFERENCE * unit) - here) / DIFFERENCE for unit in np.eye(len(theta))], -1)
        step = np.linalg.solve(J.T @ J + DAMPING * np.eye(len(theta)), J.T @ (target - here))
        moved = np.clip(theta + np.clip(step, -0.5, 0.5), world.scene.lower, world.scene.upper)
        if np.max(np.abs(moved - theta)) < 1e-4:
            break
        theta = moved
    return theta
