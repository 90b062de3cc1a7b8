"""The affine epipolar geometry of all pairs of the four views, from which epipolar lines follow."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .affine import MIN_POINTS, fit_affine_fundamental

PAIRS = np.array([(0, 2), (1, 2), (0, 3), (1, 3), (0, 1), (2, 3)])  # of the views l, r, L, R: [p], [q] of each


class PairGeometry(NamedTuple):
    """Eq. (1) of each of PAIRS: f (6, 4), unit norm, sign arbitrary; f33 (6,) px."""

    f: NDArray
    f33: NDArray


def fit_pairs(images: NDArray) -> PairGeometry | None:
    """images: (4, N, 2) px in l, r, L, R of the points seen in all four; None with too few of them."""
    if images.shape[1] < MIN_POINTS:
        return None
    first, second = PAIRS.T
    return PairGeometry(*fit_affine_fundamental(images[first], images[second]))
