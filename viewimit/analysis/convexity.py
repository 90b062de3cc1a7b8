"""The paper's convexity claim, Eq. (11): E = δθᵀ Q δθ with Q positive definite. How far does it hold?

δθ is taken from the minimum and E from its least value: an affine camera leaves both a little off the demonstrator's.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .minima import Conflict

DIFFERENCE_DEG = 0.5  # of the second differences: far above rounding, far below where E bends
RADII_DEG = np.array([1.0, 2, 3, 5, 7.5, 10, 15, 20, 25, 30, 40, 50, 60])
DIRECTIONS = 72
GOOD = 0.25  # relative error up to which the parabola is said to hold


@dataclass(frozen=True)
class Convexity:
    """Q: (2, 2) px²/degree²; radius_deg: (k,); error: (k,) median and worst: (k,) largest relative difference
    of E to the parabola on circles of those radii; NaN where the circle leaves the joints' range all around.
    convex_radius_deg: of the largest of these circles within which E's Hessian is nowhere indefinite.
    """

    Q: NDArray
    radius_deg: NDArray
    error: NDArray
    worst: NDArray
    convex_radius_deg: float

    @property
    def eigenvalues(self) -> NDArray:
        """(2,) px²/degree², ascending"""
        return np.linalg.eigvalsh(self.Q)

    @property
    def positive_definite(self) -> bool:
        return bool(self.eigenvalues[0] > 0)

    @property
    def holds_to_deg(self) -> float:
        """Largest radius up to which the error nowhere exceeds GOOD; 0 if it does on the first circle."""
        within = np.logical_and.accumulate(self.worst <= GOOD)
        return float(self.radius_deg[within][-1]) if within.any() else 0.0

    def ring_deg(self, count: int = 73) -> NDArray | None:
        """(count, 2) degrees from the minimum, closed: where the parabola has one value, through the farthest posture
        up to which it holds; None if it holds nowhere."""
        values, axes = np.linalg.eigh(self.Q)
        if not values[0] > 0 or not self.holds_to_deg:
            return None
        angle = np.linspace(0, 2 * np.pi, count)
        reach = self.holds_to_deg * np.sqrt(values[0] / values)
        return (reach * np.stack([np.cos(angle), np.sin(angle)], -1)) @ axes.T


def convexity(E_at: Conflict, minimum: NDArray, bounds: NDArray) -> Convexity:
    """Around minimum (2,) rad. bounds: (2, 2) rad, low and high a joint: only postures within them count."""
    Q = hessian(E_at, minimum[:, None])[0] / 2
    angle = np.linspace(0, 2 * np.pi, DIRECTIONS, endpoint=False)
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
        curved = np.linalg.eigvalsh(hessian(E_at, theta[:, inside]))[:, 0]
        convex.append(inside.any() and bool((curved[np.isfinite(curved)] >= 0).all()))
    reached = RADII_DEG[np.logical_and.accumulate(convex)]
    return Convexity(Q, RADII_DEG, np.array(error), np.array(worst), float(reached[-1]) if len(reached) else 0.0)


def hessian(E_at: Conflict, theta: NDArray) -> NDArray:
    """Second differences. theta: (2, n) rad → (n, 2, 2) px²/degree²."""
    h = np.radians(DIFFERENCE_DEG)
    grid = np.array([-h, 0, h])
    E = E_at((theta[0, :, None, None] + grid[:, None], theta[1, :, None, None] + grid))
    across = (E[:, 2, 2] - E[:, 2, 0] - E[:, 0, 2] + E[:, 0, 0]) / 4
    first = E[:, 2, 1] - 2 * E[:, 1, 1] + E[:, 0, 1]
    second = E[:, 1, 2] - 2 * E[:, 1, 1] + E[:, 1, 0]
    return np.stack([np.stack([first, across], -1), np.stack([across, second], -1)], -2) / DIFFERENCE_DEG**2
