"""The affine epipolar geometry of all pairs of the four views, from which epipolar lines follow."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .affine import MIN_POINTS, centred

PAIRS = np.array([(0, 2), (1, 2), (0, 3), (1, 3), (0, 1), (2, 3)])  # of the views l, r, L, R: [p], [q] of each
EYES = 4  # the place among PAIRS of l and r, between which the own arm changes nothing
COORDINATES = np.concatenate([2 * PAIRS, 2 * PAIRS + 1], 1)[:, [0, 2, 1, 3]]  # of x_l, y_l … y_R, those of each pair
# The views of each of twelve lines: that it is drawn in, and whose point it is of
INTO, SOURCE = np.concatenate([PAIRS[:, ::-1], PAIRS]).T


class PairGeometry(NamedTuple):
    """Eq. (1) of each of PAIRS: f (6, 4), unit norm, sign arbitrary; f33 (6,) px."""

    f: NDArray
    f33: NDArray

    def lines(self, images: NDArray) -> NDArray:
        """(12, 3): a x + b y + c = 0 px in the views INTO, of a point seen in the views SOURCE. images: (4, 2) px in
        l, r, L, R."""
        # f_p·p + f_q·q + f33 = 0 is a line of q for a given p, and of p for a given q; the lines of one point are soon
        # told number by number: each call of numpy takes as long as a few of them
        seen, of_p, of_q = images.tolist(), [], []
        for (p, q), (f13, f23, f31, f32), f33 in zip(PAIRS.tolist(), self.f.tolist(), self.f33.tolist()):
            of_p.append((f31, f32, f33 + f13 * seen[p][0] + f23 * seen[p][1]))
            of_q.append((f13, f23, f33 + f31 * seen[q][0] + f32 * seen[q][1]))
        return np.array(of_p + of_q)


def fit_pairs(points: NDArray, others: NDArray | None = None) -> PairGeometry | None:
    """points: (N, 8) px in l, r, L, R of those seen in all four; None with too few of them. others: (5, 4), f of all
    pairs but EYES, if they were fitted to these points already."""
    if len(points) < MIN_POINTS:
        return None
    mean, about = centred(points)
    if others is None:
        f = fundamentals(about, COORDINATES)
    else:
        f = np.concatenate([others[:EYES], _of_eyes(about[:, :4].tobytes()), others[EYES:]])
    return PairGeometry(f, -(f * mean[COORDINATES]).sum(1))


@lru_cache(64)  # the demonstrator mostly stands still while the learner moves
def _of_eyes(demo: bytes) -> NDArray:
    """f of EYES, (1, 4). demo: (N, 4) px in l, r about their centroids."""
    return fundamentals(np.frombuffer(demo).reshape(-1, 4), COORDINATES[[EYES]])


def fundamentals(points: NDArray, coordinates: NDArray) -> NDArray:
    """f of Eq. (2) of several pairs of views of one posture, (P, 4), unit norm, sign arbitrary, from one scatter matrix
    of all. points: (N, C) px about their centroid; coordinates: (P, 4), those of [p] and [q] of each pair."""
    scatter = points.T @ points
    return np.linalg.eigh(scatter[coordinates[:, :, None], coordinates[:, None]])[1][..., 0]
