"""The paper's transfer, Section 2.3: the cross-section of epipolar lines.

Five affine epipolar constraints, of the pairs (l,L), (r,L), (l,R), (r,R), (L,R), make A u = -B c, Eq. (4),
solved by least squares: u = -(AᵀA)⁻¹AᵀB c. Two misprints of the paper: Eq. (5) drops that minus, and in the last
row of A the coefficients of L are f13, f23 and those of R are f31, f32, printed the other way round.

Points are centred first, which empties all f33. The first four constraints are then two 2 x 2 systems,
solved exactly; the fifth enters as a rank-one correction of least squares.

Component axes come first here, the batch (G) last. o is one of [L, R] and k its coordinate, d one of [l, r]
and j its coordinate.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...geometry.affine import DEMO_PAIR, PAIR_COORDINATES, centred, cross_scatter, pair_fundamentals, require_points
from ...geometry.small_matrices import extreme_eigenvalues, smallest_eigenpair
from ..views import FourViews
from .linear import AffineTransfer

CROSSED = np.delete(PAIR_COORDINATES, DEMO_PAIR, 0)  # of the five pairs
SINGULAR = 1e-3  # determinant of two unit-norm epipolar lines below which all five are solved together


@dataclass(frozen=True)
class EpipolarTransfer(AffineTransfer):
    """The paper's transfer, fitted."""

    f: NDArray[np.float64]  # (4, 5, ...): f13, f23, f31, f32 of the pairs (l,L), (r,L), (l,R), (r,R), (L,R), centred

    @property
    def fundamentals(self) -> NDArray[np.float64] | None:
        return self.f.T if self.f.ndim == 2 else None

    @cached_property
    def condition(self) -> NDArray[np.float64]:
        """cond(A): (...), inf where it is singular."""
        return condition(self.f.reshape(4, 5, -1)).reshape(self.matrix.shape[:-2])


def fit(views: FourViews) -> EpipolarTransfer:
    """Fit Eqs. (2)-(4) to N ≥ 5 points. The condition is cond(A)."""
    require_points(views.own.shape[-2])
    demo_mean, demo = centred(views.demo)
    own_mean, own = centred(views.own)
    batch = own.shape[:-2]
    f = constraints(demo, own)
    solved = solve(f).transpose(2, 0, 1).reshape(batch + (4, 4))
    return EpipolarTransfer(solved, demo_mean, own_mean, f.reshape((4, 5) + batch))


def constraints(demo: NDArray[np.float64], own: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fit the five fundamental matrices, (4, 5, G), to centred points demo (..., N, 4) or (N, 4), own (..., N, 4)."""
    if own.ndim == 2:  # for one posture, the cost is the number of calls
        return pair_fundamentals(np.concatenate([demo, own], 1), CROSSED).T[..., None]
    P, M, Q = (np.empty((2, 2, 5, math.prod(own.shape[:-2]))) for _ in range(3))
    to_P, to_M, to_Q = (block[:, :, :4].reshape(2, 2, 2, 2, -1) for block in (P, M, Q))  # views: i, j, o, d
    to_P[:] = np.einsum("didjg->ijdg", _by_view(cross_scatter(demo, demo)))[:, :, None]
    to_M[:] = _by_view(cross_scatter(demo, own)).transpose(1, 3, 2, 0, 4)
    S = _by_view(cross_scatter(own, own))
    to_Q[:] = np.einsum("oiojg->ijog", S)[:, :, :, None]
    P[:, :, 4], M[:, :, 4], Q[:, :, 4] = S[0, :, 0], S[0, :, 1], S[1, :, 1]
    return smallest_eigenpair(P, M, Q)[1]


def solve(f: NDArray[np.float64]) -> NDArray[np.float64]:
    """Solve Eq. (4) by least squares, as a map of centred points from [l; r] to [L; R]: (4, 5, G) → (4, 4, G)."""
    G = f.shape[2]
    of_demo = f[:2, :4].reshape(2, 2, 2, G).transpose(1, 2, 0, 3)  # o, d, j
    lines = f[2:, :4].reshape(2, 2, 2, G)  # k, o, d
    determinant = lines[0, :, 0] * lines[1, :, 1] - lines[1, :, 0] * lines[0, :, 1]  # o
    singular = (np.abs(determinant) < SINGULAR).any(0)
    determinant[:, singular] = 1.0
    inverse = np.empty((2, 2, 2, G))  # o, k, d: of the lines of [l] and [r], and negative
    np.negative(lines[1, :, 1], out=inverse[:, 0, 0])
    inverse[:, 0, 1] = lines[1, :, 0]
    inverse[:, 1, 0] = lines[0, :, 1]
    np.negative(lines[0, :, 0], out=inverse[:, 1, 1])
    inverse /= determinant[:, None, None]
    matrix = inverse[:, :, :, None] * of_demo[:, None]  # o, k, d, j: exact for the first four
    fifth = f[:, 4].reshape(2, 2, G)  # o, k
    leverage = np.einsum("okdg,okg->odg", inverse, fifth)
    gain = np.einsum("okdg,odg->okg", inverse, leverage)
    gain /= 1 + np.einsum("odg,odg->g", leverage, leverage)
    violated = np.einsum("okdjg,okg->djg", matrix, fifth)
    matrix -= gain[:, :, None, None] * violated
    matrix = matrix.reshape(4, 4, G)
    if singular.any():
        A, B = linear_system(f[:, :, singular])
        matrix[:, :, singular] = np.moveaxis(-np.linalg.pinv(A) @ B, 0, -1)
    return matrix


def linear_system(f: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Build A and B, (G, 5, 4) each, of Eq. (4) for centred points, from f (4, 5, G)."""
    A, B = np.zeros((2, f.shape[2], 5, 4))
    for row, (d, o) in enumerate(((0, 0), (1, 0), (0, 1), (1, 1))):
        A[:, row, 2 * o : 2 * o + 2] = f[2:, row].T
        B[:, row, 2 * d : 2 * d + 2] = f[:2, row].T
    A[:, 4] = f[:, 4].T
    return A, B


def condition(f: NDArray[np.float64]) -> NDArray[np.float64]:
    """Compute cond(A), (4, 5, G) → (G,): for one posture by singular values, for many by eigenvalues of AᵀA."""
    if f.shape[2] == 1:  # for one posture, the cost is the number of calls
        of_p, of_q, x, y = f[..., 0].tolist()
        own = [of_p[4], of_q[4], x[4], y[4]]
        A = [[x[0], y[0], 0, 0], [x[1], y[1], 0, 0], [0, 0, x[2], y[2]], [0, 0, x[3], y[3]], own]
        largest, *_, smallest = np.linalg.svd(A, compute_uv=False).tolist()
        return np.array([largest / smallest if smallest > 0 else np.inf])
    lines, fifth = f[2:, :4].reshape(2, 2, 2, -1), f[:, 4].reshape(2, 2, -1)
    blocks = np.einsum("iodg,jodg->oijg", lines, lines)
    blocks += fifth[:, :, None] * fifth[:, None]
    smallest, largest = extreme_eigenvalues(blocks[0], fifth[0, :, None] * fifth[1], blocks[1])
    with np.errstate(divide="ignore"):
        return np.sqrt(largest / np.maximum(smallest, 0.0))


def _by_view(S: NDArray[np.float64]) -> NDArray[np.float64]:
    """(4, 4, G) → (2 views, 2 coordinates, 2 views, 2 coordinates, G)"""
    return S.reshape((2, 2, 2, 2) + S.shape[2:])
