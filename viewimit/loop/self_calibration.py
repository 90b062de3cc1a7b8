"""Self-calibration: the images of its own body that a learner records once, before it imitates, and their file.

Postures are given by the distance of each joint from its lower limit. So they do not depend on the posture in which an
imitation begins.
"""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import Floats
from ..sensing.files import read_npz
from ..servo.observation import Visit

N_CANDIDATES, N_ITERATIONS = 4000, 30  # of Lloyd's algorithm
STRETCH = 1.15  # of its postures about the middle of the range, because images are least known at the edges
SINGLE_TURN_RAD = np.radians(20.0)  # of each joint by itself
MIN_POSTURES = 3
DEFAULT_POSTURES = 12  # enough to imitate two joints in two motions


@dataclass(frozen=True)
class Body:
    """The body that a calibration describes, and how it is seen."""

    robot: str  # name or path
    joints: tuple[int, ...]  # numbers of the moving joints, from 1
    span_deg: tuple[float, ...]  # range of each of these joints
    points: int  # as in `Settings`
    sensor: str  # as in `Settings`
    undistort: tuple[float, float]  # as in `Settings`
    layout: str = ""  # digest of points that were placed by hand; "" for a layout of the scene

    def require(self, other: "Body") -> None:
        """Raise ValueError for another body; the message says what differs."""
        for field in fields(self):
            here, there = getattr(self, field.name), getattr(other, field.name)
            if here != there:
                raise ValueError(f"it was rehearsed with {field.name} {there}, here it is {here}: rehearse again")


@dataclass(frozen=True)
class SelfCalibration:
    """Images of the own body at several postures."""

    body: Body
    scene: str  # where it was recorded, for people
    noise_px: float  # standard deviation of an image coordinate at that time
    visits: tuple[Visit, ...] = ()  # displacements are (m,) rad from the lower limits of the joints

    def __len__(self) -> int:
        return len(self.visits)

    def seen_from(self, lower: Floats) -> tuple[Visit, ...]:
        """The visits as seen from a start whose lower limits are at the displacement `lower`, (m,) rad."""
        return tuple(replace(visit, displacement=visit.displacement + lower) for visit in self.visits)

    def save(self, path: Path) -> None:
        """Write as .npz: displacement_deg (K, m), own_px (K, N, 4), NaN where invisible, seen (K, N, 2), and the body.

        Raises OSError.
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
        """Read a file. Raises OSError, or ValueError that names the file and the fault."""
        try:
            return _from_table(read_npz(path))
        except KeyError as error:
            raise ValueError(f"{path}: no calibration, {error} is missing; `viewimit rehearse` makes one") from None
        except (ValueError, TypeError) as error:
            raise ValueError(f"{path}: no calibration: {error}; `viewimit rehearse` makes one") from None


def _from_table(table: dict[str, NDArray[Any]]) -> SelfCalibration:
    """Raise KeyError for a missing array, ValueError for impossible shapes and numbers."""
    displacement, own, seen = np.radians(table["displacement_deg"]), table["own_px"], table["seen"]
    body = Body(
        robot=str(table["robot"]),
        joints=_numbers(table["joints"], int),
        span_deg=_numbers(table["span_deg"], float),
        points=int(table["points"]),
        sensor=str(table["sensor"]),
        undistort=_numbers(table["undistort"], float),
        layout=str(table["layout"]) if "layout" in table else "",
    )
    noise_px, (K, m) = float(table["noise_px"]), (len(displacement), len(body.joints))
    N = own.shape[1] if own.ndim == 3 else 0
    shapes = {"displacement_deg": (displacement, (K, m)), "own_px": (own, (K, N, 4)), "seen": (seen, (K, N, 2))}
    for name, (values, expected) in shapes.items():
        if values.shape != expected:
            raise ValueError(f"{name} has shape {values.shape}, not {expected}")
    if K < MIN_POSTURES or N == 0 or seen.dtype != bool or own.dtype != float:
        raise ValueError(f"needs {MIN_POSTURES} postures or more with points in px, and which of them were seen")
    if not (np.isfinite(displacement).all() and np.isfinite(own[np.repeat(seen, 2, -1)]).all() and noise_px >= 0):
        raise ValueError("a number in it is not finite")
    visits = tuple(Visit.of(*visit) for visit in zip(displacement, own, seen))
    return SelfCalibration(body, str(table["scene"]), noise_px, visits)


def _numbers(values: NDArray[Any], kind: type) -> tuple[Any, ...]:
    return tuple(kind(value) for value in values.tolist())


def calibration_postures(low: Floats, high: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Choose postures for a calibration: spread over the range, and some that turn one joint at a time.

    Two images between which one joint turned show which points it moves. low, high: (m,) rad, range of each joint. With
    few postures, none turns a single joint. Returns (count, m) rad. Raises ValueError for fewer than MIN_POSTURES.
    """
    joints = len(low)
    if count < MIN_POSTURES + joints:
        return spread_postures(low, high, count, rng)
    first, *others = spread_postures(low, high, count - joints, rng)
    direction = np.where(first < (low + high) / 2, 1.0, -1.0)  # where the limits leave more room
    turns = np.minimum(SINGLE_TURN_RAD, (high - low) / 2)
    return np.vstack([first, first + np.cumsum(np.diag(direction * turns), axis=0), *others])


def spread_postures(low: Floats, high: Floats, count: int, rng: np.random.Generator) -> Floats:
    """Postures that fill the range [low, high], (m,) rad each, evenly (Lloyd 1982): (count, m) rad.

    They are ordered so that each is near the one before. Raises ValueError for fewer than MIN_POSTURES.
    """
    if count < MIN_POSTURES:
        raise ValueError(f"needs {MIN_POSTURES} postures or more, got {count}")
    drawn = rng.uniform(size=(max(N_CANDIDATES, 10 * count), len(low)))
    centres = drawn[:count].copy()
    for _ in range(N_ITERATIONS):
        nearest = (np.square(drawn).sum(1)[:, None] - 2 * drawn @ centres.T + np.square(centres).sum(1)).argmin(1)
        for k in range(count):
            if (nearest == k).any():
                centres[k] = drawn[nearest == k].mean(0)
    spread = low + (high - low) * np.clip(0.5 + STRETCH * (centres - 0.5), 0, 1)
    return spread[_short_way(spread)]


def _short_way(postures: Floats) -> list[int]:
    """An order that goes from each posture to the nearest remaining one."""
    way, left = [0], set(range(1, len(postures)))
    while left:
        here = postures[way[-1]]
        way.append(min(left, key=lambda k: float(np.abs(postures[k] - here).max())))
        left.remove(way[-1])
    return way
