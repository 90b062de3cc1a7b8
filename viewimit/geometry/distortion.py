"""Radial distortion of a lens, by OpenCV's model.

A point at the distance r from the optical axis, in focal lengths, is imaged at r (1 + k1 r² + k2 r⁴).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

MAX_ITER = 80  # Newton steps, or halvings where a step would leave the bracket
MAX_COEFFICIENT = 10.0  # of k1 and k2: calibrated lenses have a few at most; more moves a point at 45° tenfold
TOL = 4 * np.finfo(float).eps  # relative


@dataclass(frozen=True)
class RadialDistortion:
    """Radial distortion. Raises ValueError for coefficients that no lens has."""

    k1: float = 0.0
    k2: float = 0.0

    def __post_init__(self) -> None:
        if not (abs(self.k1) <= MAX_COEFFICIENT and abs(self.k2) <= MAX_COEFFICIENT):  # NaN fails too
            raise ValueError(
                f"a distortion of k1 {self.k1:g}, k2 {self.k2:g} is none of a lens: both are within "
                f"±{MAX_COEFFICIENT:g}, in focal lengths, not in pixels"
            )

    @property
    def bends(self) -> bool:
        """Whether images of straight lines are curved."""
        return self.k1 != 0 or self.k2 != 0

    @cached_property
    def max_radius(self) -> float:
        """r up to which the distorted radius increases with r; inf without a limit. Beyond it images would fold."""
        if not self.bends:
            return np.inf
        squared = np.roots([5 * self.k2, 3 * self.k1, 1])  # zeros of the derivative, in r²
        limits = squared[np.isreal(squared) & (squared.real > 0)].real
        return float(np.sqrt(limits.min())) if len(limits) else np.inf

    @property
    def max_distorted_radius(self) -> float:
        """Distorted radius of `max_radius`."""
        if not np.isfinite(self.max_radius):
            return np.inf
        return self.max_radius * float(self.factor(np.array(self.max_radius**2)))

    def factor(self, squared: NDArray[np.float64]) -> NDArray[np.float64]:
        """1 + k1 r² + k2 r⁴ of r²; constant beyond `max_radius`, so that the distorted radius still increases."""
        squared = np.minimum(squared, self.max_radius**2)
        return 1 + squared * (self.k1 + self.k2 * squared)

    @cached_property
    def _min_factor(self) -> float:
        """The smallest factor: at the centre, at `max_radius`, or at a minimum between them."""
        between = -self.k1 / (2 * self.k2) if self.k1 < 0 < self.k2 else 0.0  # r²
        outermost = self.max_radius**2 if np.isfinite(self.max_radius) else 0.0
        return float(self.factor(np.array([0.0, between, outermost])).min())

    def inverse_factor(self, squared: NDArray[np.float64]) -> NDArray[np.float64]:
        """Undistorted over distorted radius, of the squared distorted radius, by bracketed Newton steps."""
        distorted = np.sqrt(squared)
        low, high = np.zeros_like(distorted), distorted / self._min_factor
        r = np.clip(distorted, low, high)
        for _ in range(MAX_ITER):
            factor, r_squared = self.factor(r * r), r * r
            error = r * factor - distorted
            if (np.abs(error) <= TOL * distorted).all():
                break
            low, high = np.where(error < 0, r, low), np.where(error > 0, r, high)
            slope = np.where(r < self.max_radius, 1 + r_squared * (3 * self.k1 + 5 * self.k2 * r_squared), factor)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = r - error / slope
            r = np.where((low <= step) & (step <= high), step, (low + high) / 2)
        return 1 / self.factor(r * r)
