"""Radial distortion of a lens by OpenCV's model: what is at the distance r from the centre, in focal lengths, is seen
at r (1 + k1 r² + k2 r⁴)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

ROUNDS = 80  # at most: of Newton's iteration, or halvings where it would leave the bracket
MOST = 10.0  # of k1 and of k2: calibrated lenses have a few at most, and more moves what is 45° aside tenfold
ROUNDING = 4 * np.finfo(float).eps


@dataclass(frozen=True)
class Radial:
    """k1, k2: 0 without distortion. Raises ValueError for what no lens has."""

    k1: float = 0.0
    k2: float = 0.0

    def __post_init__(self) -> None:
        if not (abs(self.k1) <= MOST and abs(self.k2) <= MOST):  # NaN fails too
            raise ValueError(
                f"a distortion of k1 {self.k1:g}, k2 {self.k2:g} is none of a lens: both are within ±{MOST:g}, "
                "in focal lengths, not in pixels"
            )

    @property
    def bends(self) -> bool:
        return self.k1 != 0 or self.k2 != 0

    @cached_property
    def reach(self) -> float:
        """r up to which the seen distance grows with r, inf without an end: from there on images would fold back."""
        if not self.bends:
            return np.inf
        squared = np.roots([5 * self.k2, 3 * self.k1, 1])  # zeros of the growth, in r²
        ends = squared[np.isreal(squared) & (squared.real > 0)].real
        return float(np.sqrt(ends.min())) if len(ends) else np.inf

    @property
    def rim(self) -> float:
        """The seen distance at `reach`."""
        return self.reach * float(self.stretch(np.array(self.reach**2))) if np.isfinite(self.reach) else np.inf

    def stretch(self, squared: NDArray) -> NDArray:
        """1 + k1 r² + k2 r⁴ of r²; beyond `reach` as there, so that what is farther out is seen farther out."""
        squared = np.minimum(squared, self.reach**2)
        return 1 + squared * (self.k1 + self.k2 * squared)

    @cached_property
    def _least(self) -> float:
        """The smallest stretch: at the centre, at `reach`, or between them where it is least."""
        between = -self.k1 / (2 * self.k2) if self.k1 < 0 < self.k2 else 0.0  # r²
        outmost = self.reach**2 if np.isfinite(self.reach) else 0.0
        return float(self.stretch(np.array([0.0, between, outmost])).min())

    def undone(self, squared: NDArray) -> NDArray:
        """1 / stretch of what is seen at the squared distance given."""
        seen = np.sqrt(squared)
        low, high = np.zeros_like(seen), seen / self._least
        r = np.clip(seen, low, high)
        for _ in range(ROUNDS):
            stretch, inside = self.stretch(r * r), r * r
            over = r * stretch - seen
            if (np.abs(over) <= ROUNDING * seen).all():
                break
            low, high = np.where(over < 0, r, low), np.where(over > 0, r, high)
            growth = np.where(r < self.reach, 1 + inside * (3 * self.k1 + 5 * self.k2 * inside), stretch)
            with np.errstate(divide="ignore", invalid="ignore"):
                step = r - over / growth
            r = np.where((low <= step) & (step <= high), step, (low + high) / 2)
        return 1 / self.stretch(r * r)
