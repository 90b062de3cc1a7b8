"""Minimise E of predicted images: Levenberg-Marquardt in a box, from several starts at once.

References
----------
Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, section 10.3.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ..estimation.transfers.transfer import conflict

Array = NDArray[np.float64]
MAX_ITERATIONS = 8
FD_STEP = 1e-5  # rad, of finite differences
MIN_STEP = np.radians(0.01)  # rad: shorter steps are not made
CLUSTER_TOL = np.radians(1.0)  # rad: starts that head for places nearer than this come to one minimum
FTOL = 1e-4  # share of E, below which an iteration has gained nothing
DAMPINGS = np.array([0.0, 1.0])
_RAISED = (DAMPINGS + 1e-9)[:, None]  # keeps the normal equations regular
MAX_STEP = np.pi  # rad: longer steps are along directions that E does not depend on
LEAST_CURVATURE = 1e-100  # px²/rad²: keeps squares of its inverse finite
ROUNDING = 1e-12  # of the largest curvature: smaller ones may be rounding errors


@dataclass(frozen=True)
class Minimum:
    """Result of `minimise`."""

    theta: Array  # (m,) rad
    E: float  # px², there
    E_first: float  # px², at the first start
    hessian: Array  # (m, m) px²/rad², Gauss-Newton
    points: int  # N, that E was evaluated with


def minimise(residual_at: Callable[[Array], Array], starts: Array, low: Array, high: Array) -> Minimum:
    """Minimise E over the box [low, high].

    Parameters
    ----------
    residual_at : callable
        Residuals at postures, (..., m) rad → (..., N, C) px.
    starts : (s, m) array
        Postures to start from [rad].
    low, high : (m,) arrays
        Bounds [rad].

    Returns
    -------
    Minimum
        The best of all starts.

    Notes
    -----
    Each iteration evaluates the damped steps of all starts that still gain, and their finite differences, in one batch.
    A start is given up if it heads for where another start has a smaller E.
    """
    s, m = starts.shape
    best, best_E, hessians = starts.copy(), np.full(s, np.inf), np.zeros((s, m, m))
    heading = starts.copy()  # where each start goes next, undamped
    live, candidates = np.arange(s), starts[:, None]
    E_first, count = np.nan, 0  # count: points
    for _ in range(MAX_ITERATIONS):
        inward = np.where(candidates > high - FD_STEP, -FD_STEP, FD_STEP)
        e = residual_at(candidates[:, :, None] + inward[:, :, None] * fd_steps(m))
        count = e.shape[-2]
        E = conflict(e[:, :, 0])
        E_first = E[0, 0] if E_first is np.nan else E_first
        (better,) = (E.min(1) < best_E[live] * (1 - FTOL)).nonzero()
        if not len(better):
            break
        at, live = (better, E.argmin(1)[better]), live[better]
        theta, least_E = candidates[at], E[at]
        best[live], best_E[live] = theta, least_E
        normal, steps, gains = _linear(e[at], least_E, inward[at], theta, low, high)
        hessians[live] = normal / count
        candidates = np.minimum(np.maximum(theta[:, None] - steps, low), high)
        heading[live] = candidates[:, 0]
        on = gains & _distinct(heading, best_E)[live]
        if not on.any():
            break  # by its own linear model nothing more is gained
        live, candidates = live[on], candidates[on]
    least = int(best_E.argmin())
    return Minimum(best[least], float(best_E[least]), float(E_first), hessians[least], count)


def _distinct(heading: Array, E: Array) -> Array:
    """Return which starts, (s,), head elsewhere than the start with the smallest E, or are that one."""
    least = E.argmin()
    distinct = np.abs(heading - heading[least]).max(1) > CLUSTER_TOL
    distinct[least] = True
    return distinct


def _linear(e: Array, E: Array, inward: Array, theta: Array, low: Array, high: Array) -> tuple[Array, Array, Array]:
    """Linearise the residuals at postures, theta: (l, m) rad.

    e: (l, 1 + m, N, C) px, there and at finite differences, inward: (l, m) rad; E: (l,) px², there. Returns JᵀJ,
    (l, m, m), Levenberg-Marquardt steps to subtract for each damping, (l, len(DAMPINGS), m) rad, and whether the
    undamped step gives a significant decrease, (l,).
    """
    squared = 2 * e.shape[2] * E
    e = e.reshape(*e.shape[:2], -1)
    J = (e[:, 1:] - e[:, :1]) / inward[:, :, None]
    gradient, normal = (J @ e[:, 0, :, None])[..., 0], J @ J.swapaxes(1, 2)
    barred = ((theta <= low) & (gradient > 0)) | ((theta >= high) & (gradient < 0))
    gradient[barred] = 0.0
    steps = _damped_steps(gradient, normal, barred)
    longest = np.abs(steps).reshape(len(steps), -1).max(1)
    if longest.max() > MAX_STEP:
        long = longest > MAX_STEP
        steps[long] = _damped_steps(gradient[long], _stiffened(normal[long]), barred[long])
        longest = np.abs(steps).reshape(len(steps), -1).max(1)
    gained = np.einsum("li,li->l", gradient, steps[:, 0])
    return normal, steps, (gained >= FTOL * squared) & (longest >= MIN_STEP)


def _stiffened(normal: Array) -> Array:
    """Replace curvatures that may be rounding errors by the largest one: else rounding would choose the step."""
    curvatures, directions = np.linalg.eigh(normal)
    largest = curvatures[:, -1:]
    curvatures = np.where(curvatures > ROUNDING * largest, curvatures, largest)
    return (directions * curvatures[:, None]) @ directions.swapaxes(1, 2)


def _damped_steps(gradient: Array, normal: Array, barred: NDArray[np.bool_]) -> Array:
    """Return (H + λ diag H)⁻¹ g over the joints that are not at a limit, for every damping λ: (l, len(DAMPINGS), m)."""
    unit = _unit(normal.shape[1])
    own = np.einsum("lii->li", normal)
    own = own + 1e-12 * np.maximum(own.sum(1), 1e-300)[:, None]
    damped = normal[:, None] + (_RAISED * own[:, None])[..., None] * unit
    if barred.any():
        damped = np.where(barred[:, None, :, None] | barred[:, None, None, :], unit, damped)
    return np.linalg.solve(damped, gradient[:, None, :, None])[..., 0]


@cache
def fd_steps(joints: int) -> Array:
    """Return no step, and a unit step of each joint: (1 + m, m)."""
    return np.eye(1 + joints, joints, -1)


@cache
def _unit(joints: int) -> Array:
    return np.eye(joints)


def standard_deviations(hessian: Array, points: int) -> Array:
    """Return the standard deviation of each joint by image noise of 1 px, √diag((JᵀJ)⁻¹): (m,) rad/px."""
    curvatures, directions = np.linalg.eigh(hessian)
    curvatures = np.maximum(curvatures, max(1e-12 * curvatures[-1], LEAST_CURVATURE))
    return np.sqrt(((directions**2) / curvatures).sum(1) / points)


def posture_grid(lower: Array, upper: Array, count: int, seed: int = 0) -> Array:
    """Return `count` postures per joint, (n, m) rad; for three joints or more as many random ones as for two."""
    if len(lower) > 2:
        return np.random.default_rng([seed, count]).uniform(lower, upper, (count**2, len(lower)))
    return np.stack(np.meshgrid(*np.linspace(lower, upper, count).T, indexing="ij"), -1).reshape(-1, len(lower))
