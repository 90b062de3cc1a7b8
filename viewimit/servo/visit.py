"""What is kept of a posture that was really visited: the displacement to there, and the images seen there."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Visit:
    """A posture really visited: displacement (m,) rad, own (N, 4) px, seen (N, 2) bool in [L], [R].

    Points not seen there are where the model expects them, NaN until they have been seen once.
    """

    displacement: NDArray
    own: NDArray
    seen: NDArray

    @classmethod
    def of(cls, displacement: NDArray, own: NDArray, seen: NDArray) -> "Visit":
        """Of images as they come, in which coordinates of points not seen mean nothing; kept in C order, so that sums
        do not depend on how the images lay in memory."""
        seen = np.ascontiguousarray(seen)
        return cls(displacement, np.where(by_coordinate(seen), np.ascontiguousarray(own), np.nan), seen)


def by_coordinate(seen: NDArray) -> NDArray:
    """(..., N, 2) of [L], [R] → (..., N, 4) of x_L, y_L, x_R, y_R."""
    return np.repeat(seen, 2, axis=-1)
