"""The fundamental matrix F of a stereo head, from all matches that it has seen: r̃ᵀ F l̃ = 0 with x̃ = (x, y, 1).

One head makes both pairs of views, so [l] and [r] share their F with [L] and [R], at every posture: matches of all of
them are pooled. Hartley's eight-point algorithm (1997), weighted in a few rounds as Sampson's distance wants it.
"""

import numpy as np
from numpy.typing import NDArray

MIN_MATCHES = 8
ROUNDS = 4


def fit_fundamental(left: NDArray, right: NDArray, rounds: int = ROUNDS) -> NDArray:
    """left, right: (M, 2) px → F (3, 3) of rank 2 and norm 1 in centred and scaled coordinates, returned for px.

    Raises ValueError with fewer than 8 matches.
    """
    if len(left) < MIN_MATCHES:
        raise ValueError(f"need at least {MIN_MATCHES} matches for a fundamental matrix, got {len(left)}")
    centres = left.mean(0), right.mean(0)
    scale = 1 / max(float(np.sqrt(np.mean([points.var(0).sum() for points in (left, right)]) / 2)), 1e-300)
    T_left, T_right = (_normalising(centre, scale) for centre in centres)
    l, r = (homogeneous(scale * (points - centre)) for points, centre in zip((left, right), centres))
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    weight = np.ones(len(l))
    for _ in range(1 + rounds):
        F = _of_rank_2(np.linalg.eigh((rows * weight[:, None]).T @ rows)[1][:, 0].reshape(3, 3))
        weight = 1 / np.maximum(_squared_gradient(F, l, r), 1e-300)
    return T_right.T @ F @ T_left


def sampson_distance(F: NDArray, left: NDArray, right: NDArray) -> NDArray:
    """How far matches are from obeying F, to first order, with the sign of r̃ᵀ F l̃. left, right: (M, 2) → (M,) px."""
    l, r = homogeneous(left), homogeneous(right)
    return np.einsum("mi,ij,mj->m", r, F, l) / np.sqrt(np.maximum(_squared_gradient(F, l, r), 1e-300))


def epipoles(F: NDArray) -> tuple[NDArray, NDArray]:
    """Of the left image, F e = 0, and of the right one, Fᵀ e' = 0: (3,) of length 1 each, e₃ = 0 at infinity."""
    U, _, Vt = np.linalg.svd(F)
    return Vt[2], U[:, 2]


def homogeneous(points: NDArray) -> NDArray:
    """(..., 2) → (..., 3)"""
    return np.concatenate([points, np.ones(points.shape[:-1] + (1,))], -1)


def _squared_gradient(F: NDArray, l: NDArray, r: NDArray) -> NDArray:
    """Of r̃ᵀ F l̃ by the four image coordinates: (M,)"""
    return ((l @ F.T)[:, :2] ** 2).sum(1) + ((r @ F)[:, :2] ** 2).sum(1)


def _of_rank_2(F: NDArray) -> NDArray:
    U, sigma, Vt = np.linalg.svd(F)
    return (U[:, :2] * sigma[:2]) @ Vt[:2]


def _normalising(centre: NDArray, scale: float) -> NDArray:
    return np.array([[scale, 0, -scale * centre[0]], [0, scale, -scale * centre[1]], [0, 0, 1]])
