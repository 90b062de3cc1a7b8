"""Projective combination of views: each of the learner's images is a projective function of the demonstrator's shape.

ŷ_i = (a_0 + Aᵀu_i) / ρ_i, ρ_i = 1 + p·u_i, where u_i are the affine coordinates of point i in [l r] and p ∈ R³
is shared by [L] and [R]. With parallel optical axes both images have one depth, and this is exact: no bias. Given p,
a_0 and A are linear. p comes from a few Gauss-Newton steps of variable projection (Golub & Pereyra 1973, with Kaufman's
Jacobian). A weak prior, which scales with the images, holds p near 0, the affine camera.

Component axes come first here, the batch (G) last. h = [1; u] is one of 4, n a point, k one of 4 own coordinates.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...geometry.affine import centred, components_first, require_points
from ...geometry.small_matrices import inverse, keep_freed_memory
from ..views import FourViews
from .transfer import Transfer

GAUSS_NEWTON_STEPS = 3
PRIOR = 3e-4  # weight of |p|² beside the squared residuals, relative to the mean square of the centred own points
MAX_P, MIN_DEPTH = 0.6, 0.15  # bounds of |p| and of ρ: no point is at infinity or behind the camera
MAX_POINTS_LAPACK = 500  # points in all postures, up to which LAPACK calls are faster than array operations
MIN_SQUARE_PX2 = 1e-12  # lower bound of the square, for own points that are all in one place
UNIT = np.eye(3)
OF_OWN, OF_U = np.repeat(range(4), 3), np.tile(range(1, 4), 4)  # k and j of all products of an own coordinate and a u
UPPER = np.triu_indices(4)
SYMMETRIC = np.zeros((4, 4), int)  # index of the product h_a h_b among the ten different ones
SYMMETRIC[UPPER] = SYMMETRIC[UPPER[::-1]] = np.arange(10)


@dataclass(frozen=True)
class ProjectiveTransfer(Transfer):
    """A projective combination of views."""

    basis: NDArray[np.float64]  # (4, 3) or (..., 4, 3), from centred [l; r] px to u
    coefficients: NDArray[np.float64]  # (..., 4, 4) px, of h for each own coordinate
    p: NDArray[np.float64]  # (..., 3)
    demo_mean: NDArray[np.float64]  # (..., 4) px
    own_mean: NDArray[np.float64]  # (..., 4) px
    flat: NDArray[np.float64]  # (...) σ1/σ3 of the centred [l r]

    @cached_property
    def condition(self) -> NDArray[np.float64]:
        """σ1/σ3 of the centred [l r]: inf for coplanar points."""
        return np.broadcast_to(self.flat, self.p.shape[:-1])

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray[np.float64]:
        return self._recover(np.concatenate([demo_left, demo_right], -1))

    def residual(self, views: FourViews) -> NDArray[np.float64]:
        return views.own - self._recover(views.demo)

    def _recover(self, demo: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., M, 4) px in [l, r] → (..., M, 4) px in [L, R]."""
        u = (demo - self.demo_mean[..., None, :]) @ self.basis
        if u.ndim == 2 and len(u) * self.p[..., 0].size > MAX_POINTS_LAPACK:
            return self._recover_in_many(u)
        depth = np.maximum(1 + u @ self.p[..., None], MIN_DEPTH)
        shape = self.coefficients[..., :1, :] + u @ self.coefficients[..., 1:, :]
        return self.own_mean[..., None, :] + shape / depth

    def _recover_in_many(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        """Recover the same points in many postures, the batch last in memory: (M, 3) → (..., M, 4) px."""
        depth = np.maximum(1 + u @ self.p.reshape(-1, 3).T, MIN_DEPTH)
        h = np.concatenate([np.ones((len(u), 1)), u], 1)
        recovered = _product(h, self.coefficients.reshape(-1, 4, 4).transpose(1, 2, 0))
        recovered /= depth[:, None]
        recovered += self.own_mean.reshape(-1, 4).T
        return recovered.transpose(2, 0, 1).reshape(*self.p.shape[:-1], len(u), 4)


def fit(views: FourViews) -> ProjectiveTransfer:
    """Fit N ≥ 5 points. The condition is σ1/σ3 of the centred [l r]."""
    count = views.own.shape[-2]
    require_points(count)
    body = _body_of(views.demo) if views.demo.ndim > 2 else _body(np.ascontiguousarray(views.demo, float).tobytes())
    own_mean, own = centred(views.own)
    batch = own.shape[:-2]
    own = own.reshape(-1, count, 4)
    if own.size <= 4 * MAX_POINTS_LAPACK:
        p, coefficients = _fit_few(body.h.T, own)
    else:
        p, coefficients = _fit(body, np.ascontiguousarray(own.transpose(1, 2, 0)))
    return ProjectiveTransfer(
        body.basis, coefficients.reshape(batch + (4, 4)), p.reshape(batch + (3,)), body.mean, own_mean, body.flat
    )


class _Body(NamedTuple):
    """Affine coordinates of the demonstrator's points, of one posture or of each of a batch."""

    h: NDArray[np.float64]  # (4, N) or (4, N, G)
    products: NDArray[np.float64]  # (10, N) or (10, N, G), of two of h
    mean: NDArray[np.float64]  # (..., 4) px
    basis: NDArray[np.float64]  # as the transfer's
    flat: NDArray[np.float64]  # as the transfer's


@lru_cache(16)  # a demonstrator stands still while postures are compared
def _body(demo: bytes) -> _Body:
    return _body_of(np.frombuffer(demo).reshape(-1, 4))


def _body_of(demo: NDArray[np.float64]) -> _Body:
    """demo: (N, 4) or (..., N, 4) px"""
    count = demo.shape[-2]
    mean, demo = centred(demo)
    U, sigma, Vt = np.linalg.svd(demo, full_matrices=False)
    scale = np.sqrt(count)
    h = np.concatenate([np.ones(U.shape[:-1] + (1,)), scale * U[..., :3]], -1)
    h = components_first(h) if demo.ndim > 2 else np.ascontiguousarray(h.T)
    with np.errstate(divide="ignore", invalid="ignore"):
        known = sigma[..., :3] > sigma[..., :1] * np.finfo(float).eps * count
        basis = np.swapaxes(Vt[..., :3, :], -1, -2) * np.where(known, scale / sigma[..., :3], 0.0)[..., None, :]
        flat = np.where(known[..., 2], sigma[..., 0] / sigma[..., 2], np.inf)
    return _Body(h, h[UPPER[0]] * h[UPPER[1]], mean, basis, flat)


def _fit_few(h: NDArray[np.float64], Y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit a short batch as `_fit` does a long one, with LAPACK: p (G, 3), coefficients (G, 4, 4).

    h: (N, 4) or (G, N, 4), Y: (G, N, 4) px, centred. H = h/ρ, and Ŷ is its combination nearest to Y. The Jacobian is
    the part of -A = -[Ŷ u_j/ρ] that is orthogonal to H.
    """
    count = Y.shape[1]
    flat = Y.reshape(-1, 4 * count, 1)
    prior = PRIOR / count * np.maximum(flat.swapaxes(1, 2) @ flat, MIN_SQUARE_PX2)
    held = prior * UNIT
    u, p = h[..., 1:], np.zeros((len(Y), 3, 1))
    H, inverted = h, h.swapaxes(-1, -2) / count  # where p = 0 the columns of H are orthogonal, of length √N
    for _ in range(GAUSS_NEWTON_STEPS):
        found = H @ (inverted @ Y)
        A = found.take(OF_OWN, -1) * H.take(OF_U, -1)  # faster than a product over small axes
        left = (A - H @ (inverted @ A)).reshape(-1, 4 * count, 3)
        A = A.reshape(left.shape).swapaxes(1, 2)
        p = p - np.linalg.solve(A @ left + held, A @ (Y - found).reshape(flat.shape) + prior * p)
        p *= MAX_P / np.maximum(np.sqrt(p.swapaxes(1, 2) @ p), MAX_P)
        H = h / np.maximum(1 + u @ p, MIN_DEPTH)
        transposed = H.swapaxes(1, 2)
        inverted = np.linalg.inv(transposed @ H) @ transposed
    return p[..., 0], inverted @ Y


def _fit(body: _Body, Y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Fit p (G, 3) and coefficients (G, 4, 4) to Y (N, 4, G) px, centred."""
    keep_freed_memory()
    prior = PRIOR / len(Y) * np.einsum("nkg,nkg->g", Y, Y)
    p, w, inverted = np.zeros((3, 1)), np.ones((len(Y), 1)), np.array(1 / len(Y))
    for _ in range(GAUSS_NEWTON_STEPS):
        p = _step(body, Y, p, w, inverted, prior)
        w = 1 / np.maximum(1 + _product(body.h[1:].swapaxes(0, 1), p), MIN_DEPTH)
        inverted = inverse(_product(body.products, w * w)[SYMMETRIC])
    return p.T, _coefficients(body, Y, w, inverted).transpose(2, 0, 1)


def _coefficients(
    body: _Body, Y: NDArray[np.float64], w: NDArray[np.float64], inverted: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Solve for the coefficients of h for each own coordinate, (4, 4, G) px, by least squares."""
    return _solved(inverted, _product(body.h, w[:, None] * Y))


def _solved(inverted: NDArray[np.float64], right: NDArray[np.float64]) -> NDArray[np.float64]:
    """inverted: (4, 4, G), or () for a multiple of the identity; right: (4, ..., G) → (4, ..., G)."""
    return inverted * right if inverted.ndim == 0 else np.einsum("abg,b...g->a...g", inverted, right)


def _step(
    body: _Body,
    Y: NDArray[np.float64],
    p: NDArray[np.float64],
    w: NDArray[np.float64],
    inverted: NDArray[np.float64],
    prior: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Take one Gauss-Newton step of p, (3, G). w: 1/ρ, (N, G); inverted: inverse of Σ w² h hᵀ; prior: (G,) px²."""
    shape = _product(body.h.swapaxes(0, 1), _coefficients(body, Y, w, inverted))  # (N, 4, G), of which Ŷ is w times
    size = w * np.einsum("nkg,nkg->ng", shape, shape)
    squared = w * w
    cubed = squared * w
    weighted = np.empty((len(Y), 6, Y.shape[2]))
    np.multiply(cubed[:, None], shape, out=weighted[:, :4])
    np.multiply(cubed, size, out=weighted[:, 4])
    np.multiply(squared, np.einsum("nkg,nkg->ng", shape, Y) - size, out=weighted[:, 5])  # ŷ·e/ρ
    sums = _product(body.products, weighted)  # (10, 6, G)
    # Kaufman: the part of Ŷ's derivative that the coefficients absorb
    along = sums[SYMMETRIC[:, 1:], :4]  # h, u, k
    normal = sums[SYMMETRIC[1:, 1:], 4] - np.einsum("ajkg,aikg->ijg", _solved(inverted, along), along)
    diagonal = np.einsum("iig->ig", normal)
    diagonal += prior
    p = p - np.einsum("ijg,jg->ig", inverse(normal), sums[1:4, 5] + prior * p)
    return p * (MAX_P / np.maximum(np.sqrt(np.einsum("ig,ig->g", p, p)), MAX_P))


def _product(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Σ_n a_in b_n. a: (i, n) or (i, n, G), b: (n, ..., G) → (i, ..., G)."""
    if a.ndim == 2:
        return (a @ b.reshape(len(b), -1)).reshape(len(a), *b.shape[1:])
    return np.einsum("ing,n...g->i...g", a, b)
