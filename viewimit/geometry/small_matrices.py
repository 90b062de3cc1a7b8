"""Linear algebra on long batches of small symmetric matrices, which LAPACK would solve slowly, one by one.

Component axes come first and the batch axis last: (n, n, G). Each array operation then runs along contiguous memory.
Short batches go to LAPACK, which takes less time for them than the calls of numpy.

Eigenvalues are roots of the characteristic polynomial, found by Laguerre's iteration. All roots are real, so the
iteration started beyond an extreme root converges to it monotonically and cubically:

- `smallest_eigenpair` and `extreme_eigenvalues` expand det(W - λ) of a 4 x 4 matrix of 2 x 2 blocks, and take the
  eigenvector from the adjugate of a Schur complement.
- `tail_eigenvalue_sum` makes the matrices tridiagonal by Householder reflections. It finds their largest eigenvalues
  one after the other, each with the roots found before divided out (Maehly deflation).
- `inverse` inverts by blocks (Banachiewicz 1937).

References
----------
Wilkinson, The Algebraic Eigenvalue Problem, 1965, sections 5.6 and 7.9 to 7.13.
Golub and Van Loan, Matrix Computations, 4th ed. 2013, section 8.3.1.
"""

import numpy as np
from numpy.typing import NDArray

KEPT_BYTES = 24 << 20  # below glibc's largest mmap threshold, 32 MB
MAX_LAGUERRE_STEPS = 20  # the iteration stops by itself, after 3 or 4 steps in the shipped scenes
QUARTIC_TOL = 1e-6  # last step, relative to the trace of W: as convergence is cubic, the next would be rounding
MIN_QUARTIC_BATCH = 32  # up to as many matrices LAPACK is faster
MIN_SLOPE = 1e-10  # f' of a double root, relative to the trace³: steps stay short where f and f' are rounding errors
MIN_COFACTOR = 1e-5  # cofactors of f, relative to the trace³: below it LAPACK takes over; above it f errs by 1e-9
TAIL_TOL = 1e-9  # last step, relative to the matrix: as convergence is cubic, the next would be rounding
MIN_TAIL_BATCH = 600  # up to as many matrices LAPACK is faster
BOUND_MARGIN = 1e-13  # of the squared norm of a matrix: more than the rounding error of an upper bound
MIN_BOUND, MIN_GAP = 1e-12, 1e-4  # of that bound, and between two eigenvalues: below them LAPACK takes over


def keep_freed_memory() -> None:
    """Make glibc keep freed blocks for the next step of a long batch (mallopt(3), M_TRIM_THRESHOLD).

    Freeing one large block that was never touched raises the threshold. Otherwise the kernel pages the memory in again
    at each step, which takes a third of the time.
    """
    np.empty(KEPT_BYTES, np.uint8)


def inverse(S: NDArray[np.float64]) -> NDArray[np.float64]:
    """Invert symmetric positive-definite matrices: (n, n, ...) → (n, n, ...), not finite where S is singular."""
    inverted = np.empty_like(S)
    with np.errstate(invalid="ignore", divide="ignore"):
        _invert(S, inverted)
    return inverted


def _invert(S: NDArray, into: NDArray) -> None:
    """Write the inverse to `into`, (n, n, ...)."""
    n = len(S)
    if n == 1:
        np.divide(1, S, out=into)
        return
    if n == 2:
        scale = 1 / (S[0, 0] * S[1, 1] - S[0, 1] * S[0, 1])
        np.multiply(S[1, 1], scale, out=into[0, 0])
        np.multiply(S[0, 0], scale, out=into[1, 1])
        into[0, 1] = np.multiply(S[0, 1], -scale, out=into[1, 0])
        return
    k = n // 2
    off, upper, lower, right = S[:k, k:], into[:k, :k], into[k:, k:], into[:k, k:]
    _invert(S[:k, :k], upper)
    product = np.einsum("ij...,jk...->ik...", upper, off)
    _invert(S[k:, k:] - np.einsum("ji...,jk...->ik...", off, product), lower)  # of the Schur complement
    coupling = np.einsum("ij...,jk...->ik...", product, lower)
    upper += np.einsum("ij...,kj...->ik...", coupling, product)
    np.negative(coupling, out=right)
    into[k:, :k] = right.swapaxes(0, 1)


def tail_eigenvalue_sum(S: NDArray[np.float64], rank: int) -> NDArray[np.float64]:
    """Sum all eigenvalues except the `rank` largest: the squared distance to the nearest matrices of that rank.

    S: (n, n, G), positive semi-definite → (G,). The sum is the trace minus the largest eigenvalues.
    """
    if S.shape[2] <= MIN_TAIL_BATCH:
        return _tail_by_lapack(S, rank)
    size = np.sqrt(np.einsum("ijg,ijg->g", S, S))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        largest, failed = _largest_eigenvalues(*_tridiagonal(S / size), rank)
    tail = np.einsum("iig->g", S) - size * largest.sum(0)
    if failed.any():
        tail[failed] = _tail_by_lapack(S[:, :, failed], rank)
    return tail


def _largest_eigenvalues(diagonal: NDArray, squares: NDArray, count: int) -> tuple[NDArray, NDArray]:
    """Largest eigenvalues (count, G) of tridiagonal matrices T of norm 1, and where the iteration failed, (G,) bool."""
    found = np.empty((count,) + diagonal.shape[1:])
    failed = np.zeros(diagonal.shape[1:], bool)
    bound = np.ones(diagonal.shape[1:])  # Σ λ² of the eigenvalues not found yet bounds the next one
    for k in range(count):
        failed |= ~(bound > MIN_BOUND)
        x, degree = np.sqrt(np.maximum(bound, 0) + BOUND_MARGIN), len(diagonal) - k
        for _ in range(MAX_LAGUERRE_STEPS):
            value, slope, half_curve = _characteristic_at(x, diagonal, squares)
            G = slope / value
            H = G * G - 2 * half_curve / value
            for reciprocal in 1 / (x - found[:k]):
                G -= reciprocal
                H -= reciprocal * reciprocal
            root = np.sqrt(np.maximum((degree - 1) * (degree * H - G * G), 0))
            step = degree / (G + np.copysign(root, G))  # upwards, if rounding has led below the root
            x -= step
            if np.nanmax(np.abs(step), initial=0) <= TAIL_TOL:
                break
        failed |= ~(np.abs(step) <= TAIL_TOL) | (np.abs(found[:k] - x) < MIN_GAP).any(0)
        found[k] = x
        bound -= x * x
    return found, failed


def _characteristic_at(x: NDArray, diagonal: NDArray, squares: NDArray) -> NDArray:
    """f, f', f''/2 at x, (G,), of f = det(x - T), by the three-term recurrence of its leading minors: (3, G)."""
    before, now = np.zeros((2, 3) + x.shape)
    before[0] = now[1] = 1.0
    np.subtract(x, diagonal[0], out=now[0])
    for own, squared in zip(diagonal[1:], squares):
        after = (x - own) * now
        after -= squared * before
        after[1:] += now[:2]
        before, now = now, after
    return now


def _tridiagonal(A: NDArray) -> tuple[NDArray, NDArray]:
    """Diagonal (n, G) and squared off-diagonal (n - 1, G) of tridiagonal matrices similar to A, (n, n, G); spoils A."""
    n = len(A)
    squares = np.empty((n - 1,) + A.shape[2:])
    for k in range(n - 2):
        v, rest = A[k + 1 :, k], A[k + 1 :, k + 1 :]
        squares[k] = np.einsum("ig,ig->g", v, v)
        length = np.sqrt(squares[k])
        scale = squares[k] + np.abs(v[0]) * length
        scale[scale == 0] = 1.0  # a zero column needs no reflection
        v[0] += np.copysign(length, v[0])
        p = np.einsum("ijg,jg->ig", rest, v)
        p /= scale
        p -= np.einsum("ig,ig->g", v, p) / (2 * scale) * v
        outer = np.einsum("ig,jg->ijg", v, p)
        rest -= outer
        rest -= outer.swapaxes(0, 1)
    squares[-1] = A[-1, -2] ** 2
    return np.einsum("iig->ig", A), squares


def _tail_by_lapack(S: NDArray, rank: int) -> NDArray:
    return np.linalg.eigvalsh(S.transpose(2, 0, 1))[:, :-rank].sum(1)


def smallest_eigenpair(
    P: NDArray[np.float64], M: NDArray[np.float64], Q: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smallest eigenvalue λ and unit eigenvector f of W = [[P, M], [Mᵀ, Q]], positive semi-definite.

    Parameters
    ----------
    P, M, Q : (2, 2, ...) array
        Blocks of the matrices.

    Returns
    -------
    λ : (...) array
    f : (4, ...) array
        With arbitrary sign.

    Notes
    -----
    λ is a root of the characteristic polynomial. With f = [x; y], the lower half of (W - λ) f = 0 gives
    y = -(Q - λ)⁻¹ Mᵀ x. So x is in the kernel of the Schur complement S = P - λ - M (Q - λ)⁻¹ Mᵀ, and follows from its
    adjugate. That vanishes where the smallest two eigenvalues nearly coincide, or x = 0: these few go to LAPACK.
    """
    if M[0, 0].size <= MIN_QUARTIC_BATCH:
        return _smallest_by_lapack(P, M, Q)
    s3, s2, s1, s0, M_adj_Q = _quartic_coefficients(P, M, Q)
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
    weak = ~(size > MIN_COFACTOR * s3 * s3 * s3)
    if weak.any():
        smallest[weak], f[:, weak] = _smallest_by_lapack(*(block[:, :, weak] for block in (P, M, Q)))
    return smallest, f


def extreme_eigenvalues(
    P: NDArray[np.float64], M: NDArray[np.float64], Q: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Smallest and largest eigenvalue, (...) each, of positive semi-definite [[P, M], [Mᵀ, Q]], blocks (2, 2, ...)."""
    if M[0, 0].size <= MIN_QUARTIC_BATCH:
        values = np.linalg.eigvalsh(_joined(P, M, Q))
        return values[..., 0], values[..., 3]
    s3, s2, s1, s0, _ = _quartic_coefficients(P, M, Q)
    # λ → s3 - λ mirrors the polynomial, so that the largest root becomes the smallest of another one
    squared = s3 * s3
    mirrored = 3 * s3, 3 * squared + s2, squared * s3 + 2 * s2 * s3 - s1, s2 * squared - s1 * s3 + s0
    return _smallest_root(s3, s2, s1, s0), s3 - _smallest_root(*mirrored)


def _quartic_coefficients(P: NDArray, M: NDArray, Q: NDArray) -> tuple[NDArray, NDArray, NDArray, NDArray, NDArray]:
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
    """Laguerre's iteration from 0, which is monotone as all four roots are real and not negative."""
    value, slope, half_curve = s0, -s1, s2  # f, f', f''/2 at 0
    tolerance = QUARTIC_TOL * s3.min(initial=np.inf)
    floor = MIN_SLOPE * s3 * s3 * s3  # of the denominator
    floor *= floor
    root = np.zeros_like(s0)
    for _ in range(MAX_LAGUERRE_STEPS):
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
        b3 = root - s3  # the remainders of repeated division by (λ - root) are f, f', f''/2
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


def _smallest_by_lapack(P: NDArray, M: NDArray, Q: NDArray) -> tuple[NDArray, NDArray]:
    """As `smallest_eigenpair`."""
    values, vectors = np.linalg.eigh(_joined(P, M, Q))
    smallest = vectors[..., 0]
    return values[..., 0], smallest.transpose(smallest.ndim - 1, *range(smallest.ndim - 1))


def _joined(P: NDArray, M: NDArray, Q: NDArray) -> NDArray:
    """W, (..., 4, 4), of its blocks (2, 2, ...)."""
    W = np.empty((4, 4) + M.shape[2:])
    W[:2, :2], W[:2, 2:], W[2:, :2], W[2:, 2:] = P, M, M.swapaxes(0, 1), Q
    return W.transpose(*range(2, W.ndim), 0, 1)  # faster than np.moveaxis, which takes most of the time for one posture
