"""A posture within an arm's limits, how far its joints are to turn, and the two that move the image most."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ..camera import Cameras
from ..robot import Robot
from ..urdf.tree import MARGIN
from .surface import Surface

WIDEST_DEG = 90.0
LEAST_DEG = 2.0  # that a joint must turn to be one that moves
ROUND_DEG = 10.0  # ranges wider than that end at whole degrees


def movable(robot: Robot) -> list[int]:
    """Numbers, from 1, of the joints that can imitate."""
    spans = np.degrees(robot.upper - robot.lower)
    return [joint for joint in robot.free if spans[joint - 1] >= LEAST_DEG]


def resting(robot: Robot) -> NDArray:
    """(n,) rad: each joint as near to 0 as it can be and well within its limits."""
    inside = MARGIN * (robot.upper - robot.lower)
    rest = np.clip(0.0, robot.lower + inside, robot.upper - inside)
    return np.array(robot.coupled(rest), float)


def turning_range(robot: Robot, joint: int, rest: NDArray) -> tuple[float, float]:
    """Degrees, of a joint by number: at most WIDEST_DEG, about its rest, within its limits."""
    low, high = np.degrees([robot.joints[joint - 1].lower, robot.joints[joint - 1].upper])
    middle, half = np.degrees(rest[joint - 1]), min(high - low, WIDEST_DEG) / 2
    middle = min(max(middle, low + half), high - half)
    low, high = max(low, middle - half), min(high, middle + half)
    unit = 1.0 if high - low > ROUND_DEG else 0.01
    return float(np.ceil(low / unit - 1e-6) * unit + 0.0), float(np.floor(high / unit + 1e-6) * unit + 0.0)


def image_jacobian(robot: Robot, angles: NDArray, surface: Surface, cameras: Cameras, T_world_base: NDArray) -> NDArray:
    """px/rad of the places' images by each joint, (cameras x K x 2, n). angles: (n,) rad."""
    step = 1e-4

    def images(at: NDArray) -> NDArray:
        places, _ = surface.at(robot.link_frames(at, T_world_base))
        return cameras.images(places, 0.05)[0].ravel()

    here = images(angles)
    return np.stack([(images(angles + step * unit) - here) / step for unit in np.eye(len(angles))], -1)


def two_that_move_most(J: NDArray, spans: NDArray, among: Sequence[int]) -> tuple[tuple[int, int], float]:
    """Numbers of two joints, and px²: how large an area of images they sweep, both in their ranges. J: (images, n)
    px/rad; spans: (n,) rad."""
    swept = J * spans / np.sqrt(len(J) / 2)
    gram = swept.T @ swept

    def area(pair: tuple[int, int]) -> float:
        a, b = pair[0] - 1, pair[1] - 1
        return float(np.sqrt(max(gram[a, a] * gram[b, b] - gram[a, b] ** 2, 0.0)))

    best = max(combinations(among, 2), key=area)
    return best, area(best)
