"""Projective combination of views: each of the learner's images is a projective function of the demonstrator's shape.

ŷ_i = (a_0 + Aᵀu_i) / ρ_i, ρ_i = 1 + p·u_i, where u_i are the affine coordinates of point i in [l r] and p ∈ R³
is shared by [L] and [R]. With parallel optical axes both images have one depth, and this is exact: no bias. a_0 and A
are linear given p; p comes from a few Gauss-Newton steps of variable projection (Golub & Pereyra 1973, with Kaufman's
Jacobian), held near 0, the affine camera, by a weak prior that
scales with the images.

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

STEPS = 3
PRIOR = 3e-4  # weight of |p|² beside the squared residuals, relative to the mean square of the centred own points
LARGEST_P, NEAREST = 0.6, 0.15  # bounds of |p| and of ρ: no point is at infinity or behind the camera
FEW = 500  # points in all postures, up to which LAPACK, one by one, is sooner than array operations all at once
LEAST_SQUARE = 1e-12  # px²: of own points that are all in one place
UNIT = np.eye(3)
OF_OWN, OF_U = np.repeat(range(4), 3), np.tile(range(1, 4), 4)  # k and j of all products of an own coordinate and a u
UPPER = np.triu_indices(4)
SYMMETRIC = np.zeros((4, 4), int)  # where of the products of h that of a and b is
SYMMETRIC[UPPER] = SYMMETRIC[UPPER[::-1]] = np.arange(10)


@dataclass(frozen=True)
class ProjectiveTransfer(Transfer):
    """basis: (4, 3) or (..., 4, 3), from centred [l; r] px to u; coefficients: (..., 4, 4) px, of h for each own
    coordinate; p: (..., 3); flat: σ1/σ3 of the centred [l r]."""

    basis: NDArray
    coefficients: NDArray
    p: NDArray
    demo_mean: NDArray
    own_mean: NDArray
    flat: NDArray

    @cached_property
    def condition(self) -> NDArray:
        """σ1/σ3 of the centred [l r]: inf for coplanar points."""
        return np.broadcast_to(self.flat, self.p.shape[:-1])

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray:
        return self._recover(np.concatenate([demo_left, demo_right], -1))

    def residual(self, views: FourViews) -> NDArray:
        return views.own - self._recover(views.demo)

    def _recover(self, demo: NDArray) -> NDArray:
        """(..., M, 4) px in [l, r] → (..., M, 4) px in [L, R]."""
        u = (demo - self.demo_mean[..., None, :]) @ self.basis
        if u.ndim == 2 and len(u) * self.p[..., 0].size > FEW:
            return self._recover_in_many(u)
        depth = np.maximum(1 + u @ self.p[..., None], NEAREST)
        shape = self.coefficients[..., :1, :] + u @ self.coefficients[..., 1:, :]
        return self.own_mean[..., None, :] + shape / depth

    def _recover_in_many(self, u: NDArray) -> NDArray:
        """Of the same points in many postures: these last in memory, as `fit` left them. u: (M, 3) → (..., M, 4) px."""
        depth = np.maximum(1 + u @ self.p.reshape(-1, 3).T, NEAREST)
        h = np.concatenate([np.ones((len(u), 1)), u], 1)
        recovered = _product(h, self.coefficients.reshape(-1, 4, 4).transpose(1, 2, 0))
        recovered /= depth[:, None]
        recovered += self.own_mean.reshape(-1, 4).T
        return recovered.transpose(2, 0, 1).reshape(*self.p.shape[:-1], len(u), 4)


def fit(views: FourViews) -> ProjectiveTransfer:
    """For N ≥ 5 points. `condition` is σ1/σ3 of the centred [l r]."""
    count = views.own.shape[-2]
    require_points(count)
    body = _body_of(views.demo) if views.demo.ndim > 2 else _body(np.ascontiguousarray(views.demo, float).tobytes())
    own_mean, own = centred(views.own)
    batch = own.shape[:-2]
    own = own.reshape(-1, count, 4)
    if own.size <= 4 * FEW:
        p, coefficients = _fit_few(body.h.T, own)
    else:
        p, coefficients = _fit(body, np.ascontiguousarray(own.transpose(1, 2, 0)))
    return ProjectiveTransfer(
        body.basis, coefficients.reshape(batch + (4, 4)), p.reshape(batch + (3,)), body.mean, own_mean, body.flat
    )


class Body(NamedTuple):
    """What follows from the demonstrator's images alone, which are one, or one for each of the batch.

    h: (4, N) or (4, N, G); products: of two of h, 10 of them; mean: (..., 4) px; basis, flat: as the transfer's.
    """

    h: NDArray
    products: NDArray
    mean: NDArray
    basis: NDArray
    flat: NDArray


@lru_cache(16)  # a demonstrator stands still while postures are compared
def _body(demo: bytes) -> Body:
    return _body_of(np.frombuffer(demo).reshape(-1, 4))


def _body_of(demo: NDArray) -> Body:
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
    return Body(h, h[UPPER[0]] * h[UPPER[1]], mean, basis, flat)


def _fit_few(h: NDArray, Y: NDArray) -> tuple[NDArray, NDArray]:
    """As a long batch is fitted; LAPACK and few calls of numpy serve a short one, or one posture, sooner: p (G, 3),
    coefficients (G, 4, 4).

    h: (N, 4) or (G, N, 4), Y: (G, N, 4) px, centred. With H = h/ρ and Ŷ its combination that is nearest to Y, the
    Jacobian is what H cannot make of -A, A = [Ŷ u_j/ρ].
    """
    count = Y.shape[1]
    flat = Y.reshape(-1, 4 * count, 1)
    prior = PRIOR / count * np.maximum(flat.swapaxes(1, 2) @ flat, LEAST_SQUARE)
    held = prior * UNIT
    u, p = h[..., 1:], np.zeros((len(Y), 3, 1))
    H, inverted = h, h.swapaxes(-1, -2) / count  # where p = 0 the columns of H are orthogonal, of length √N
    for _ in range(STEPS):
        found = H @ (inverted @ Y)
        A = found.take(OF_OWN, -1) * H.take(OF_U, -1)  # a product of small axes takes numpy twice as long
        left = (A - H @ (inverted @ A)).reshape(-1, 4 * count, 3)
        A = A.reshape(left.shape).swapaxes(1, 2)
        p = p - np.linalg.solve(A @ left + held, A @ (Y - found).reshape(flat.shape) + prior * p)
        p *= LARGEST_P / np.maximum(np.sqrt(p.swapaxes(1, 2) @ p), LARGEST_P)
        H = h / np.maximum(1 + u @ p, NEAREST)
        transposed = H.swapaxes(1, 2)
        inverted = np.linalg.inv(transposed @ H) @ transposed
    return p[..., 0], inverted @ Y


def _fit(body: Body, Y: NDArray) -> tuple[NDArray, NDArray]:
    """p: (G, 3) and coefficients: (G, 4, 4). Y: (N, 4, G) px, centred."""
    keep_freed_memory()
    prior = PRIOR / len(Y) * np.einsum("nkg,nkg->g", Y, Y)
    p, w, inverted = np.zeros((3, 1)), np.ones((len(Y), 1)), np.array(1 / len(Y))
    for _ in range(STEPS):
        p = _step(body, Y, p, w, inverted, prior)
        w = 1 / np.maximum(1 + _product(body.h[1:].swapaxes(0, 1), p), NEAREST)
        inverted = inverse(_product(body.products, w * w)[SYMMETRIC])
    return p.T, _coefficients(body, Y, w, inverted).transpose(2, 0, 1)


def _coefficients(body: Body, Y: NDArray, w: NDArray, inverted: NDArray) -> NDArray:
    """(4, 4, G) px, of h for each own coordinate, by least squares."""
    return _solved(inverted, _product(body.h, w[:, None] * Y))


def _solved(inverted: NDArray, right: NDArray) -> NDArray:
    """inverted: (4, 4, G), or () where it is so many times the identity, right: (4, ..., G) → (4, ..., G)"""
    return inverted * right if inverted.ndim == 0 else np.einsum("abg,b...g->a...g", inverted, right)


def _step(body: Body, Y: NDArray, p: NDArray, w: NDArray, inverted: NDArray, prior: NDArray) -> NDArray:
    """One Gauss-Newton step of p: (3, G). w: 1/ρ, (N, G); inverted: Σ w² h hᵀ, as `_solved` takes it; prior: (G,)
    px²."""
    shape = _product(body.h.swapaxes(0, 1), _coefficients(body, Y, w, inverted))  # (N, 4, G), of which Ŷ is w times
    size = w * np.einsum("nkg,nkg->ng", shape, shape)
    squared = w * w
    cubed = squared * w
    weighted = np.empty((len(Y), 6, Y.shape[2]))
    np.multiply(cubed[:, None], shape, out=weighted[:, :4])
    np.multiply(cubed, size, out=weighted[:, 4])
    np.multiply(squared, np.einsum("nkg,nkg->ng", shape, Y) - size, out=weighted[:, 5])  # ŷ·e/ρ
    sums = _product(body.products, weighted)  # (10, 6, G)
    # what of Ŷ's derivative the coefficients take over by themselves
    along = sums[SYMMETRIC[:, 1:], :4]  # h, u, k
    normal = sums[SYMMETRIC[1:, 1:], 4] - np.einsum("ajkg,aikg->ijg", _solved(inverted, along), along)
    diagonal = np.einsum("iig->ig", normal)
    diagonal += prior
    p = p - np.einsum("ijg,jg->ig", inverse(normal), sums[1:4, 5] + prior * p)
    return p * (LARGEST_P / np.maximum(np.sqrt(np.einsum("ig,ig->g", p, p)), LARGEST_P))


def _product(a: NDArray, b: NDArray) -> NDArray:
    """Σ_n a_in b_n. a: (i, n) or (i, n, G), b: (n, ..., G) → (i, ..., G)."""
    if a.ndim == 2:
        return (a @ b.reshape(len(b), -1)).reshape(len(a), *b.shape[1:])
    return np.einsum("ing,n...g->i...g", a, b)
