"""Image-based visual servoing to a goal that is shown: the own images in the demonstrator's posture.

It begins with the Jacobian as it is at the start, and then keeps it or updates it by Broyden's rule. A camera that is
turned about its axis turns the images, not what the learner knows.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from viewimit.simulation.world import World

Array = NDArray[np.float64]
FD_STEP_RAD = 1e-5
ARRIVED_PX = 2.0  # root mean square distance of the points from the goal
MAX_STEPS, MAX_PLAYED = 60, 60
MAX_STEP_RAD = np.radians(40.0)  # of a joint
GAINS = (0.1, 1.0, 2.2)
TURN_GAIN, TURN_POINT = 0.3, 9  # with one point, by index, in L alone
STARTS, START_SEED, START_GOAL = 16, 5, 3.0  # compared servos; E, px²


@dataclass(frozen=True, eq=False)
class Servoing:
    """K steps towards the goal."""

    postures: Array  # (K + 1, 2) rad
    images: Array  # (K + 1, n, 2) px in the camera as it is
    goal: Array  # (n, 2) px
    on_limit: bool  # whether the last posture is at a joint limit

    @property
    def off_px(self) -> Array:
        """(K + 1,) root mean square distance of the points from the goal."""
        return np.sqrt(((self.images - self.goal) ** 2).sum(-1).mean(-1))

    @property
    def steps(self) -> float:
        """Steps after which all points were within ARRIVED_PX for the first time; NaN if they never were."""
        within = np.flatnonzero(self.off_px < ARRIVED_PX)
        return float(within[0]) if len(within) else np.nan


def servo_to_goal(
    world: World,
    theta: Array,
    theta_goal: Array,
    gain: float,
    *,
    point: int | None = None,
    turned_deg: float = 0.0,
    update: bool = True,
    max_steps: int = MAX_STEPS,
) -> Servoing:
    """Servo image points to a goal, with a Jacobian that was right at the start, before the camera turned.

    Parameters
    ----------
    world : World
    theta, theta_goal : (m,) arrays
        The learner's start, and the posture in which the goal's images were taken [rad].
    gain : float
        Times the least-squares step.
    point : int, optional
        Index of the only point, in [L] alone. By default all points in both own images.
    turned_deg : float
        By how much the camera was turned about its axis since the Jacobian was learned.
    update : bool
        Whether Broyden's rule updates the Jacobian after each step.
    max_steps : int
    """
    camera = world.own_cameras[0]
    centre = np.array(camera.lens.centre)
    angle = np.radians(turned_deg)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])

    def see(posture: Array) -> Array:
        own, _ = world.own_images(posture)
        points = own[:, :2] if point is None else own[[point], :2]
        return points

    def turned(points: Array) -> Array:
        return centre + (points - centre) @ turn.T

    steps = FD_STEP_RAD * np.eye(len(theta))
    J = np.stack([(see(theta + step) - see(theta - step)).ravel() / (2 * FD_STEP_RAD) for step in steps], -1)
    goal, postures, images = turned(see(theta_goal)), [theta], [turned(see(theta))]
    low, high = world.scene.lower, world.scene.upper
    for _ in range(max_steps):
        error = (goal - images[-1]).ravel()
        wanted = gain * np.linalg.lstsq(J, error, rcond=None)[0]
        there = np.clip(postures[-1] + wanted, low, high)
        moved = there - postures[-1]
        seen = turned(see(there))
        if update and moved @ moved > 0:
            innovation = (seen - images[-1]).ravel() - J @ moved
            J = J + np.outer(innovation, moved) / (moved @ moved)
        postures.append(there)
        images.append(seen)
    last = postures[-1]
    on_limit = bool(((last - low < FD_STEP_RAD) | (high - last < FD_STEP_RAD)).any())
    return Servoing(np.array(postures), np.array(images), goal, on_limit)
