"""Radial distortion of a lens by OpenCV's model: what is at the distance r from the centre, in focal lengths, is seen
at r (1 + k1 r² + k2 r⁴)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

ROUNDS = 20  # of Newton's iteration, which doubles its digits at each
LEAST_GROWTH = 0.05  # of the seen distance with r, that a step assumes


@dataclass(frozen=True)
class Radial:
    """k1, k2: 0 without distortion."""

    k1: float = 0.0
    k2: float = 0.0

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

    def undone(self, squared: NDArray) -> NDArray:
        """1 / stretch of what is seen at the squared distance given."""
        seen = np.sqrt(squared)
        r = np.minimum(seen, self.reach)
        for _ in range(ROUNDS):
            inside = np.minimum(r * r, self.reach**2)
            growth = np.maximum(1 + inside * (3 * self.k1 + 5 * self.k2 * inside), LEAST_GROWTH)
            r = np.maximum(r - (r * self.stretch(r * r) - seen) / growth, 0)
        return 1 / self.stretch(r * r)
