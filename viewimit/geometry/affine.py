"""Affine epipolar geometry of two images: Eqs. (1)-(3) of the paper, IROS 2001.

"View-Based Imitation Learning by Conflict Resolution with Epipolar Geometry". An affine fundamental
matrix of the images [p], [q] is kept as f = (f13, f23, f31, f32) and f33, so that a match obeys
f13 x_p + f23 y_p + f31 x_q + f32 y_q + f33 = 0.

Points are (..., N, 2) or (..., N, 4) px. Scatter matrices and what is computed from them keep their component
axes first and the batch last, so that long batches stay contiguous in memory. W of Eq. (2) is kept as
its 2 x 2 blocks P = Σ p pᵀ, M = Σ p qᵀ, Q = Σ q qᵀ.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

TYPICAL_PX = 70.0  # rms distance of image points from their centroid; see `image_unit`
MIN_POINTS = 5  # with four, the centred 4 x N matrix has rank 3: any images fit, E would be identically 0
LAGUERRE_STEPS = 20  # a bound: the iteration stops by itself, after 3 or 4 steps in the shipped scenes
CONVERGED = 1e-6  # last step, relative to the trace of W; the steps shrink cubically, and the next would be rounding
FEW = 32  # eigenproblems that LAPACK solves sooner, one by one, than array operations all at once
FLAT = 1e-10  # f' of a double root, relative to the trace³: steps stay short where f and f' are rounding errors
NEARLY_EQUAL = 1e-5  # of the cofactors of f, relative to the trace³: below, LAPACK takes over; above, f errs by 1e-9


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


def smallest_eigenpair(P: NDArray, M: NDArray, Q: NDArray) -> tuple[NDArray, NDArray]:
    """Smallest eigenvalue and unit eigenvector of W = [[P, M], [Mᵀ, Q]], positive semi-definite.

    P, M, Q: (2, 2, ...) → λ: (...), f: (4, ...), sign arbitrary.

    λ is a root of the characteristic polynomial. With f = [x; y], the lower half of (W - λ)f = 0 gives
    y = -(Q - λ)⁻¹Mᵀx, and x is in the kernel of the Schur complement S = P - λ - M(Q - λ)⁻¹Mᵀ, which is taken
    from its adjugate. Where the smallest two eigenvalues nearly coincide, or f has no part in [p], that
    vanishes: those few go to LAPACK, and so does all of a batch so short that its loop costs less than numpy's calls.
    """
    if M[0, 0].size <= FEW:
        return _by_lapack(P, M, Q)
    s3, s2, s1, s0, M_adj_Q = _characteristic(P, M, Q)
    smallest = _smallest_root(s3, s2, s1, s0)
    c, d, k = Q[0, 0] - smallest, Q[1, 1] - smallest, Q[0, 1]
    det_Q = c * d
    det_Q -= k * k
    M_adj_Q -= smallest * M
    S = np.empty((3,) + det_Q.shape)  # 00, 11, 01 of S det(Q - λ)
    np.subtract(P[0, 0], smallest, out=S[0])
    np.subtract(P[1, 1], smallest, out=S[1])
    S[2] = P[0, 1]
    S *= det_Q
    S[:2] -= np.einsum("ij...,ij...->i...", M_adj_Q, M)
    S[2] -= np.einsum("j...,j...->...", M_adj_Q[0], M[1])
    size = S[0] + S[1]
    # adj S = s xxᵀ times (1, ±1), the sign of x0 x1 chosen so that nothing cancels
    off_diagonal = np.abs(S[2])
    S[:2] += off_diagonal
    x = S[1], np.copysign(S[0], -S[2])
    f = np.empty((4,) + size.shape)
    np.multiply(x[0], det_Q, out=f[0])
    np.multiply(x[1], det_Q, out=f[1])
    f[2:] = -M_adj_Q[0] * x[0]
    f[2:] -= M_adj_Q[1] * x[1]
    with np.errstate(invalid="ignore"):
        f /= np.sqrt(np.einsum("i...,i...->...", f, f))
    weak = ~(size > NEARLY_EQUAL * s3 * s3 * s3)
    if weak.any():
        smallest[weak], f[:, weak] = _by_lapack(*(block[:, :, weak] for block in (P, M, Q)))
    return smallest, f


def extreme_eigenvalues(P: NDArray, M: NDArray, Q: NDArray) -> tuple[NDArray, NDArray]:
    """Smallest and largest eigenvalue of [[P, M], [Mᵀ, Q]], positive semi-definite, from blocks (2, 2, ...)."""
    if M[0, 0].size <= FEW:
        values = np.linalg.eigvalsh(_joined(P, M, Q))
        return values[..., 0], values[..., 3]
    s3, s2, s1, s0, _ = _characteristic(P, M, Q)
    # λ → s3 - λ mirrors the polynomial, so that the largest root becomes the smallest of another one
    squared = s3 * s3
    mirrored = 3 * s3, 3 * squared + s2, squared * s3 + 2 * s2 * s3 - s1, s2 * squared - s1 * s3 + s0
    return _smallest_root(s3, s2, s1, s0), s3 - _smallest_root(*mirrored)


def _characteristic(P: NDArray, M: NDArray, Q: NDArray):
    """s3, s2, s1, s0 of det(W - λ) = λ⁴ - s3 λ³ + s2 λ² - s1 λ + s0, and M adj(Q).

    From det(W) = det P det Q - tr(adj(P) M adj(Q) Mᵀ) + (det M)², with P - λ for P and Q - λ for Q.
    """
    (a, j), (_, b) = P
    (c, k), (_, d) = Q
    M_adj_Q, adj_P_M = np.empty_like(M), np.empty_like(M)
    np.subtract(M[:, 0] * d, M[:, 1] * k, out=M_adj_Q[:, 0])
    np.subtract(M[:, 1] * c, M[:, 0] * k, out=M_adj_Q[:, 1])
    np.subtract(M[0] * b, M[1] * j, out=adj_P_M[0])
    np.subtract(M[1] * a, M[0] * j, out=adj_P_M[1])
    det_P, det_Q, det_M = a * b - j * j, c * d - k * k, M[0, 0] * M[1, 1] - M[0, 1] * M[1, 0]
    trace_P, trace_Q = a + b, c + d
    s3 = trace_P + trace_Q
    s2 = det_P + det_Q + trace_P * trace_Q - _inner(M, M)
    s0 = det_P * det_Q - _inner(adj_P_M, M_adj_Q) + det_M * det_M
    adj_P_M += M_adj_Q
    s1 = trace_P * det_Q + trace_Q * det_P - _inner(adj_P_M, M)
    return s3, s2, s1, s0, M_adj_Q


def _smallest_root(s3: NDArray, s2: NDArray, s1: NDArray, s0: NDArray) -> NDArray:
    """Laguerre's iteration from 0: monotone, for all four roots are real and none is negative."""
    value, slope, half_curve = s0, -s1, s2  # f, f', f''/2 at 0
    tolerance = CONVERGED * s3.min(initial=np.inf)
    floor = FLAT * s3 * s3 * s3  # of the denominator
    floor *= floor
    root = np.zeros_like(s0)
    for _ in range(LAGUERRE_STEPS):
        step = half_curve * value  # 4 f / (-f' + √(9 f'² - 12 f f''))
        step *= -24
        step += 9 * (slope * slope)
        np.maximum(step, floor, out=step)
        np.sqrt(step, out=step)
        step -= slope
        with np.errstate(invalid="ignore"):  # W = 0 has no scale: NaN, which goes to LAPACK
            np.divide(value, step, out=step)
        step *= 4
        root += step
        if step.max(initial=0) <= tolerance:
            break
        b3 = root - s3  # divided by (λ - root) again and again, the remainders are f, f', f''/2
        b2 = b3 * root + s2
        b1 = b2 * root - s1
        value = b1 * root + s0
        b3 += root
        b2 += b3 * root
        slope = b2 * root + b1
        b3 += root
        half_curve = b3 * root + b2
    return root


def _inner(a: NDArray, b: NDArray) -> NDArray:
    """Σ_ij a_ij b_ij of (2, 2, ...)."""
    return np.einsum("ij...,ij...->...", a, b)


def _by_lapack(P: NDArray, M: NDArray, Q: NDArray) -> tuple[NDArray, NDArray]:
    """The smallest eigenpair of each: (...), (4, ...)."""
    values, vectors = np.linalg.eigh(_joined(P, M, Q))
    smallest = vectors[..., 0]
    return values[..., 0], smallest.transpose(smallest.ndim - 1, *range(smallest.ndim - 1))


def _joined(P: NDArray, M: NDArray, Q: NDArray) -> NDArray:
    """W: (..., 4, 4) of its blocks (2, 2, ...)."""
    W = np.empty((4, 4) + M.shape[2:])
    W[:2, :2], W[:2, 2:], W[2:, :2], W[2:, 2:] = P, M, M.swapaxes(0, 1), Q
    return W.transpose(*range(2, W.ndim), 0, 1)  # np.moveaxis takes longer than all the rest for one posture
