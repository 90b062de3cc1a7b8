"""Where an arm's hand is, how the joints move it, and a posture that brings it somewhere.

For people who pose the demonstrator, and for the truth about a learner: it needs the arm's model, which no servo has.
"""

import numpy as np
from numpy.typing import NDArray

from .world import World

ROUNDS, DIFFERENCE, DAMPING = 12, 1e-4, 1e-4


def hand_position(world: World, theta: NDArray, T_world_base: NDArray) -> NDArray:
    """(3,) m: the origin of the last link. theta: (m,) rad."""
    return world.link_frames(theta, T_world_base)[-1][:3, 3]


def hand_jacobian(world: World, theta: NDArray, T_world_base: NDArray) -> NDArray:
    """(3, m) m/rad, by difference quotients."""
    here = hand_position(world, theta, T_world_base)
    turned = [hand_position(world, theta + DIFFERENCE * unit, T_world_base) for unit in np.eye(len(theta))]
    return (np.stack(turned, -1) - here[:, None]) / DIFFERENCE


def pose_for_hand(world: World, target: NDArray, theta: NDArray) -> NDArray:
    """The posture whose hand is nearest. target: (3,) m in the world; theta: (m,) rad, where to begin → (m,) rad.

    Damped least squares within the limits.
    """
    for _ in range(ROUNDS):
        J = hand_jacobian(world, theta, world.T_world_demo)
        away = target - hand_position(world, theta, world.T_world_demo)
        step = np.linalg.solve(J.T @ J + DAMPING * np.eye(len(theta)), J.T @ away)
        moved = np.clip(theta + np.clip(step, -0.5, 0.5), world.scene.lower, world.scene.upper)
        if np.max(np.abs(moved - theta)) < 1e-4:
            break
        theta = moved
    return theta
