"""The smallest E of images that a model predicts: Levenberg-Marquardt in a box, from several starts at once."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import conflict

ROUNDS, DIFFERENCE, SHORT = 8, 1e-5, np.radians(0.01)  # rad
SAME = np.radians(1.0)  # starts that head for places nearer than this come to one minimum
WORTHWHILE = 1e-4  # share of E below which a round has gained nothing
DAMPINGS = np.array([0.0, 1.0])
RAISED = (DAMPINGS + 1e-9)[:, None]  # keeps the normal equations regular
WILD = np.pi  # rad: longer steps than that are along what nothing tells
ROUNDING = 1e-12  # of the largest curvature, below which one may be a rounding error

ResidualAt = Callable[[NDArray], NDArray]


@dataclass(frozen=True)
class Minimum:
    """theta: (m,) rad; E there and at the first start, px²; hessian: (m, m) px²/rad², Gauss and Newton's; points: N;
    left: (m,) rad, from there to where the linear model has the least E, if that is too near to be worth a round."""

    theta: NDArray
    E: float
    E_first: float
    hessian: NDArray
    points: int
    left: NDArray


def minimise(residual_at: ResidualAt, starts: NDArray, low: NDArray, high: NDArray) -> Minimum:
    """Over the box [low, high], of E of residual_at(θ): (..., m) rad → (..., N, C) px. starts: (s, m) rad.

    Each round asks for the damped candidates of all starts that still gain and their difference quotients in one batch.
    A start that heads for where another has come to with a smaller E is given up.
    """
    s, m = starts.shape
    best, best_E, hessians = starts.copy(), np.full(s, np.inf), np.zeros((s, m, m))
    heading = starts.copy()  # where each start goes next, undamped
    live, candidates = np.arange(s), starts[:, None]
    E_first, count = np.nan, 0  # count: points
    for _ in range(ROUNDS):
        inward = np.where(candidates > high - DIFFERENCE, -DIFFERENCE, DIFFERENCE)
        e = residual_at(candidates[:, :, None] + inward[:, :, None] * aside(m))
        count = e.shape[-2]
        E = conflict(e[:, :, 0])
        E_first = E[0, 0] if E_first is np.nan else E_first
        (better,) = (E.min(1) < best_E[live] * (1 - WORTHWHILE)).nonzero()
        if not len(better):
            break
        at, live = (better, E.argmin(1)[better]), live[better]
        theta, least_E = candidates[at], E[at]
        best[live], best_E[live] = theta, least_E
        normal, steps, gains = _linear(e[at], least_E, inward[at], theta, low, high)
        hessians[live] = normal / count
        candidates = np.minimum(np.maximum(theta[:, None] - steps, low), high)
        heading[live] = candidates[:, 0]
        on = gains & _apart(heading, best_E)[live]
        if not on.any():
            break  # by its own linear model nothing is left to gain
        live, candidates = live[on], candidates[on]
    least = int(best_E.argmin())
    left = heading[least] - best[least]
    left = left if np.abs(left).max() < SHORT else np.zeros(m)
    return Minimum(best[least], float(best_E[least]), float(E_first), hessians[least], count, left)


def _apart(heading: NDArray, E: NDArray) -> NDArray:
    """(s,) bool: which starts head elsewhere than that with the least E, and this one. heading: (s, m) rad."""
    least = E.argmin()
    apart = np.abs(heading - heading[least]).max(1) > SAME
    apart[least] = True
    return apart


def _linear(
    e: NDArray, E: NDArray, inward: NDArray, theta: NDArray, low: NDArray, high: NDArray
) -> tuple[NDArray, NDArray, NDArray]:
    """By the linear model at theta (l, m): its normal equations (l, m, m), damped steps (l, len(DAMPINGS), m) rad to
    take off theta, and whether the first of them gains anything, (l,) bool. e: (l, 1 + m, N, C) px, there and a little
    on by each joint, inward: (l, m) rad; E: (l,) px², there."""
    squared = 2 * e.shape[2] * E
    e = e.reshape(*e.shape[:2], -1)
    J = (e[:, 1:] - e[:, :1]) / inward[:, :, None]
    gradient, normal = (J @ e[:, 0, :, None])[..., 0], J @ J.swapaxes(1, 2)
    barred = ((theta <= low) & (gradient > 0)) | ((theta >= high) & (gradient < 0))
    gradient[barred] = 0.0
    steps = _damped_steps(gradient, normal, barred)
    longest = np.abs(steps).reshape(len(steps), -1).max(1)
    if longest.max() > WILD:
        wild = longest > WILD
        steps[wild] = _damped_steps(gradient[wild], _stiffened(normal[wild]), barred[wild])
        longest = np.abs(steps).reshape(len(steps), -1).max(1)
    gained = np.einsum("li,li->l", gradient, steps[:, 0])
    return normal, steps, (gained >= WORTHWHILE * squared) & (longest >= SHORT)


def _stiffened(normal: NDArray) -> NDArray:
    """(l, m, m): the same but along what nothing tells, where rounding alone would choose among all places: there as
    stiff as along what is told best."""
    curvatures, directions = np.linalg.eigh(normal)
    largest = curvatures[:, -1:]
    curvatures = np.where(curvatures > ROUNDING * largest, curvatures, largest)
    return (directions * curvatures[:, None]) @ directions.swapaxes(1, 2)


def _damped_steps(gradient: NDArray, normal: NDArray, barred: NDArray) -> NDArray:
    """(H + λ diag H)⁻¹ g over the joints that are not barred, for every damping λ → (s, len(DAMPINGS), m)."""
    unit = _unit(normal.shape[1])
    own = np.einsum("lii->li", normal)
    own = own + 1e-12 * np.maximum(own.sum(1), 1e-300)[:, None]
    damped = normal[:, None] + (RAISED * own[:, None])[..., None] * unit
    if barred.any():
        damped = np.where(barred[:, None, :, None] | barred[:, None, None, :], unit, damped)
    return np.linalg.solve(damped, gradient[:, None, :, None])[..., 0]


@cache
def aside(joints: int) -> NDArray:
    """(1 + m, m): nowhere, and on by each joint, of m."""
    return np.eye(1 + joints, joints, -1)


@cache
def _unit(joints: int) -> NDArray:
    return np.eye(joints)
