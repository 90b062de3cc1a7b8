"""Fundamental matrix F of a stereo head: r̃ᵀ F l̃ = 0 for matches l, r, with x̃ = (x, y, 1).

One head makes both pairs of views, so [l] and [r] share their F with [L] and [R], at every posture: the matches of all
of them are pooled. `fit_fundamental` starts with the eight-point algorithm (Hartley 1997), reweighted a few times by
Sampson's weights. Gauss-Newton steps on the manifold of matrices of rank 2 follow, as the matrix of rank 2 nearest to
one of rank 3 may be far from the matches.

References
----------
Hartley, "In defense of the eight-point algorithm", PAMI 19(6), 1997.
Hartley and Zisserman, Multiple View Geometry, 2nd ed. 2004, chapter 11 and section 5.2.
"""

import numpy as np
from numpy.typing import NDArray

MIN_MATCHES = 8
N_REWEIGHTINGS, MAX_STEPS = 4, 3
FTOL = 1e-6  # relative decrease of the squares, below which another step is not made
TINY = 1e-300  # keeps quotients finite
DEGREES_OF_FREEDOM = 7  # of the nine elements: without the scale, and the rank is 2
PERSPECTIVE_STD = 0.1  # prior of F's upper left block, which is 0.03 at 20° of toe-in and 80° of view
MAX_MAP_STEPS = 30  # 4 are usual


def fit_fundamental(
    left: NDArray[np.float64], right: NDArray[np.float64], n_reweightings: int = N_REWEIGHTINGS
) -> NDArray[np.float64]:
    """Fit F to matches by minimising Sampson's distances.

    Parameters
    ----------
    left, right : (M, 2) array
        Matches [px].
    n_reweightings : int
        Iterations of the weights, after which Gauss-Newton steps follow; 0 for the eight-point algorithm alone.

    Returns
    -------
    (3, 3) array
        F of rank 2 for px; it has norm 1 in centred and scaled coordinates.

    Raises
    ------
    ValueError
        With fewer than 8 matches.
    """
    T_left, T_right, l, r = _normalised(left, right)
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    weight = np.ones(len(l))
    for _ in range(1 + n_reweightings):
        F = _nearest_of_rank_2(np.linalg.eigh((rows * weight[:, None]).T @ rows)[1][:, 0].reshape(3, 3))
        weight = 1 / np.maximum(_squared_gradient(F, l, r), TINY)
    if n_reweightings:
        F = _minimise_sampson(F, l, r)
    return T_right.T @ F @ T_left


def fit_fundamental_with_prior(left: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fit F to few noisy matches: maximum a posteriori, with a prior that the cameras are nearly affine.

    The upper left 2 x 2 block of F is what perspective adds to an affine geometry. Its elements, in centred and scaled
    coordinates at norm 1, have mean 0 and standard deviation PERSPECTIVE_STD. `fit_fundamental`, which has no prior,
    may put the epipoles of some 20 noisy matches anywhere; with many matches, or without noise, both agree.

    left, right: (M, 2) px → F (3, 3) of rank 2, for px. Raises ValueError with fewer than 8 matches.
    """
    T_left, T_right, l, r = _normalised(left, right)
    matches = np.concatenate([l[:, :2], r[:, :2]], 1)
    a, b, c, d = np.linalg.eigh(matches.T @ matches)[1][:, 0]  # the nearest affine geometry, Eq. (2)
    affine = np.array([[0, 0, c], [0, 0, d], [a, b, 0]])
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    eight_point = _nearest_of_rank_2(np.linalg.eigh(rows.T @ rows)[1][:, 0].reshape(3, 3))
    found = [_maximise_posterior(start / np.linalg.norm(start), l, r) for start in (affine, eight_point)]
    F = min(found, key=lambda one: one[0])[1]
    return T_right.T @ F @ T_left


def sampson_distance(
    F: NDArray[np.float64], left: NDArray[np.float64], right: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Distances of matches (M, 2) px from satisfying F, to first order, with the sign of r̃ᵀ F l̃: (M,) px."""
    l, r = homogeneous(left), homogeneous(right)
    return np.einsum("mi,ij,mj->m", r, F, l) / np.sqrt(np.maximum(_squared_gradient(F, l, r), TINY))


def epipoles(F: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Epipoles of the left image, F e = 0, and the right one, Fᵀ e' = 0: (3,) of length 1, e₃ = 0 at infinity."""
    U, _, Vt = np.linalg.svd(F)
    return Vt[2], U[:, 2]


def homogeneous(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Append a 1 to points: (..., 2) → (..., 3)."""
    return np.concatenate([points, np.ones(points.shape[:-1] + (1,))], -1)


def _maximise_posterior(F: NDArray, l: NDArray, r: NDArray) -> tuple[float, NDArray]:
    """Gauss-Newton steps with the prior, from F (3, 3); return the negative log posterior, and F. l, r: (M, 3)."""
    tangent, e, J = _linearised(F, l, r)
    for _ in range(MAX_MAP_STEPS):
        weight = np.sqrt(e @ e / max(len(e) - DEGREES_OF_FREEDOM, 1)) / PERSPECTIVE_STD  # noise over prior
        rows = np.concatenate([J, weight * tangent.reshape(3, 3, -1)[:2, :2].reshape(4, -1)])
        residuals = np.concatenate([e, weight * F[:2, :2].ravel()])
        stepped = _nearest_of_rank_2(F - (tangent @ np.linalg.lstsq(rows, residuals, rcond=None)[0]).reshape(3, 3))
        stepped = stepped / np.linalg.norm(stepped)
        cost = residuals @ residuals
        tangent_stepped, e_stepped, J_stepped = _linearised(stepped, l, r)
        decrease = cost - e_stepped @ e_stepped - weight**2 * np.sum(stepped[:2, :2] ** 2)
        if not decrease > 0:
            break
        F, tangent, e, J = stepped, tangent_stepped, e_stepped, J_stepped
        if not decrease > FTOL * cost:
            break
    return float(len(e) * np.log(max(e @ e, TINY)) + np.sum(F[:2, :2] ** 2) / PERSPECTIVE_STD**2), F


def _minimise_sampson(F: NDArray, l: NDArray, r: NDArray) -> NDArray:
    """F of rank 2 and norm 1 with the least squares of Sampson's distances. l, r: (M, 3)."""
    tangent, e, J = _linearised(F, l, r)
    for _ in range(MAX_STEPS):
        stepped = _nearest_of_rank_2(F - (tangent @ np.linalg.lstsq(J.T @ J, J.T @ e, rcond=None)[0]).reshape(3, 3))
        stepped = stepped / np.linalg.norm(stepped)
        tangent, e_stepped, J = _linearised(stepped, l, r)
        decrease = e @ e - e_stepped @ e_stepped
        if decrease > 0:
            F, e = stepped, e_stepped
        if not decrease > FTOL * (e @ e):
            break
    return F


def _linearised(F: NDArray, l: NDArray, r: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Directions (9, 7) in which F keeps rank 2 and norm 1, Sampson's distances (M,), and their derivatives (M, 7).

    The weights of the distances are held.
    """
    U, _, Vt = np.linalg.svd(F)
    normals = np.stack([F.ravel(), np.outer(U[:, 2], Vt[2]).ravel()], 1)
    tangent = np.linalg.svd(normals)[0][:, 2:]
    weight = 1 / np.sqrt(np.maximum(_squared_gradient(F, l, r), TINY))
    rows = (r[:, :, None] * l[:, None, :]).reshape(-1, 9)
    return tangent, weight * (rows @ F.ravel()), weight[:, None] * (rows @ tangent)


def _squared_gradient(F: NDArray, l: NDArray, r: NDArray) -> NDArray:
    """Squared gradient of r̃ᵀ F l̃ by the four image coordinates: (M,)."""
    return ((l @ F.T)[:, :2] ** 2).sum(1) + ((r @ F)[:, :2] ** 2).sum(1)


def _nearest_of_rank_2(F: NDArray) -> NDArray:
    U, sigma, Vt = np.linalg.svd(F)
    return (U[:, :2] * sigma[:2]) @ Vt[:2]


def _normalised(left: NDArray, right: NDArray) -> tuple[NDArray, NDArray, NDArray, NDArray]:
    """Transforms (3, 3) that centre both images and scale them alike, and the transformed matches, (M, 3)."""
    if len(left) < MIN_MATCHES:
        raise ValueError(f"need at least {MIN_MATCHES} matches for a fundamental matrix, got {len(left)}")
    scale = 1 / max(float(np.sqrt(np.mean([points.var(0).sum() for points in (left, right)]) / 2)), TINY)
    T_left, T_right = np.diag((scale, scale, 1.0)), np.diag((scale, scale, 1.0))
    T_left[:2, 2], T_right[:2, 2] = -scale * left.mean(0), -scale * right.mean(0)
    return T_left, T_right, homogeneous(left) @ T_left.T, homogeneous(right) @ T_right.T
