"""Affine epipolar geometry of two images: Eqs. (1)-(3) of the paper.

"View-Based Imitation Learning by Conflict Resolution with Epipolar Geometry", IROS 2001. An affine fundamental matrix
of the images [p], [q] is f = (f13, f23, f31, f32) and f33, so that a match satisfies

    f13 x_p + f23 y_p + f31 x_q + f32 y_q + f33 = 0.

Points are (..., N, 2) or (..., N, 4) px. Scatter matrices and their eigenvectors have the component axes first and the
batch last, so that long batches stay contiguous in memory. W of Eq. (2) is kept as its 2 x 2 blocks
P = Σ p pᵀ, M = Σ p qᵀ, Q = Σ q qᵀ.

References
----------
Hartley and Zisserman, Multiple View Geometry, 2nd ed. 2004, chapter 14.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .small_matrices import smallest_eigenpair

TYPICAL_RMS_PX = 70.0  # distance of image points from their centroid; see `image_unit`
MIN_POINTS = 5  # with four, the centred 4 x N matrix has rank 3: any images fit, E would be identically 0
VIEW_PAIRS = np.array([(0, 2), (1, 2), (0, 3), (1, 3), (0, 1), (2, 3)])  # [p], [q] of each, of the views l, r, L, R
DEMO_PAIR = 4  # index of l and r among VIEW_PAIRS: the learner's motion does not change it
PAIR_COORDINATES = np.concatenate([2 * VIEW_PAIRS, 2 * VIEW_PAIRS + 1], 1)[:, [0, 2, 1, 3]]  # of x_l, y_l … y_R
LINE_VIEWS, POINT_VIEWS = np.concatenate([VIEW_PAIRS[:, ::-1], VIEW_PAIRS]).T  # of each of twelve epipolar lines


def fit_affine_fundamental(p: ArrayLike, q: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit an affine fundamental matrix to matches: the nearest hyperplane in the 4-space of [p; q].

    Parameters
    ----------
    p, q : (..., N, 2) array
        Matches [px]; OpenCV's (..., N, 1, 2) is accepted as well.

    Returns
    -------
    f : (..., 4) array
        (f13, f23, f31, f32) of unit norm and arbitrary sign.
    f33 : (...) array
        [px]

    Raises
    ------
    ValueError
        With fewer than 5 points; its subclass LinAlgError with coordinates that are not finite.

    Notes
    -----
    Eqs. (1)-(3); Hartley and Zisserman 2004, algorithm 14.1. Eq. (2) prints 1/n for 1/N, and the u_0 of Eq. (3) is the
    centroid.
    """
    p, q = np.broadcast_arrays(image_points(np.asarray(p, float)), image_points(np.asarray(q, float)))
    require_points(p.shape[-2])
    mean_p, p = centred(p)
    mean_q, q = centred(q)
    _, f = smallest_eigenpair(cross_scatter(p, p), cross_scatter(p, q), cross_scatter(q, q))
    f = np.moveaxis(f, 0, -1).reshape(p.shape[:-2] + (4,))
    return f, -(f[..., :2] * mean_p + f[..., 2:] * mean_q).sum(-1)


def image_points(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Reshape OpenCV's arrays of points, (..., N, 1, 2), to (..., N, 2); return all other arrays unchanged.

    As a batch, (N, 1, 2) would be N postures of one point each, to which no geometry can be fitted.
    """
    return points[..., 0, :] if points.ndim > 2 and points.shape[-2:] == (1, 2) else points


def require_points(count: int) -> None:
    """Raise ValueError if this number of points cannot determine an evaluation function."""
    if count < MIN_POINTS:
        raise ValueError(f"need at least {MIN_POINTS} points, got {count}: E would be identically zero")


def centred(points: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean (..., k) of points (..., N, k), and the points relative to it."""
    mean = np.add.reduce(points, -2) / points.shape[-2]
    return mean, points - mean[..., None, :]


def image_unit(images: NDArray[np.float64]) -> float:
    """Length [px] of the unit for image lengths that are not standard deviations of noise.

    It is a pixel if the points of each image are TYPICAL_RMS_PX from their centroid, root mean square, as those of a
    robot of a metre are in images of 640 pixels. images: (M, 2 v) px in v images. Returns 1 for points that coincide.
    """
    if not len(images):
        return 1.0
    offsets = centred(images)[1]
    square = float(np.vdot(offsets, offsets)) * 2 / offsets.size
    return math.sqrt(square) / TYPICAL_RMS_PX if square > 0 else 1.0


def flatness(stereo: NDArray[np.float64]) -> float:
    """Condition σ1/σ3 of the affine shape of stereo points (N, 4) px; inf if they lie in a plane.

    Coplanar points leave every fundamental matrix undetermined, which neither E nor cond(A) shows.
    """
    sigma = np.linalg.svd(centred(stereo)[1], compute_uv=False)
    return float(sigma[0] / sigma[2]) if sigma[2] > sigma[0] * np.finfo(float).eps * len(stereo) else np.inf


def cross_scatter(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Σ_i a_i b_iᵀ. a: (..., N, j), or (N, j) for all; b: (..., N, k) → (j, k, G), the batch flattened to G."""
    b = components_first(b)
    if a.ndim == 2:  # one set of points for the whole batch: a single matrix product
        return (a.T @ b).swapaxes(0, 1)
    return np.einsum("jng,kng->jkg", components_first(a), b)


def components_first(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., N, k) → (k, N, G), contiguous, the batch flattened to G."""
    return np.ascontiguousarray(points.reshape((-1,) + points.shape[-2:]).transpose(2, 1, 0))


class PairGeometry(NamedTuple):
    """Affine fundamental matrices of all VIEW_PAIRS, Eq. (1)."""

    f: NDArray[np.float64]  # (6, 4), unit norm, sign arbitrary
    f33: NDArray[np.float64]  # (6,) px

    def lines(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        """Epipolar lines a x + b y + c = 0 of a point with images (4, 2) px in l, r, L, R: (12, 3).

        Each is a line in one of LINE_VIEWS, of the point's image in the same element of POINT_VIEWS.
        """
        # f_p·p + f_q·q + f33 = 0 is a line of q for a given p, and of p for a given q. Plain numbers, as one call of
        # numpy takes as long as a few lines.
        points, of_p, of_q = images.tolist(), [], []
        for (p, q), (f13, f23, f31, f32), f33 in zip(VIEW_PAIRS.tolist(), self.f.tolist(), self.f33.tolist()):
            of_p.append((f31, f32, f33 + f13 * points[p][0] + f23 * points[p][1]))
            of_q.append((f13, f23, f33 + f31 * points[q][0] + f32 * points[q][1]))
        return np.array(of_p + of_q)


def fit_pairs(points: NDArray[np.float64], others: NDArray[np.float64] | None) -> PairGeometry | None:
    """Fit the affine fundamental matrices of all VIEW_PAIRS; None with too few points.

    points: (N, 8) px in l, r, L, R, of points visible in all four; others: (5, 4), f of all pairs but DEMO_PAIR, if
    they were fitted to these points already.
    """
    if len(points) < MIN_POINTS:
        return None
    mean, offsets = centred(points)
    if others is None:
        f = pair_fundamentals(offsets, PAIR_COORDINATES)
    else:
        f = np.concatenate([others[:DEMO_PAIR], _of_demo_pair(offsets[:, :4].tobytes()), others[DEMO_PAIR:]])
    return PairGeometry(f, -(f * mean[PAIR_COORDINATES]).sum(1))


@lru_cache(64)  # the demonstrator mostly stands still while the learner moves
def _of_demo_pair(demo: bytes) -> NDArray:
    """f of DEMO_PAIR, (1, 4). demo: (N, 4) px in l, r about their centroids."""
    return pair_fundamentals(np.frombuffer(demo).reshape(-1, 4), PAIR_COORDINATES[[DEMO_PAIR]])


def pair_fundamentals(points: NDArray[np.float64], coordinates: NDArray[np.int_]) -> NDArray[np.float64]:
    """Fit f of Eq. (2) of several pairs of views, (P, 4) of unit norm and arbitrary sign, from one scatter matrix.

    points: (N, C) px about their centroid; coordinates: (P, 4), those of [p] and [q] of each pair.
    """
    scatter = points.T @ points
    return np.linalg.eigh(scatter[coordinates[:, :, None], coordinates[:, None]])[1][..., 0]
