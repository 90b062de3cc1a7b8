"""A body image: what a learner saw of its own body, once, with nobody to imitate; and the file that keeps it.

Postures are told by how far each joint is from its lower limit, which the learner knows of itself, so that they mean
the same whatever posture an imitation begins in.
"""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..sensing.files import read_npz
from ..sensing.renamed import CALIBRATION, SETTING_VALUES, current_keys
from ..servo.observation import Visit

CANDIDATES, ROUNDS = 4000, 30  # of the search for postures apart
STRETCH = 1.15  # of these about the middle: the images of a range are least known at its edges
MIN_POSTURES = 3
TURN = np.radians(20.0)  # of each joint by itself


@dataclass(frozen=True)
class Body:
    """Which body, by what cameras: robot, by name or path; joints: numbers from 1 of those that move, span_deg: how far
    each can turn; points, sensor and undistort as in `Settings`; layout: which points, "" for one of the scene's."""

    robot: str
    joints: tuple[int, ...]
    span_deg: tuple[float, ...]
    points: int
    sensor: str
    undistort: tuple[float, float]
    layout: str = ""

    def require(self, other: "Body") -> None:
        """Raises ValueError for another body, with what differs."""
        for field in fields(self):
            here, there = getattr(self, field.name), getattr(other, field.name)
            if here != there:
                raise ValueError(f"it was rehearsed with {field.name} {there}, here it is {here}: rehearse again")


@dataclass(frozen=True)
class SelfCalibration:
    """visits: displacements are (m,) rad from the lower limits of all joints; noise_px: of an image coordinate then,
    standard deviation; scene: where that was, for people."""

    body: Body
    scene: str
    noise_px: float
    visits: tuple[Visit, ...] = ()

    def __len__(self) -> int:
        return len(self.visits)

    def with_visit(self, visit: Visit) -> "SelfCalibration":
        return replace(self, visits=(*self.visits, visit))

    def seen_from(self, lower: NDArray) -> tuple[Visit, ...]:
        """The visits by their displacement from a posture of which the lower limits are `lower`, (m,) rad, away."""
        return tuple(replace(visit, displacement=visit.displacement + lower) for visit in self.visits)

    def save(self, path: Path) -> None:
        """As .npz: displacement_deg (K, m), own (K, N, 4) px, NaN where not seen, seen (K, N, 2), and what body it is.

        Raises OSError if that cannot be.
        """
        table: dict[str, Any] = {
            "displacement_deg": np.degrees([visit.displacement for visit in self.visits]),
            "own_px": np.array([visit.own for visit in self.visits]),
            "seen": np.array([visit.seen for visit in self.visits]),
            "scene": self.scene,
            "noise_px": self.noise_px,
            **{field.name: getattr(self.body, field.name) for field in fields(self.body)},
        }
        with path.open("wb") as file:  # numpy would add an extension
            np.savez(file, **table)

    @classmethod
    def load(cls, path: Path) -> "SelfCalibration":
        """Raises OSError, or ValueError that names the file and what is wrong with it."""
        try:
            return _from_table(current_keys(read_npz(path), CALIBRATION))
        except KeyError as error:
            raise ValueError(f"{path}: no body image, {error} is missing; `viewimit rehearse` makes one") from None
        except (ValueError, TypeError) as error:
            raise ValueError(f"{path}: no body image: {error}; `viewimit rehearse` makes one") from None


def _from_table(table: dict[str, NDArray]) -> SelfCalibration:
    """Raises KeyError for what is missing, ValueError for shapes and numbers that cannot be."""
    displacement, own, seen = np.radians(table["displacement_deg"]), table["own_px"], table["seen"]
    body = Body(
        robot=str(table["robot"]),
        joints=_numbers(table["joints"], int),
        span_deg=_numbers(table["span_deg"], float),
        points=int(table["points"]),
        sensor=SETTING_VALUES["sensor"].get(str(table["sensor"]), str(table["sensor"])),
        undistort=_numbers(table["undistort"], float),
        layout=str(table["layout"]) if "layout" in table else "",
    )
    noise_px, (K, m) = float(table["noise_px"]), (len(displacement), len(body.joints))
    N = own.shape[1] if own.ndim == 3 else 0
    shapes = {"displacement_deg": (displacement, (K, m)), "own_px": (own, (K, N, 4)), "seen": (seen, (K, N, 2))}
    for name, (values, wanted) in shapes.items():
        if values.shape != wanted:
            raise ValueError(f"{name} has shape {values.shape}, not {wanted}")
    if K < MIN_POSTURES or N == 0 or seen.dtype != bool or own.dtype != float:
        raise ValueError(f"needs {MIN_POSTURES} postures or more with points in px, and which of them were seen")
    if not (np.isfinite(displacement).all() and np.isfinite(own[np.repeat(seen, 2, -1)]).all() and noise_px >= 0):
        raise ValueError("a number in it is not finite")
    visits = tuple(Visit.of(*visit) for visit in zip(displacement, own, seen))
    return SelfCalibration(body, str(table["scene"]), noise_px, visits)


def _numbers(values: NDArray, kind: type) -> tuple[Any, ...]:
    return tuple(kind(value) for value in values.tolist())


def calibration_postures(low: NDArray, high: NDArray, count: int, rng: np.random.Generator) -> NDArray:
    """(count, m) rad: `spread_postures`, and on from the first of them by each joint in turn, as far as they are enough
    for both: images between which one joint was turned tell which points it moves. Raises ValueError for fewer than
    MIN_POSTURES."""
    joints = len(low)
    if count < MIN_POSTURES + joints:
        return spread_postures(low, high, count, rng)
    first, *others = spread_postures(low, high, count - joints, rng)
    way = np.where(first < (low + high) / 2, 1.0, -1.0)  # where the limits leave more room
    turns = np.minimum(TURN, (high - low) / 2)
    return np.vstack([first, first + np.cumsum(np.diag(way * turns), axis=0), *others])


def spread_postures(low: NDArray, high: NDArray, count: int, rng: np.random.Generator) -> NDArray:
    """(count, m) rad: each joint within [low, high], (m,) rad, all as far from each other as may be (Lloyd 1982), in an
    order in which the way from one to the next is short. Raises ValueError for fewer than MIN_POSTURES."""
    if count < MIN_POSTURES:
        raise ValueError(f"needs {MIN_POSTURES} postures or more, got {count}")
    drawn = rng.uniform(size=(max(CANDIDATES, 10 * count), len(low)))
    centres = drawn[:count].copy()
    for _ in range(ROUNDS):
        nearest = (np.square(drawn).sum(1)[:, None] - 2 * drawn @ centres.T + np.square(centres).sum(1)).argmin(1)
        for k in range(count):
            if (nearest == k).any():
                centres[k] = drawn[nearest == k].mean(0)
    apart = low + (high - low) * np.clip(0.5 + STRETCH * (centres - 0.5), 0, 1)
    return apart[_short_way(apart)]


def _short_way(postures: NDArray) -> list[int]:
    """An order: from each to the nearest that is left."""
    way, left = [0], set(range(1, len(postures)))
    while left:
        here = postures[way[-1]]
        way.append(min(left, key=lambda k: float(np.abs(postures[k] - here).max())))
        left.remove(way[-1])
    return way


DEFAULT_POSTURES = 12  # with which two joints are imitated in two motions
