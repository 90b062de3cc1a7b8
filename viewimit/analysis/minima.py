"""Local minima of E between the grid's points: a grid's own artefacts run on downhill when they are let go."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .landscape import Landscape

FINEST = np.radians(1e-4)  # of the descent's steps
SAME = np.radians(0.1)  # descents that end nearer than that have found one minimum
LONG = 1_000  # steps at most
DIRECTIONS = 8
TURN = np.pi * (3 - np.sqrt(5))  # the golden angle: compasses turned by it again and again come to point everywhere

Conflict = Callable[[Sequence[NDArray] | NDArray], NDArray]


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


def descend(E_at: Conflict, theta: NDArray, bounds: NDArray, longest: float) -> tuple[NDArray, NDArray]:
    """Downhill from each posture: to the lowest of eight neighbours and Newton's point, half as far if none is lower.

    Newton's point leads along narrow valleys, whose floor no compass hits; the compass leads where E has a crease.
    theta: (k, 2) rad; bounds: (2, 2) rad, low and high a joint; longest: rad, a step, so that no basin of the grid's
    size is jumped over → ends (k, 2), E (k,).
    """
    theta, step = theta.copy(), np.full(len(theta), longest)
    E = E_at(theta.T) if len(theta) else np.empty(0)
    for turn in range(LONG):
        going = np.flatnonzero(step > FINEST)
        if len(going) == 0:
            break
        angle = turn * TURN + np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
        compass = np.stack([np.cos(angle), np.sin(angle)], -1)
        ways = np.concatenate([np.tile(compass, (len(going), 1, 1)), _newton(E_at, theta[going], step[going])], 1)
        asked = np.clip(theta[going, None] + step[going, None, None] * ways, *bounds.T)
        E_there = np.nan_to_num(E_at(np.moveaxis(asked, -1, 0)), nan=np.inf)
        best = E_there.argmin(1)
        lowest = E_there[np.arange(len(going)), best]
        lower = lowest < E[going]
        theta[going[lower]] = asked[lower, best[lower]]
        E[going[lower]] = lowest[lower]
        step[going] = np.where(lower, np.minimum(2 * step[going], longest), step[going] / 2)
    return theta, E


def _newton(E_at: Conflict, theta: NDArray, step: NDArray) -> NDArray:
    """Newton's step from differences over a quarter of a step, no longer than one: (k, 1, 2) in steps."""
    h = 0.25
    places = theta[:, None, None] + h * step[:, None, None, None] * np.stack(
        np.meshgrid(*2 * [[-1, 0, 1]], indexing="ij"), -1
    )
    E = E_at(np.moveaxis(places, -1, 0))
    gradient = np.stack([E[:, 2, 1] - E[:, 0, 1], E[:, 1, 2] - E[:, 1, 0]], -1) / (2 * h)
    straight = E[:, 2, 1] + E[:, 0, 1], E[:, 1, 2] + E[:, 1, 0]
    across = (E[:, 2, 2] - E[:, 2, 0] - E[:, 0, 2] + E[:, 0, 0]) / (4 * h * h)
    H = np.empty((len(theta), 2, 2))
    H[:, 0, 0], H[:, 1, 1] = ((both - 2 * E[:, 1, 1]) / (h * h) for both in straight)
    H[:, 0, 1] = H[:, 1, 0] = across
    known = np.asarray(np.isfinite(H).all((1, 2)) & np.isfinite(gradient).all(1))
    values, vectors = np.linalg.eigh(np.where(known[:, None, None], H, np.eye(2)))
    bent = np.maximum(np.abs(values), 1e-12 * np.abs(values).max(1, keepdims=True) + 1e-300)
    way = -np.einsum(
        "kij,kj->ki", vectors, np.einsum("kji,kj->ki", vectors, np.where(known[:, None], gradient, 0.0)) / bent
    )
    return (way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1.0))[:, None]
