"""What many small symmetric matrices have beyond a rank, at once: component axes first and the batch (G) last.

It is the trace without the largest eigenvalues. Householder's reflections (1958) make the matrices tridiagonal, T; each
of those eigenvalues is found by Laguerre's iteration from above on det(x - T), divided by x less those found before. It
is monotone, as all roots are real.
"""

import numpy as np
from numpy.typing import NDArray

STEPS = 20  # a bound: the iteration stops by itself, after 3 or 4 steps in the shipped scenes
CONVERGED = 1e-9  # last step, relative to the matrix; the steps shrink cubically, and the next would be rounding
ABOVE = 1e-13  # of the square of a matrix: more than what rounding takes off a bound
LEFT, APART = 1e-12, 1e-4  # least of such a bound, and between two eigenvalues: below, LAPACK takes over
FEW = 600  # matrices that LAPACK solves sooner, one by one, than array operations all at once


def beyond_rank(S: NDArray, rank: int) -> NDArray:
    """The sum of all eigenvalues but the `rank` largest. S: (n, n, G), positive semi-definite → (G,)."""
    if S.shape[2] <= FEW:
        return _by_lapack(S, rank)
    size = np.sqrt(np.einsum("ijg,ijg->g", S, S))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        largest, unsure = _from_above(*_tridiagonal(S / size), rank)
    left = np.einsum("iig->g", S) - size * largest.sum(0)
    if unsure.any():
        left[unsure] = _by_lapack(S[:, :, unsure], rank)
    return left


def _from_above(diagonal: NDArray, beside: NDArray, count: int) -> tuple[NDArray, NDArray]:
    """The largest eigenvalues of T, (count, G), and where they are not found for sure, (G,) bool. The squares of all
    elements of T sum to 1."""
    found = np.empty((count,) + diagonal.shape[1:])
    unsure = np.zeros(diagonal.shape[1:], bool)
    left = np.ones(diagonal.shape[1:])  # Σ λ² of those to be found: a bound for the next
    for k in range(count):
        unsure |= ~(left > LEFT)
        x, degree = np.sqrt(np.maximum(left, 0) + ABOVE), len(diagonal) - k
        for _ in range(STEPS):
            value, slope, half_curve = _characteristic(x, diagonal, beside)
            G = slope / value
            H = G * G - 2 * half_curve / value
            for before in 1 / (x - found[:k]):
                G -= before
                H -= before * before
            root = np.sqrt(np.maximum((degree - 1) * (degree * H - G * G), 0))
            step = degree / (G + np.copysign(root, G))  # back up, should rounding have led below
            x -= step
            if np.nanmax(np.abs(step), initial=0) <= CONVERGED:
                break
        unsure |= ~(np.abs(step) <= CONVERGED) | (np.abs(found[:k] - x) < APART).any(0)
        found[k] = x
        left -= x * x
    return found, unsure


def _characteristic(x: NDArray, diagonal: NDArray, beside: NDArray) -> NDArray:
    """f, f', f''/2 at x, (G,), of f = det(x - T): (3, G)."""
    before, now = np.zeros((2, 3) + x.shape)
    before[0] = now[1] = 1.0
    np.subtract(x, diagonal[0], out=now[0])
    for own, squared in zip(diagonal[1:], beside):
        after = (x - own) * now
        after -= squared * before
        after[1:] += now[:2]
        before, now = now, after
    return now


def _tridiagonal(A: NDArray) -> tuple[NDArray, NDArray]:
    """The diagonal (n, G) of T, and the squares (n - 1, G) of what stands beside it. A: (n, n, G), overwritten."""
    n = len(A)
    beside = np.empty((n - 1,) + A.shape[2:])
    for k in range(n - 2):
        v, rest = A[k + 1 :, k], A[k + 1 :, k + 1 :]
        beside[k] = np.einsum("ig,ig->g", v, v)
        length = np.sqrt(beside[k])
        scale = beside[k] + np.abs(v[0]) * length
        scale[scale == 0] = 1.0  # nothing is to be reflected
        v[0] += np.copysign(length, v[0])
        p = np.einsum("ijg,jg->ig", rest, v)
        p /= scale
        p -= np.einsum("ig,ig->g", v, p) / (2 * scale) * v
        outer = np.einsum("ig,jg->ijg", v, p)
        rest -= outer
        rest -= outer.swapaxes(0, 1)
    beside[-1] = A[-1, -2] ** 2
    return np.einsum("iig->ig", A), beside


def _by_lapack(S: NDArray, rank: int) -> NDArray:
    return np.linalg.eigvalsh(S.transpose(2, 0, 1))[:, :-rank].sum(1)
