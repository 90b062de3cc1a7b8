"""Local minima of E over the postures, their bias, and how far the paper's Eq. (11) holds around them.

Eq. (11) claims E = δθᵀ Q δθ with Q positive definite. Here δθ is measured from the minimum and E from its smallest
value, because an affine camera leaves both a little off the demonstrator's.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.arrays import Floats
from ..loop.snapshot import Snapshot
from ..simulation.world import World
from .landscape import Landscape, conflict_at, grid_axes, landscape_over, seen_from

MIN_STEP_RAD = np.radians(1e-4)  # the descent ends with smaller steps
SAME_MINIMUM_RAD = np.radians(0.1)  # descents that end nearer to each other have found one minimum
MAX_STEPS = 1_000
COMPASS_DIRECTIONS = 8
GOLDEN_ANGLE = np.pi * (3 - np.sqrt(5))  # turns the compass before each step, so that it points everywhere in time

FD_STEP_DEG = 0.5  # of the second differences: far above rounding, far below where E bends
RADII_DEG = np.array([1.0, 2, 3, 5, 7.5, 10, 15, 20, 25, 30, 40, 50, 60])
CIRCLE_DIRECTIONS = 72
MAX_RELATIVE_ERROR = 0.25  # of the quadratic model where it is said to hold

Conflict = Callable[[Sequence[Floats] | Floats], Floats]


@dataclass(frozen=True)
class Minima:
    """Local minima, the lowest first."""

    theta: Floats  # (k, 2) rad
    E: Floats  # (k,) px²
    on_limit: NDArray[np.bool_]  # (k,): whether it lies at the edge of a joint's range

    def __len__(self) -> int:
        return len(self.E)


@dataclass(frozen=True)
class TransferStudy:
    """E of one transfer over the postures."""

    transfer: str
    landscape: Landscape
    minima: Minima  # between the grid's points
    basin: float  # share of the postures from which descent ends at the lowest minimum
    bias_deg: Floats  # (2,) from the demonstrator's posture to the lowest minimum, NaN without one


def study_transfer(world: World, snapshot: Snapshot, transfer: str) -> TransferStudy:
    """Find the minima of E and their bias, around the demonstrator as the learner has seen it; takes about 0.1 s.

    Raises ValueError unless two joints move.
    """
    seen = seen_from(world, snapshot, transfer)
    found = landscape_over(*seen, grid_axes(world))
    minima = local_minima(found, lambda theta: conflict_at(*seen, theta)[0])
    bias = np.degrees(minima.theta[0] - snapshot.theta_demo) if len(minima) else np.full(2, np.nan)
    return TransferStudy(transfer, found, minima, found.basin_fraction(), bias)


def local_minima(found: Landscape, E_at: Conflict) -> Minima:
    """Descend from the grid's local minima: those that are artefacts of the grid run on downhill. found: E on a grid of
    two joints; E_at: E in px² at postures off the grid, given as m arrays of rad that are broadcast against each other.
    Returns at most as many as the grid shows."""
    bounds = np.array([[axis.min(), axis.max()] for axis in found.axes])
    spacing = max(np.diff(axis).max() for axis in found.axes)
    ends, E = descend(E_at, found.local_minima(), bounds, spacing)
    kept: list[int] = []
    for k in np.argsort(E, kind="stable"):
        if np.isfinite(E[k]) and all(np.abs(ends[k] - ends[other]).max() > SAME_MINIMUM_RAD for other in kept):
            kept.append(k)
    ends = ends[kept]
    return Minima(ends, E[kept], (np.abs(ends[:, :, None] - bounds) < MIN_STEP_RAD).any((1, 2)))


def descend(E_at: Conflict, theta: Floats, bounds: Floats, max_step: float) -> tuple[Floats, Floats]:
    """Move downhill from each posture, by a compass search that also tries Newton's point.

    A step goes to the lowest of eight neighbours and Newton's point; it is halved if all are higher. Newton's point
    leads along narrow valleys, whose floor no compass hits; the compass leads where E has a crease.

    E_at: as for `local_minima`; theta: (k, 2) rad, starts; bounds: (2, 2) rad, lowest and highest angle of each joint;
    max_step: rad, so that no step jumps over a basin of the grid's size. Returns the ends, (k, 2) rad, and E there.
    """
    theta, step = theta.copy(), np.full(len(theta), max_step)
    E = E_at(theta.T) if len(theta) else np.empty(0)
    for turn in range(MAX_STEPS):
        going = np.flatnonzero(step > MIN_STEP_RAD)
        if len(going) == 0:
            break
        angle = turn * GOLDEN_ANGLE + np.arange(COMPASS_DIRECTIONS) * (2 * np.pi / COMPASS_DIRECTIONS)
        compass = np.stack([np.cos(angle), np.sin(angle)], -1)
        steps = np.concatenate([np.tile(compass, (len(going), 1, 1)), _newton(E_at, theta[going], step[going])], 1)
        trial = np.clip(theta[going, None] + step[going, None, None] * steps, *bounds.T)
        E_trial = np.nan_to_num(E_at(np.moveaxis(trial, -1, 0)), nan=np.inf)
        best = E_trial.argmin(1)
        lowest = E_trial[np.arange(len(going)), best]
        lower = lowest < E[going]
        theta[going[lower]] = trial[lower, best[lower]]
        E[going[lower]] = lowest[lower]
        step[going] = np.where(lower, np.minimum(2 * step[going], max_step), step[going] / 2)
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
    rotated = np.einsum("kji,kj->ki", vectors, np.where(known[:, None], gradient, 0.0)) / bent
    newton = -np.einsum("kij,kj->ki", vectors, rotated)
    return (newton / np.maximum(np.linalg.norm(newton, axis=1, keepdims=True), 1.0))[:, None]


@dataclass(frozen=True)
class Convexity:
    """How far E is from the quadratic model of Eq. (11), on circles around the minimum."""

    Q: Floats  # (2, 2) px²/degree²
    radius_deg: Floats  # (k,)
    error: Floats  # (k,) median relative difference on a circle; NaN where it is out of range all around
    worst: Floats  # (k,) largest relative difference, NaN as above
    convex_radius_deg: float  # of the largest circle up to which E's Hessian is nowhere indefinite

    @property
    def eigenvalues(self) -> Floats:
        """(2,) px²/degree², ascending."""
        return np.asarray(np.linalg.eigvalsh(self.Q), float)

    @property
    def positive_definite(self) -> bool:
        return bool(self.eigenvalues[0] > 0)

    @property
    def holds_to_deg(self) -> float:
        """Largest radius up to which no error exceeds MAX_RELATIVE_ERROR; 0 if one does on the first circle."""
        within = np.logical_and.accumulate(self.worst <= MAX_RELATIVE_ERROR)
        return float(self.radius_deg[within][-1]) if within.any() else 0.0

    def ring_deg(self) -> Floats | None:
        """Return the level curve of the model through the farthest posture up to which it holds.

        (73, 2) degrees from the minimum, a closed ellipse; None if the model holds nowhere.
        """
        values, axes = np.linalg.eigh(self.Q)
        if not values[0] > 0 or not self.holds_to_deg:
            return None
        angle = np.linspace(0, 2 * np.pi, 73)
        half_axes = self.holds_to_deg * np.sqrt(values[0] / values)
        return (half_axes * np.stack([np.cos(angle), np.sin(angle)], -1)) @ axes.T


def convexity(E_at: Conflict, minimum: Floats, bounds: Floats) -> Convexity:
    """Compare E with its quadratic model around a minimum, (2,) rad, within bounds, (2, 2) rad."""
    Q = hessian(E_at, minimum[:, None])[0] / 2
    angle = np.linspace(0, 2 * np.pi, CIRCLE_DIRECTIONS, endpoint=False)
    around = np.stack([np.cos(angle), np.sin(angle)])
    error, worst, convex = [], [], []
    E_min = E_at(minimum[:, None])[0]
    for radius in RADII_DEG:
        delta = radius * around
        theta = minimum[:, None] + np.radians(delta)
        inside = ((theta >= bounds[:, :1]) & (theta <= bounds[:, 1:])).all(0)
        parabola = np.einsum("in,ij,jn->n", delta, Q, delta)[inside]
        rise = E_at(theta[:, inside]) - E_min
        relative = np.abs(rise / parabola - 1)
        known = relative[np.isfinite(relative)]
        error.append(np.median(known) if len(known) else np.nan)
        worst.append(known.max() if len(known) else np.nan)
        curvature = np.linalg.eigvalsh(hessian(E_at, theta[:, inside]))[:, 0]
        convex.append(inside.any() and bool((curvature[np.isfinite(curvature)] >= 0).all()))
    reached = RADII_DEG[np.logical_and.accumulate(convex)]
    return Convexity(Q, RADII_DEG, np.array(error), np.array(worst), float(reached[-1]) if len(reached) else 0.0)


def hessian(E_at: Conflict, theta: Floats) -> Floats:
    """Return second differences of E at postures (2, n) rad: (n, 2, 2) px²/degree²."""
    h = np.radians(FD_STEP_DEG)
    grid = np.array([-h, 0, h])
    E = E_at((theta[0, :, None, None] + grid[:, None], theta[1, :, None, None] + grid))
    across = (E[:, 2, 2] - E[:, 2, 0] - E[:, 0, 2] + E[:, 0, 0]) / 4
    first = E[:, 2, 1] - 2 * E[:, 1, 1] + E[:, 0, 1]
    second = E[:, 1, 2] - 2 * E[:, 1, 1] + E[:, 1, 0]
    return np.stack([np.stack([first, across], -1), np.stack([across, second], -1)], -2) / FD_STEP_DEG**2
