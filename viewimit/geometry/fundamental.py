"""The fundamental matrix F of a stereo head, from all matches that it has seen: r̃ᵀ F l̃ = 0 with x̃ = (x, y, 1).

One head makes both pairs of views, so [l] and [r] share their F with [L] and [R], at every posture: matches of all of
them are pooled. Hartley's eight-point algorithm (1997), weighted in a few rounds as Sampson's distance wants it, then
steps of Gauss and Newton among matrices of rank 2: the one nearest to a full one may be far from the matches.
"""

import numpy as np
from numpy.typing import NDArray

MIN_MATCHES = 8
ROUNDS, STEPS = 4, 3
WORTHWHILE = 1e-6  # share of the squares that a step lowers, below which another is not made
TINY = 1e-300  # keeps quotients finite
FREE = 7  # of the nine elements: not the scale, and the rank is 2
PERSPECTIVE = 0.1  # prior standard deviation of F's upper left block, which is 0.03 at 20° of toe-in and 80° of view
PRIOR_STEPS = 30  # at most; 4 are usual


def fit_fundamental(left: NDArray, right: NDArray, rounds: int = ROUNDS) -> NDArray:
    """left, right: (M, 2) px → F (3, 3) of rank 2 and norm 1 in centred and scaled coordinates, returned for px.

    rounds: of weights, after which steps follow; 0 for the eight-point algorithm alone. Raises ValueError with fewer
    than 8 matches.
    """
    if len(left) < MIN_MATCHES:
        raise ValueError(f"need at least {MIN_MATCHES} matches for a fundamental matrix, got {len(left)}")
    T_left, T_right = _normalising(left, right)
    l, r = homogeneous(left) @ T_left.T, homogeneous(right) @ T_right.T
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    weight = np.ones(len(l))
    for _ in range(1 + rounds):
        F = _of_rank_2(np.linalg.eigh((rows * weight[:, None]).T @ rows)[1][:, 0].reshape(3, 3))
        weight = 1 / np.maximum(_squared_gradient(F, l, r), TINY)
    if rounds:
        F = _nearest_to_matches(F, l, r)
    return T_right.T @ F @ T_left


def fit_fundamental_with_prior(left: NDArray, right: NDArray) -> NDArray:
    """Fundamental matrix of few noisy matches, maximum a posteriori: the cameras are nearly affine a priori.

    The upper left 2 x 2 block of F is what perspective adds to an affine geometry. Its elements, in centred and scaled
    coordinates at norm 1, have mean 0 and standard deviation PERSPECTIVE. `fit_fundamental`, which has no prior, may
    put the epipoles of some 20 noisy matches anywhere; with many matches, or without noise, both agree.

    left, right: (M, 2) px → F (3, 3) of rank 2, for px. Raises ValueError with fewer than 8 matches.
    """
    if len(left) < MIN_MATCHES:
        raise ValueError(f"need at least {MIN_MATCHES} matches for a fundamental matrix, got {len(left)}")
    T_left, T_right = _normalising(left, right)
    l, r = homogeneous(left) @ T_left.T, homogeneous(right) @ T_right.T
    matches = np.concatenate([l[:, :2], r[:, :2]], 1)
    a, b, c, d = np.linalg.eigh(matches.T @ matches)[1][:, 0]  # the nearest affine geometry, Eq. (2)
    affine = np.array([[0, 0, c], [0, 0, d], [a, b, 0]])
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    eight_point = _of_rank_2(np.linalg.eigh(rows.T @ rows)[1][:, 0].reshape(3, 3))
    found = [_likeliest(start / np.linalg.norm(start), l, r) for start in (affine, eight_point)]
    F = min(found, key=lambda one: one[0])[1]
    return T_right.T @ F @ T_left


def _likeliest(F: NDArray, l: NDArray, r: NDArray) -> tuple[float, NDArray]:
    """Steps of Gauss and Newton with the prior, from F (3, 3) → what grows as F is less likely, and F. l, r: (M, 3)."""
    tangent, e, J = _linearised(F, l, r)
    for _ in range(PRIOR_STEPS):
        weight = np.sqrt(e @ e / max(len(e) - FREE, 1)) / PERSPECTIVE  # noise over prior
        rows = np.concatenate([J, weight * tangent.reshape(3, 3, -1)[:2, :2].reshape(4, -1)])
        residuals = np.concatenate([e, weight * F[:2, :2].ravel()])
        stepped = _of_rank_2(F - (tangent @ np.linalg.lstsq(rows, residuals, rcond=None)[0]).reshape(3, 3))
        stepped = stepped / np.linalg.norm(stepped)
        before = residuals @ residuals
        tangent_stepped, e_stepped, J_stepped = _linearised(stepped, l, r)
        gained = before - e_stepped @ e_stepped - weight**2 * np.sum(stepped[:2, :2] ** 2)
        if not gained > 0:
            break
        F, tangent, e, J = stepped, tangent_stepped, e_stepped, J_stepped
        if not gained > WORTHWHILE * before:
            break
    return float(len(e) * np.log(max(e @ e, TINY)) + np.sum(F[:2, :2] ** 2) / PERSPECTIVE**2), F


def neighbours(F: NDArray, left: NDArray, right: NDArray) -> NDArray:
    """(7, 3, 3): F of `fit_fundamental` moved by one standard deviation along each of its independent directions, as
    the matches' distances from it tell their noise: s²(JᵀJ)⁻¹ (Hartley and Zisserman, Sec. 5.2). left, right: (M, 2)
    px."""
    T_left, T_right = _normalising(left, right)
    l, r = homogeneous(left) @ T_left.T, homogeneous(right) @ T_right.T
    F = np.linalg.inv(T_right).T @ F @ np.linalg.inv(T_left)
    F = F / np.linalg.norm(F)
    tangent, e, J = _linearised(F, l, r)
    squared, ways = np.linalg.eigh(J.T @ J)
    deviation = np.sqrt(e @ e / max(len(e) - FREE, 1) / np.maximum(squared, TINY))
    away = (tangent @ (ways * np.minimum(deviation, 1.0))).T.reshape(-1, 3, 3)
    return np.array([T_right.T @ _of_rank_2(F + step) @ T_left for step in away])


def sampson_distance(F: NDArray, left: NDArray, right: NDArray) -> NDArray:
    """How far matches are from obeying F, to first order, with the sign of r̃ᵀ F l̃. left, right: (M, 2) → (M,) px."""
    l, r = homogeneous(left), homogeneous(right)
    return np.einsum("mi,ij,mj->m", r, F, l) / np.sqrt(np.maximum(_squared_gradient(F, l, r), TINY))


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


def _nearest_to_matches(F: NDArray, l: NDArray, r: NDArray) -> NDArray:
    """Of rank 2 and norm 1, with the least squares of Sampson's distances; l, r: (M, 3)."""
    tangent, e, J = _linearised(F, l, r)
    for _ in range(STEPS):
        stepped = _of_rank_2(F - (tangent @ np.linalg.lstsq(J.T @ J, J.T @ e, rcond=None)[0]).reshape(3, 3))
        stepped = stepped / np.linalg.norm(stepped)
        tangent, e_stepped, J = _linearised(stepped, l, r)
        gained = e @ e - e_stepped @ e_stepped
        if gained > 0:
            F, e = stepped, e_stepped
        if not gained > WORTHWHILE * (e @ e):
            break
    return F


def _linearised(F: NDArray, l: NDArray, r: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Directions (9, 7) in which F stays of rank 2 and norm 1, Sampson's distances (M,) and their derivatives (M, 7),
    their weights held."""
    U, _, Vt = np.linalg.svd(F)
    barred = np.stack([F.ravel(), np.outer(U[:, 2], Vt[2]).ravel()], 1)
    tangent = np.linalg.svd(barred)[0][:, 2:]
    weight = 1 / np.sqrt(np.maximum(_squared_gradient(F, l, r), TINY))
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    return tangent, weight * (rows @ F.ravel()), weight[:, None] * (rows @ tangent)


def _normalising(left: NDArray, right: NDArray) -> tuple[NDArray, NDArray]:
    """(3, 3) each, from px to coordinates that are centred, and scaled alike."""
    scale = 1 / max(float(np.sqrt(np.mean([points.var(0).sum() for points in (left, right)]) / 2)), TINY)
    to_left, to_right = np.diag((scale, scale, 1.0)), np.diag((scale, scale, 1.0))
    to_left[:2, 2], to_right[:2, 2] = -scale * left.mean(0), -scale * right.mean(0)
    return to_left, to_right
