"""How well residuals tell each joint's angle: what a pixel of noise costs there.

From the curvature of E where it is least: near that posture E = |J δθ|²/2N beside what noise makes of it, so an angle
that hardly changes the residuals, or changes them as others do, may go astray by much before E tells.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS
from ..servo.trust_region.local_model import UNTOLD
from ..simulation.world import World

STEP = 1e-3  # rad, of the differences
SINGULAR = 1e-9  # of the largest singular value
WEAK = 2.0  # times what the other joints cost


def residual_jacobian(residual_at: Callable[[NDArray], NDArray], theta: ArrayLike, step: float = STEP) -> NDArray:
    """J (n, m) px/rad by central differences. residual_at: postures (K, m) rad → residuals (K, ...) px, n each."""
    theta = np.asarray(theta, float)
    aside = step * np.eye(len(theta))
    e = residual_at(np.concatenate([theta + aside, theta - aside])).reshape(2, len(theta), -1)
    return (e[0] - e[1]).T / (2 * step)


def uncertainty(J: ArrayLike) -> NDArray:
    """Standard deviation of each angle where the squares of residuals with independent noise of 1 px are least.

    J: (n, m) px/rad → √diag((JᵀJ)⁻¹), (m,) rad/px; inf where nothing but noise tells the angle.
    """
    _, s, Vt = np.linalg.svd(np.asarray(J, float), full_matrices=True)
    s = np.pad(s, (0, len(Vt) - len(s)))
    told = s > SINGULAR * s.max()
    if not told.any():
        return np.full(len(Vt), np.inf)
    spread = np.sqrt(((Vt[told] / s[told, None]) ** 2).sum(0))
    return np.where((np.abs(Vt[~told]) > np.sqrt(SINGULAR)).any(0), np.inf, spread)


def untold_joints(spread: ArrayLike) -> list[int]:
    """Indices, the worst first, of the joints that cannot be observed: they cost UNTOLD or more."""
    spread = np.asarray(spread, float)
    return [int(j) for j in np.argsort(-spread, kind="stable") if spread[j] >= UNTOLD]


def weak_joints(spread: ArrayLike) -> list[int]:
    """Indices, the weakest first, of the joints that cost more than WEAK times the median of the others."""
    spread = np.asarray(spread, float)
    others = [np.median(np.delete(spread, j)) if len(spread) > 1 else np.inf for j in range(len(spread))]
    return [int(j) for j in np.argsort(-spread, kind="stable") if spread[j] > WEAK * others[j]]


def joint_uncertainty(
    world: World, fit: Callable, demo: NDArray, demo_visible: NDArray, theta: ArrayLike
) -> NDArray | None:
    """What 1 px of noise in the own images costs at each joint, (m,) rad, with the learner at theta, (m,) rad.

    demo: (N, 4) px, demo_visible: (N, 2), the demonstrator's images as the learner has them. Only points seen at
    theta count; None if there are too few.
    """
    theta = np.asarray(theta, float)
    _, own_visible = world.own_images(theta)
    usable = own_visible.all(-1) & demo_visible.all(-1)
    if usable.sum() < MIN_POINTS:
        return None

    def residual_at(postures: NDArray) -> NDArray:
        own, _ = world.own_images(postures.T)
        views = FourViews(demo[usable], own[:, usable], np.ones(1, bool))
        return fit(views).residual(views)

    return uncertainty(residual_jacobian(residual_at, theta))
