"""What spoils the images that a learner gets: noise, points not found, points found at a wrong place."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

GROSS_PX = 60.0  # a coordinate


@dataclass(frozen=True)
class Disturbance:
    """What spoils an image: Gaussian noise in px (standard deviation a coordinate), the share of points not found, and
    the share found at a wrong place, anywhere within GROSS_PX."""

    noise_px: float = 0.0
    missing: float = 0.0
    outliers: float = 0.0

    def apply(self, points: NDArray, visible: NDArray, seed: Sequence[int]) -> tuple[NDArray, NDArray]:
        """points: (N, 4) px, visible: (N, 2). The draws depend on the seed alone, so that turning one
        disturbance up enlarges the same noise and loses the same points first."""
        if not (self.noise_px or self.missing or self.outliers):
            return points, visible
        rng = np.random.default_rng(seed)
        noise, luck = rng.standard_normal(points.shape), rng.random(visible.shape)
        points, visible = points + self.noise_px * noise, visible & (luck >= self.missing)
        if self.outliers:
            wrong = np.repeat(rng.random(visible.shape) < self.outliers, 2, -1)
            points = np.where(wrong, points + rng.uniform(-GROSS_PX, GROSS_PX, points.shape), points)
        return points, visible

    def frames(self, points: NDArray, visible: NDArray, seed: Sequence[int], count: int) -> tuple[NDArray, NDArray]:
        """Several looks at the same: (count, N, 4) px, (count, N, 2)."""
        looks = [self.apply(points, visible, [*seed, k] if k else seed) for k in range(count)]
        return np.array([points for points, _ in looks]), np.array([visible for _, visible in looks])


UNDISTURBED = Disturbance()
