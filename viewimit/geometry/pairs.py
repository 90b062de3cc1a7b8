"""The affine epipolar geometry of all pairs of the four views, from which epipolar lines follow."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .affine import MIN_POINTS, fit_affine_fundamental

PAIRS = np.array([(0, 2), (1, 2), (0, 3), (1, 3), (0, 1), (2, 3)])  # of the views l, r, L, R: [p], [q] of each
# The views of each of twelve lines: that it is drawn in, and whose point it is of
INTO, SOURCE = np.concatenate([PAIRS[:, ::-1], PAIRS]).T


class PairGeometry(NamedTuple):
    """Eq. (1) of each of PAIRS: f (6, 4), unit norm, sign arbitrary; f33 (6,) px."""

    f: NDArray
    f33: NDArray

    def lines(self, images: NDArray) -> NDArray:
        """(12, 3): a x + b y + c = 0 px in the views INTO, of a point seen in the views SOURCE. images: (4, 2) px in
        l, r, L, R."""
        # f_p·p + f_q·q + f33 = 0 is a line of q for a given p, and of p for a given q
        normal = np.concatenate([self.f[:, 2:], self.f[:, :2]])
        of_source = np.concatenate([self.f[:, :2], self.f[:, 2:]])
        offset = np.concatenate([self.f33, self.f33]) + (of_source * images[SOURCE]).sum(1)
        return np.concatenate([normal, offset[:, None]], 1)


def fit_pairs(images: NDArray) -> PairGeometry | None:
    """images: (4, N, 2) px in l, r, L, R of the points seen in all four; None with too few of them."""
    if images.shape[1] < MIN_POINTS:
        return None
    first, second = PAIRS.T
    return PairGeometry(*fit_affine_fundamental(images[first], images[second]))
