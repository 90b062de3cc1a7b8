"""Where two arms and a head stand so that all of both that matters is in all four images.

The head, its gazes and the bases are placed as in the shipped Panda's scene, in a size that fits the arm.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from ...geometry.rigid import rigid_transform, rotation_about_axis
from ..camera import Camera, Cameras, Lens, StereoHead
from ..robot import Robot
from ..urdf.tree import REST_MARGIN
from .surface import Surface

IMAGE, FOCAL, CENTRE = (640, 240), 256.0, (320.0, 120.0)  # px
AHEAD, ASIDE, ABOVE, BASELINE = 1.0, 0.69, 0.685, 0.6  # of the size: gazes from the head, the head over them, its eyes
GAZE_HEIGHT = 0.8  # of the size, at least: what an arm is watched at, over the floor
BORDER_PX = 8.0
CELL = 0.04  # of the size: what comes as near as that meets
MOST_APART = 1.5  # times, that images may become smaller for it
GROWTH, MOST_STEPS = 1.04, 120


@dataclass(frozen=True)
class Placing:
    """size: m, what all distances are in; centre: (3,) m in the base frame, what the head looks at; lowest: m in the
    base frame, of all that is drawn; yaw: rad, of both bases."""

    size: float
    centre: NDArray
    lowest: float
    yaw: float

    @property
    def floor(self) -> float:
        """The height of both bases over it, m."""
        return max(-self.lowest, GAZE_HEIGHT * self.size - float(self.centre[2]), 0.0)

    def gaze(self, side: int) -> NDArray:
        """(3,) m. side: 1 of the demonstrator, -1 of the learner."""
        height = self.floor + float(self.centre[2])
        return np.array([AHEAD * self.size, side * ASIDE * self.size, height])

    def base(self, side: int) -> NDArray:
        """T_world_base (4, 4)."""
        turn = rotation_about_axis([0, 0, 1], self.yaw)
        return rigid_transform(turn, self.gaze(side) - turn @ self.centre)

    @property
    def head(self) -> NDArray:
        """(3,) m"""
        return np.array([0.0, 0.0, self.gaze(1)[2] + ABOVE * self.size])

    @property
    def baseline(self) -> float:
        return BASELINE * self.size

    def cameras(self, side: int) -> tuple[Camera, Camera]:
        lens = Lens((FOCAL, FOCAL), CENTRE)
        position = float(self.head[0]), float(self.head[1]), float(self.head[2])
        return StereoHead(position, self.baseline, *IMAGE, lens, lens).gaze(self.gaze(side))

    def bodies_meet(self, body: NDArray) -> bool:
        """Whether both robots would stand in each other. body: (K, 3) m in the base frame, all over what is drawn."""
        across = self.base(1)[:3, 3] - self.base(-1)[:3, 3]  # they are turned alike
        cells = np.stack([body, body + np.linalg.inv(self.base(1)[:3, :3]) @ across]) / (CELL * self.size)
        one, other = (np.unique(np.floor(each).astype(np.int64), axis=0) for each in cells)
        return len(np.unique(np.concatenate([one, other]), axis=0)) < len(one) + len(other)

    def sees(self, places: NDArray) -> bool:
        """Whether all (..., 3) m in the base frame are in all four images, away from their borders."""
        for side in (1, -1):
            T = self.base(side)
            for camera in self.cameras(side):
                image, inside = camera.project(places.reshape(-1, 3).T, T)
                room = np.minimum(image, np.array([[IMAGE[0]], [IMAGE[1]]]) - image).min()
                if not inside.all() or room < BORDER_PX:
                    return False
        return True


def fit_to_view(places: NDArray, lowest: float, yaw: float) -> Placing:
    """The nearest at which all places are seen. places: (..., 3) m in the base frame, wherever they come."""
    flat = places.reshape(-1, 3)
    centre = (flat.min(0) + flat.max(0)) / 2
    radius = max(float(np.linalg.norm(flat - centre, axis=1).max()), 1e-4)
    for size in _sizes(radius):
        found = Placing(size, centre, lowest, yaw)
        if found.sees(flat):
            break
    return found


def separate_robots(placing: Placing, body: NDArray) -> Placing:
    """As large as that or larger, up to MOST_APART, so that the robots do not stand in each other; as it is where they
    would all the same, as on a rail that is longer than any room. body: as of `bodies_meet`."""
    for size in _sizes(placing.size):
        found = replace(placing, size=size)
        if size > MOST_APART * placing.size:
            break
        if not found.bodies_meet(body):
            return found
    return placing


def _sizes(radius: float) -> Iterator[float]:
    return (radius * GROWTH**k for k in range(MOST_STEPS))


# A posture within an arm's limits, how far its joints are to turn, and the two that move the image most.

WIDEST_DEG = 90.0
LEAST_DEG = 2.0  # that a joint must turn to be one that moves
ROUND_DEG = 10.0  # ranges wider than that end at whole degrees


def movable(robot: Robot) -> list[int]:
    """Numbers, from 1, of the joints that can imitate."""
    spans = np.degrees(robot.upper - robot.lower)
    return [joint for joint in robot.movable_joints if spans[joint - 1] >= LEAST_DEG]


def resting(robot: Robot) -> NDArray:
    """(n,) rad: each joint as near to 0 as it can be and well within its limits."""
    inside = REST_MARGIN * (robot.upper - robot.lower)
    rest = np.clip(0.0, robot.lower + inside, robot.upper - inside)
    return np.array(robot.with_mimics(rest), float)


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
