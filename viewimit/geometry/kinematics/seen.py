"""What is known of a body's images: where they were seen, by displacement."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Seen:
    """Of K visits: displacement (K, m) rad; images (K, N, 4) px; whole (K, N) bool, of points seen in both images."""

    displacement: NDArray
    images: NDArray
    whole: NDArray

    def only(self, points: NDArray) -> "Seen":
        """Of these points, (N,) bool, alone."""
        return Seen(self.displacement, self.images, self.whole & points)

    def at(self, visits: NDArray) -> "Seen":
        """Of some of the visits, (K,) bool or indices."""
        return Seen(self.displacement[visits], self.images[visits], self.whole[visits])

    @property
    def points(self) -> int:
        """How many were seen at all."""
        return int(np.count_nonzero(self.whole.any(0)))
