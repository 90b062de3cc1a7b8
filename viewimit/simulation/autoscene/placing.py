"""Choose postures and ranges of an arm, and place two arms and a head so that all four images show them.

The head, its gazes and the bases stand as in the shipped Panda's scene, scaled to the arm.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from ...geometry.arrays import Floats
from ...geometry.rigid import rigid_transform, rotation_about_axis
from ..camera import Camera, Cameras, Lens, StereoHead
from ..robot import Robot
from ..urdf.tree import REST_MARGIN
from .surface import Surface

IMAGE, FOCAL, CENTRE = (640, 240), 256.0, (320.0, 120.0)  # px
# Distances in units of the size: gaze points ahead of the head and to its sides, head above them, baseline
AHEAD, SIDEWAYS, ABOVE, BASELINE = 1.0, 0.69, 0.685, 0.6
MIN_GAZE_HEIGHT = 0.8  # of the size, above the floor
BORDER_PX = 8.0
CELL = 0.04  # of the size: nearer surfaces collide
MAX_GROWTH = 1.5  # of the size, to avoid collisions
GROWTH_STEP, MAX_STEPS = 1.04, 120
MIN_DEPTH_M = 0.05
FD_STEP_RAD = 1e-4
MAX_RANGE_DEG, MIN_RANGE_DEG = 90.0, 2.0  # of a moving joint
ROUNDED_RANGE_DEG = 10.0  # wider ranges end at whole degrees


@dataclass(frozen=True)
class Placing:
    """Places of both bases and the head."""

    size: float  # unit of all distances [m]
    centre: Floats  # (3,) point in the base frame at which the head looks [m]
    lowest: float  # height of the lowest visible point in the base frame [m]
    yaw: float  # of both bases [rad]

    @property
    def floor(self) -> float:
        """Height of both bases above the floor [m]."""
        return max(-self.lowest, MIN_GAZE_HEIGHT * self.size - float(self.centre[2]), 0.0)

    def gaze(self, side: int) -> Floats:
        """Return the gaze point, (3,) m, of the demonstrator (side 1) or the learner (side -1)."""
        height = self.floor + float(self.centre[2])
        return np.array([AHEAD * self.size, side * SIDEWAYS * self.size, height])

    def base(self, side: int) -> Floats:
        """Return T_world_base, (4, 4)."""
        turn = rotation_about_axis([0, 0, 1], self.yaw)
        return rigid_transform(turn, self.gaze(side) - turn @ self.centre)

    @property
    def head(self) -> Floats:
        """(3,) position of the head [m]."""
        return np.array([0.0, 0.0, self.gaze(1)[2] + ABOVE * self.size])

    @property
    def baseline(self) -> float:
        """Distance of the cameras [m]."""
        return BASELINE * self.size

    def cameras(self, side: int) -> tuple[Camera, Camera]:
        """Return the left and the right camera while the head looks at one side."""
        lens = Lens((FOCAL, FOCAL), CENTRE)
        position = float(self.head[0]), float(self.head[1]), float(self.head[2])
        return StereoHead(position, self.baseline, *IMAGE, lens, lens).gaze(self.gaze(side))

    def robots_collide(self, body: Floats) -> bool:
        """Return whether the robots intersect, given points all over the body, (K, 3) m in the base frame."""
        offset = self.base(1)[:3, 3] - self.base(-1)[:3, 3]  # both have the same yaw
        cells = np.stack([body, body + np.linalg.inv(self.base(1)[:3, :3]) @ offset]) / (CELL * self.size)
        one, other = (np.unique(np.floor(each).astype(np.int64), axis=0) for each in cells)
        return len(np.unique(np.concatenate([one, other]), axis=0)) < len(one) + len(other)

    def sees(self, places: Floats) -> bool:
        """Return whether all four images show all places, (..., 3) m in the base frame, away from their borders."""
        for side in (1, -1):
            T = self.base(side)
            for camera in self.cameras(side):
                image, inside = camera.project(places.reshape(-1, 3).T, T)
                border = np.minimum(image, np.array([[IMAGE[0]], [IMAGE[1]]]) - image).min()
                if not inside.all() or border < BORDER_PX:
                    return False
        return True


def fit_to_view(places: Floats, lowest: float, yaw: float) -> Placing:
    """Return the smallest placing that sees all places, (..., 3) m in the base frame at any posture."""
    flat = places.reshape(-1, 3)
    centre = (flat.min(0) + flat.max(0)) / 2
    radius = max(float(np.linalg.norm(flat - centre, axis=1).max()), 1e-4)
    for size in _sizes(radius):
        found = Placing(size, centre, lowest, yaw)
        if found.sees(flat):
            break
    return found


def separate_robots(placing: Placing, body: Floats) -> Placing:
    """Return a placing of this size or larger in which the robots do not collide.

    If MAX_GROWTH does not suffice, as for a very long rail, the placing is returned unchanged. body: as for
    `Placing.robots_collide`.
    """
    for size in _sizes(placing.size):
        found = replace(placing, size=size)
        if size > MAX_GROWTH * placing.size:
            break
        if not found.robots_collide(body):
            return found
    return placing


def _sizes(radius: float) -> Iterator[float]:
    return (radius * GROWTH_STEP**k for k in range(MAX_STEPS))


def imitating_joints(robot: Robot) -> list[int]:
    """Return the numbers, from 1, of the joints that can imitate."""
    spans = np.degrees(robot.upper - robot.lower)
    return [joint for joint in robot.movable_joints if spans[joint - 1] >= MIN_RANGE_DEG]


def rest_posture(robot: Robot) -> Floats:
    """Return the posture, (n,) rad, with each joint as near to 0 as it can be well inside its limits."""
    inside = REST_MARGIN * (robot.upper - robot.lower)
    rest = np.clip(0.0, robot.lower + inside, robot.upper - inside)
    return np.array(robot.with_mimics(rest), float)


def turning_range(robot: Robot, joint: int, rest: Floats) -> tuple[float, float]:
    """Return a range of a joint, by number from 1, about its rest and inside its limits [deg]."""
    low, high = np.degrees([robot.joints[joint - 1].lower, robot.joints[joint - 1].upper])
    middle, half = np.degrees(rest[joint - 1]), min(high - low, MAX_RANGE_DEG) / 2
    middle = min(max(middle, low + half), high - half)
    low, high = max(low, middle - half), min(high, middle + half)
    unit = 1.0 if high - low > ROUNDED_RANGE_DEG else 0.01
    return float(np.ceil(low / unit - 1e-6) * unit + 0.0), float(np.floor(high / unit + 1e-6) * unit + 0.0)


def image_jacobian(robot: Robot, angles: Floats, surface: Surface, cameras: Cameras, T_world_base: Floats) -> Floats:
    """Return the derivative of the images of K places by each joint, (cameras * K * 2, n) px/rad, at (n,) rad."""

    def images(at: Floats) -> Floats:
        places, _ = surface.at(robot.link_frames(at, T_world_base))
        return cameras.images(places, MIN_DEPTH_M)[0].ravel()

    start = images(angles)
    moved = [(images(angles + FD_STEP_RAD * unit) - start) / FD_STEP_RAD for unit in np.eye(len(angles))]
    return np.stack(moved, -1)


def two_that_move_most(J: Floats, spans: Floats, among: Sequence[int]) -> tuple[tuple[int, int], float]:
    """Return the two joints whose ranges sweep the largest area of the images, and that area [px²].

    J: Jacobian of the images, (K, n) px/rad; spans: (n,) rad, widths of the ranges; among: numbers, from 1.
    """
    swept = J * spans / np.sqrt(len(J) / 2)
    gram = swept.T @ swept

    def area(pair: tuple[int, int]) -> float:
        a, b = pair[0] - 1, pair[1] - 1
        return float(np.sqrt(max(gram[a, a] * gram[b, b] - gram[a, b] ** 2, 0.0)))

    best = max(combinations(among, 2), key=area)
    return best, area(best)
