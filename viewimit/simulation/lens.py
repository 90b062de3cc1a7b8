"""What a lens makes of directions: focal lengths, centre, and OpenCV's radial distortion."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

ROUNDS = 20  # of Newton's iteration, which doubles its digits at each
LEAST_GROWTH = 0.05  # of the seen distance with r, that a step assumes


@dataclass(frozen=True)
class Lens:
    """focal: (fx, fy), centre: px. distortion: (k1, k2); what an ideal lens shows at the distance r from the centre, in
    focal lengths, is seen at r (1 + k1 r² + k2 r⁴)."""

    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: tuple[float, float] = (0.0, 0.0)

    @property
    def bends(self) -> bool:
        """Whether it distorts."""
        return self.distortion != (0.0, 0.0)

    @property
    def aspect(self) -> float:
        """fy/fx, 1 for square pixels."""
        return self.focal[1] / self.focal[0]

    @cached_property
    def reach(self) -> float:
        """r up to which the seen distance grows with r, inf without an end: from there on images would fold back."""
        k1, k2 = self.distortion
        squared = np.roots([5 * k2, 3 * k1, 1])  # zeros of the growth, in r²
        ends = squared[np.isreal(squared) & (squared.real > 0)].real
        return float(np.sqrt(ends.min())) if len(ends) else np.inf

    def stretch(self, squared: NDArray) -> NDArray:
        """1 + k1 r² + k2 r⁴ of r²; beyond `reach` as there, so that what is farther out is seen farther out."""
        k1, k2 = self.distortion
        squared = np.minimum(squared, self.reach**2)
        return 1 + squared * (k1 + k2 * squared)

    def shows(self, image: NDArray) -> bool:
        """Whether the distortion can be undone in all of image: (..., 2) px."""
        if not np.isfinite(self.reach):
            return True
        seen = ((image - self.centre) / self.focal).reshape(-1, 2)
        return bool((np.hypot(*seen.T) < self.reach * self.stretch(np.array(self.reach**2))).all())

    def direction(self, image: NDArray) -> NDArray:
        """image: (..., 2) px → (..., 2), where its ray meets the plane one focal length ahead."""
        on_plane = (image - self.centre) / self.focal
        if not self.bends:
            return on_plane
        k1, k2 = self.distortion
        seen = np.hypot(on_plane[..., 0], on_plane[..., 1])
        r = np.minimum(seen, self.reach)
        for _ in range(ROUNDS):
            squared = np.minimum(r * r, self.reach**2)
            growth = np.maximum(1 + squared * (3 * k1 + 5 * k2 * squared), LEAST_GROWTH)
            r = np.maximum(r - (r * self.stretch(r * r) - seen) / growth, 0)
        return on_plane / self.stretch(r * r)[..., None]

    def undistort(self, image: NDArray) -> NDArray:
        """(..., 2) px → where it would be without distortion, px."""
        return self.direction(image) * self.focal + self.centre if self.bends else image
