"""The smallest E of images that a model predicts: Levenberg-Marquardt in a box, from several starts at once."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..evaluation import conflict as evaluate

ROUNDS, DIFFERENCE, SHORT = 8, 1e-5, np.radians(0.01)  # rad
WORTHWHILE = 1e-4  # share of E below which a round has gained nothing
DAMPINGS = np.array([0.0, 1.0])

ResidualAt = Callable[[NDArray], NDArray]


@dataclass(frozen=True)
class Minimum:
    """theta: (m,) rad; E there and at the first start, px²; hessian: (m, m) px²/rad², Gauss and Newton's; points: N."""

    theta: NDArray
    E: float
    E_first: float
    hessian: NDArray
    points: int


def minimise(residual_at: ResidualAt, starts: NDArray, low: NDArray, high: NDArray, rounds: int = ROUNDS) -> Minimum:
    """Over the box [low, high], of E of residual_at(θ): (..., m) rad → (..., N, C) px. starts: (s, m) rad.

    Each round asks for the damped candidates of all starts and their difference quotients in one batch.
    """
    s, m = starts.shape
    joints, each = np.arange(m), np.arange(s)
    candidates = starts[:, None]
    best, best_E, hessians, E_first = starts, np.full(s, np.inf), np.zeros((s, m, m)), np.nan
    count = 0  # points
    for _ in range(rounds):
        inward = np.where(candidates + DIFFERENCE > high, -DIFFERENCE, DIFFERENCE)
        asked = np.repeat(candidates[:, :, None], m + 1, axis=2)
        asked[:, :, joints + 1, joints] += inward
        e = residual_at(asked)
        count = e.shape[-2]
        E = evaluate(e[:, :, 0])
        E_first = E[0, 0] if E_first is np.nan else E_first
        k = E.argmin(1)
        better = E[each, k] < best_E * (1 - WORTHWHILE)
        if not better.any():
            break
        best = np.where(better[:, None], candidates[each, k], best)
        best_E = np.where(better, E[each, k], best_E)
        flat = e[each, k].reshape(s, m + 1, -1)
        J = (flat[:, 1:] - flat[:, :1]) / inward[each, k][:, :, None]
        gradient, normal = (J @ flat[:, 0, :, None])[..., 0], J @ J.swapaxes(1, 2)
        hessians = np.where(better[:, None, None], normal / e.shape[-2], hessians)
        free = ~(((best <= low) & (gradient > 0)) | ((best >= high) & (gradient < 0)))
        steps = _damped_steps(np.where(free, gradient, 0.0), normal, free)
        gained = np.einsum("si,si->s", np.where(free, gradient, 0.0), steps[:, 0])
        squared = np.einsum("sk,sk->s", flat[:, 0], flat[:, 0])
        on = better & (gained >= WORTHWHILE * squared) & (np.abs(steps).max((1, 2)) >= SHORT)
        if not on.any():
            break  # by its own linear model nothing is left to gain
        candidates = np.clip(best[:, None] - steps, low, high)
    least = int(np.argmin(best_E))
    return Minimum(best[least], float(best_E[least]), float(E_first), hessians[least], count)


def _damped_steps(gradient: NDArray, normal: NDArray, free: NDArray) -> NDArray:
    """(H + λ diag H)⁻¹ g over the free joints, for every damping λ → (s, len(DAMPINGS), m)."""
    own = np.diagonal(normal, axis1=1, axis2=2)
    own = own + 1e-12 * np.maximum(own.sum(1, keepdims=True), 1e-300)
    damped = normal[:, None] + (DAMPINGS[:, None, None] + 1e-9) * (own[:, None, :, None] * np.eye(own.shape[1]))
    both = free[:, None, :, None] & free[:, None, None, :]
    damped = np.where(both, damped, np.eye(own.shape[1]))
    return np.linalg.solve(damped, np.broadcast_to(gradient[:, None, :, None], damped.shape[:3] + (1,)))[..., 0]
