"""Local minima of E between the grid's points: a grid's own artefacts run on downhill when they are let go."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..landscape import Landscape

FINEST = np.radians(1e-4)  # of the descent's steps
SAME = np.radians(0.1)  # descents that end nearer than that have found one minimum
LONG = 2_000  # steps at most
DIRECTIONS = 8
TURN = np.pi * (3 - np.sqrt(5))  # the golden angle: compasses turned by it again and again come to point everywhere

Conflict = Callable[[Sequence[NDArray]], NDArray]


@dataclass(frozen=True)
class Minima:
    """theta: (k, 2) rad; E: (k,) px², lowest first; on_limit: (k,) bool, at the edge of a joint's range."""

    theta: NDArray
    E: NDArray
    on_limit: NDArray

    def __len__(self) -> int:
        return len(self.E)


def local_minima(found: Landscape, E_at: Conflict) -> Minima:
    """At most as many as the grid shows. E_at(θ) → px² at postures off the grid, m arrays of rad."""
    bounds = np.array([[axis.min(), axis.max()] for axis in found.axes])
    spacing = max(np.diff(axis).max() for axis in found.axes)
    ends, E = descend(E_at, found.local_minima(), bounds, spacing)
    kept: list[int] = []
    for k in np.argsort(E, kind="stable"):
        if np.isfinite(E[k]) and all(np.abs(ends[k] - ends[other]).max() > SAME for other in kept):
            kept.append(k)
    ends = ends[kept]
    return Minima(ends, E[kept], (np.abs(ends[:, :, None] - bounds) < FINEST).any((1, 2)))


def descend(E_at: Conflict, theta: NDArray, bounds: NDArray, first_step: float) -> tuple[NDArray, NDArray]:
    """Compass search from each posture: to the lowest of eight neighbours, or half as far if none is lower.

    The compass turns at each step, or a narrow valley between two of its directions would pass for a minimum.

    theta: (k, 2) rad; bounds: (2, 2) rad, low and high a joint; first_step: rad → ends (k, 2), E (k,).
    Steps never grow, so that a descent stays in the basin in which it began.
    """
    theta, step = theta.copy(), np.full(len(theta), first_step)
    E = E_at(theta.T) if len(theta) else np.empty(0)
    for turn in range(LONG):
        going = np.flatnonzero(step > FINEST)
        if len(going) == 0:
            break
        angle = turn * TURN + np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
        compass = np.stack([np.cos(angle), np.sin(angle)], -1)
        asked = np.clip(theta[going, None] + step[going, None, None] * compass, *bounds.T)
        E_there = np.nan_to_num(E_at(np.moveaxis(asked, -1, 0)), nan=np.inf)
        best = E_there.argmin(1)
        lowest = E_there[np.arange(len(going)), best]
        lower = lowest < E[going]
        theta[going[lower]] = asked[lower, best[lower]]
        E[going[lower]] = lowest[lower]
        step[going[~lower]] /= 2
    return theta, E
