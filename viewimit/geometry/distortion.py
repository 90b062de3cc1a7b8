"""Distortion of a lens, by OpenCV's model (Brown 1966).

A point at the distance r from the optical axis, in focal lengths, is imaged at r (1 + k1 r² + k2 r⁴ + k3 r⁶). A lens
whose elements are not aligned moves the point (x, y) also by (2 p1 xy + p2 (r² + 2x²), p1 (r² + 2y²) + 2 p2 xy).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

MAX_ITER = 80  # Newton steps, or halvings where a step would leave the bracket
MAX_COEFFICIENT = 10.0  # of k1 and k2: calibrated lenses have a few at most; more moves a point at 45° tenfold
MAX_SIXTH = 100.0  # of k3, which narrow lenses have larger
MAX_TANGENTIAL = 0.1  # of p1 and p2: calibrated lenses have a hundredth at most
TOL = 4 * np.finfo(float).eps  # relative


@dataclass(frozen=True)
class RadialDistortion:
    """Radial distortion. Raises ValueError for coefficients that no lens has."""

    k1: float = 0.0
    k2: float = 0.0
    k3: float = 0.0

    def __post_init__(self) -> None:
        if not abs(self.k3) <= MAX_SIXTH:  # NaN fails too
            raise ValueError(f"a distortion of k3 {self.k3:g} is none of a lens: it is within ±{MAX_SIXTH:g}")
        if not (abs(self.k1) <= MAX_COEFFICIENT and abs(self.k2) <= MAX_COEFFICIENT):
            raise ValueError(
                f"a distortion of k1 {self.k1:g}, k2 {self.k2:g} is none of a lens: both are within "
                f"±{MAX_COEFFICIENT:g}, in focal lengths, not in pixels"
            )

    @property
    def bends(self) -> bool:
        """Whether images of straight lines are curved."""
        return self.k1 != 0 or self.k2 != 0 or self.k3 != 0

    @cached_property
    def max_radius(self) -> float:
        """r up to which the distorted radius increases with r; inf without a limit. Beyond it images would fold."""
        if not self.bends:
            return np.inf
        squared = np.roots([7 * self.k3, 5 * self.k2, 3 * self.k1, 1])  # zeros of the derivative, in r²
        limits = squared[np.isreal(squared) & (squared.real > 0)].real
        return float(np.sqrt(limits.min())) if len(limits) else np.inf

    @property
    def max_distorted_radius(self) -> float:
        """Distorted radius of `max_radius`."""
        if not np.isfinite(self.max_radius):
            return np.inf
        return self.max_radius * float(self.factor(np.array(self.max_radius**2)))

    def factor(self, squared: NDArray[np.float64]) -> NDArray[np.float64]:
        """1 + k1 r² + k2 r⁴ + k3 r⁶ of r²; constant beyond `max_radius`, so that it still increases."""
        squared = np.minimum(squared, self.max_radius**2)
        return 1 + squared * (self.k1 + squared * (self.k2 + self.k3 * squared))

    @cached_property
    def _min_factor(self) -> float:
        """The smallest factor: at the centre, at `max_radius`, or at a minimum between them."""
        between = np.roots([3 * self.k3, 2 * self.k2, self.k1])  # r², of the derivative
        between = between[np.isreal(between) & (between.real > 0)].real
        outermost = self.max_radius**2 if np.isfinite(self.max_radius) else 0.0
        return float(self.factor(np.array([0.0, *between, outermost])).min())

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
            slope = np.where(r < self.max_radius, 1 + r_squared * self._slope(r_squared), factor)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = r - error / slope
            r = np.where((low <= step) & (step <= high), step, (low + high) / 2)
        return 1 / self.factor(r * r)

    def _slope(self, squared: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivative of the distorted radius by r, minus 1, over r²; of r²."""
        return 3 * self.k1 + squared * (5 * self.k2 + squared * 7 * self.k3)


@dataclass(frozen=True)
class LensDistortion:
    """Radial and tangential distortion, as cameras are calibrated. Raises ValueError for what no lens has."""

    radial: RadialDistortion
    p1: float = 0.0
    p2: float = 0.0

    def __post_init__(self) -> None:
        if not max(abs(self.p1), abs(self.p2)) <= MAX_TANGENTIAL:  # NaN fails too
            raise ValueError(
                f"a distortion of p1 {self.p1:g}, p2 {self.p2:g} is none of a lens: both are within "
                f"±{MAX_TANGENTIAL:g}; the order is k1,k2,p1,p2,k3"
            )

    @classmethod
    def of(cls, k1: float, k2: float, p1: float = 0.0, p2: float = 0.0, k3: float = 0.0) -> "LensDistortion":
        """Make it of the coefficients in OpenCV's order."""
        return cls(RadialDistortion(k1, k2, k3), p1, p2)

    def undistorted(self, distorted: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where a lens without distortion images points, (..., 2) focal lengths from the centre.

        NaN, where they are beyond the fold of the image.
        """
        radial = distorted
        for _ in range(MAX_ITER):
            squared = (radial * radial).sum(-1, keepdims=True)
            found = radial * self.radial.inverse_factor(squared)
            before, radial = radial, distorted - self._tangential(found)
            if not (np.abs(radial - before) > TOL * (1 + np.abs(distorted))).any():
                break
        folded = ~(np.linalg.norm(radial, axis=-1, keepdims=True) < self.radial.max_distorted_radius)
        return np.where(folded, np.nan, found)

    def _tangential(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        x, y = points[..., 0], points[..., 1]
        squared, both = x * x + y * y, 2 * x * y
        along_x = self.p1 * both + self.p2 * (squared + 2 * x * x)
        return np.stack([along_x, self.p1 * (squared + 2 * y * y) + self.p2 * both], -1)
