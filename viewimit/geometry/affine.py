"""Affine epipolar geometry of two images: Eqs. (1)-(3) of the paper, IROS 2001.

"View-Based Imitation Learning by Conflict Resolution with Epipolar Geometry". An affine fundamental
matrix of the images [p], [q] is kept as f = (f13, f23, f31, f32) and f33, so that a match obeys
f13 x_p + f23 y_p + f31 x_q + f32 y_q + f33 = 0.

Points are (..., N, 2) or (..., N, 4) px. Scatter matrices and what is computed from them keep their component
axes first and the batch last, so that long batches stay contiguous in memory. W of Eq. (2) is kept as
its 2 x 2 blocks P = Σ p pᵀ, M = Σ p qᵀ, Q = Σ q qᵀ.
"""

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .small_matrices import smallest_eigenpair

TYPICAL_PX = 70.0  # rms distance of image points from their centroid; see `image_unit`
MIN_POINTS = 5  # with four, the centred 4 x N matrix has rank 3: any images fit, E would be identically 0


def fit_affine_fundamental(p: ArrayLike, q: ArrayLike) -> tuple[NDArray, NDArray]:
    """Eqs. (1)-(3): the hyperplane nearest to the matches in the 4-space of [p; q].

    p, q: (..., N, 2) px, or OpenCV's (..., N, 1, 2) → f: (..., 4), unit norm, sign arbitrary; f33: (...) px.
    Eq. (2) prints 1/n for 1/N, and the u_0 of Eq. (3) is the centroid.
    Raises ValueError with fewer than 5 points, its kind LinAlgError with a coordinate that is not finite.
    """
    p, q = np.broadcast_arrays(image_points(np.asarray(p, float)), image_points(np.asarray(q, float)))
    require_points(p.shape[-2])
    mean_p, p = centred(p)
    mean_q, q = centred(q)
    _, f = smallest_eigenpair(scatter(p, p), scatter(p, q), scatter(q, q))
    f = np.moveaxis(f, 0, -1).reshape(p.shape[:-2] + (4,))
    return f, -(f[..., :2] * mean_p + f[..., 2:] * mean_q).sum(-1)


def image_points(points: NDArray) -> NDArray:
    """OpenCV's arrays of points, (..., N, 1, 2), as (..., N, 2); all other arrays as they are.

    As a batch, (N, 1, 2) would be N postures of one point each, of which no geometry can be fitted.
    """
    return points[..., 0, :] if points.ndim > 2 and points.shape[-2:] == (1, 2) else points


def require_points(count: int) -> None:
    """Raise ValueError if `count` points cannot determine an evaluation function."""
    if count < MIN_POINTS:
        raise ValueError(f"need at least {MIN_POINTS} points, got {count}: E would be identically zero")


def centred(points: NDArray) -> tuple[NDArray, NDArray]:
    """points: (..., N, k) px → their mean (..., k) and the points about it (..., N, k)."""
    mean = np.add.reduce(points, -2) / points.shape[-2]
    return mean, points - mean[..., None, :]


def image_unit(images: NDArray) -> float:
    """Return how many pixels one unit is, in which lengths that are no standard deviations of noise are given.

    It is a pixel for points TYPICAL_PX from the centroid of each image, root mean square, as those of a robot of a
    metre are in images of 640 pixels. images: (M, 2 v) px in v images, M ≥ 0. Returns 1 for points that do not differ.
    """
    if not len(images):
        return 1.0
    away = centred(images)[1]
    square = float(np.vdot(away, away)) * 2 / away.size
    return math.sqrt(square) / TYPICAL_PX if square > 0 else 1.0


def flatness(stereo: NDArray) -> float:
    """σ1/σ3 of centred stereo points (N, 4) px: their affine shape's condition, inf if they lie in a plane.

    Coplanar points leave every fundamental matrix undetermined, which neither E nor cond(A) shows.
    """
    sigma = np.linalg.svd(centred(stereo)[1], compute_uv=False)
    return float(sigma[0] / sigma[2]) if sigma[2] > sigma[0] * np.finfo(float).eps * len(stereo) else np.inf


def scatter(a: NDArray, b: NDArray) -> NDArray:
    """Σ_i a_i b_iᵀ. a: (..., N, j) or (N, j) for all, b: (..., N, k) → (j, k, G), the batch flattened to G."""
    b = components_first(b)
    if a.ndim == 2:  # one set of points for the whole batch: a single matrix product
        return (a.T @ b).swapaxes(0, 1)
    return np.einsum("jng,kng->jkg", components_first(a), b)


def components_first(points: NDArray) -> NDArray:
    """(..., N, k) → (k, N, G), contiguous, the batch flattened to G."""
    return np.ascontiguousarray(points.reshape((-1,) + points.shape[-2:]).transpose(2, 1, 0))


# The affine epipolar geometry of all pairs of the four views, from which epipolar lines follow.

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
