"""Projective combination of views: each of the learner's images is a projective function of the demonstrator's shape.

ŷ_i = (a_0 + Aᵀu_i) / ρ_i, ρ_i = 1 + p·u_i, where u_i are the affine coordinates of point i in [l r] and p ∈ R³
is shared by [L] and [R]. With parallel optical axes both images have one depth, and this is exact: no bias. a_0 and A
are linear given p; p comes from a few Gauss-Newton steps of variable projection (Golub & Pereyra 1973, with Kaufman's
Jacobian), held near 0, the affine camera, by a weak prior that
scales with the images.

Component axes come first here, the batch (G) last. h = [1; u] is one of 4, n a point, k one of 4 own coordinates.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..equations import HOLE, Equation, column, each, number
from ..geometry import cholesky
from ..geometry.affine import centred, components_first, require_points
from ..views import FourViews
from .transfer import Transfer, TransferMethod

STEPS = 3
PRIOR = 3e-4  # weight of |p|² beside the squared residuals, relative to the mean square of the centred own points
LARGEST_P, NEAREST = 0.6, 0.15  # bounds of |p| and of ρ: no point is at infinity or behind the camera
PAIRS = tuple(zip(*np.triu_indices(3)))


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
        u = (np.concatenate([demo_left, demo_right], -1) - self.demo_mean[..., None, :]) @ self.basis
        depth = np.maximum(1 + u @ self.p[..., None], NEAREST)
        shape = self.coefficients[..., :1, :] + u @ self.coefficients[..., 1:, :]
        return self.own_mean[..., None, :] + shape / depth


def fit(views: FourViews) -> ProjectiveTransfer:
    """For N ≥ 5 points. `condition` is σ1/σ3 of the centred [l r]."""
    count = views.own.shape[-2]
    require_points(count)
    demo_mean, demo = centred(views.demo)
    own_mean, own = centred(views.own)
    U, sigma, Vt = np.linalg.svd(demo, full_matrices=False)
    scale = np.sqrt(count)
    u = components_first(scale * U[..., :3])  # (3, N, 1 or G)
    h = np.concatenate([np.ones((1,) + u.shape[1:]), u])
    Y = components_first(own)
    prior = PRIOR / count * np.einsum("kng,kng->g", Y, Y)
    if Y.shape[2] == 1:
        p, coefficients = _fit_one(h[:, :, 0].T, Y[:, :, 0].T, prior[0])
    else:
        p = np.zeros((3, Y.shape[2]))
        for _ in range(STEPS):
            p = _step(h, Y, p, prior)
        coefficients = _linear(h, Y, p)[0]
    batch = own.shape[:-2]
    with np.errstate(divide="ignore", invalid="ignore"):
        known = sigma[..., :3] > sigma[..., :1] * np.finfo(float).eps * count
        basis = np.swapaxes(Vt[..., :3, :], -1, -2) * np.where(known, scale / sigma[..., :3], 0.0)[..., None, :]
        flat = np.where(known[..., 2], sigma[..., 0] / sigma[..., 2], np.inf)
    return ProjectiveTransfer(
        basis,
        coefficients.transpose(2, 0, 1).reshape(batch + (4, 4)),
        p.T.reshape(batch + (3,)),
        demo_mean,
        own_mean,
        flat,
    )


def _fit_one(h: NDArray, Y: NDArray, prior: float) -> tuple[NDArray, NDArray]:
    """As the batch is fitted, for a single posture in a sixth of its time: p (3, 1) and coefficients (4, 4, 1).

    h: (N, 4), Y: (N, 4) px. With H = h/ρ = QR and Ŷ = QQᵀY the Jacobian is (I - QQᵀ)[Ŷ u_j/ρ], whose normal matrix
    needs no projection of its own: AᵀA - (QᵀA)ᵀQᵀA.
    """
    u, p = h[:, 1:], np.zeros(3)
    for _ in range(STEPS):
        slope = u / np.maximum(1 + u @ p, NEAREST)[:, None]
        Q, _ = np.linalg.qr(_over_depth(h, p))
        found = Q @ (Q.T @ Y)
        A = found[:, :, None] * slope[:, None]
        inside = (Q.T @ A.reshape(-1, 12)).reshape(-1, 3)
        A = A.reshape(-1, 3)
        gradient = -slope.T @ (found * (Y - found)).sum(1) - prior * p
        p = p + np.linalg.solve(A.T @ A - inside.T @ inside + prior * np.eye(3), gradient)
        p *= min(1.0, LARGEST_P / max(float(np.sqrt(p @ p)), 1e-300))
    Q, R = np.linalg.qr(_over_depth(h, p))
    return p[:, None], np.linalg.solve(R, Q.T @ Y)[:, :, None]


def _over_depth(h: NDArray, p: NDArray) -> NDArray:
    """h/ρ: (N, 4). h: (N, 4), p: (3,)"""
    return h / np.maximum(1 + h[:, 1:] @ p, NEAREST)[:, None]


def _linear(h: NDArray, Y: NDArray, p: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """Coefficients (4, 4, G) of h for each coordinate, by least squares; L of HᵀH = L Lᵀ (4, 4, G); 1/ρ (N, G)."""
    w = 1 / np.maximum(1 + _product(h[1:].transpose(1, 0, 2), p), NEAREST)
    S = np.empty((4, 4, w.shape[1]))
    squared = w * w
    for a in range(4):
        S[a, a:] = S[a:, a] = _product(h[a:] * h[a], squared)
    L = cholesky.factor(S)
    right = np.stack([_product(h, w * y) for y in Y], 1)
    return cholesky.backward(L, cholesky.forward(L, right)), L, w


def _step(h: NDArray, Y: NDArray, p: NDArray, prior: NDArray) -> NDArray:
    """One Gauss-Newton step of p: (3, G). h: (4, N, 1 or G), Y: (4, N, G), prior: (G,) px²."""
    coefficients, L, w = _linear(h, Y, p)
    u = h[1:]
    found = np.stack([_product(h.transpose(1, 0, 2), coefficients[:, k]) for k in range(4)])
    found *= w
    size = np.einsum("kng,kng->ng", found, found)
    drop = np.einsum("kng,kng->ng", found, Y) - size  # ŷ·e
    gradient = -_product(u, w * drop) - prior * p
    squared = w * w
    normal = np.empty((3, 3, p.shape[1]))
    for i, j in PAIRS:
        normal[i, j] = _product(u[i : i + 1] * u[j], squared * size)[0]
    # what of Ŷ's derivative the coefficients take over by themselves
    along = np.concatenate([_product(h * u[j], squared * y)[:, None] for y in found for j in range(3)], 1)
    along = cholesky.forward(L, along).reshape(4, 4, 3, -1)
    normal_along = np.einsum("akig,akjg->ijg", along, along)
    for i, j in PAIRS:
        normal[i, j] -= normal_along[i, j]
        normal[j, i] = normal[i, j]
    normal[range(3), range(3)] += prior
    factor = cholesky.factor(normal)
    p = p + cholesky.backward(factor, cholesky.forward(factor, gradient[:, None]))[:, 0]
    length = np.sqrt(np.einsum("ig,ig->g", p, p))
    return p * np.minimum(1, LARGEST_P / np.maximum(length, 1e-300))


def _product(a: NDArray, b: NDArray) -> NDArray:
    """Σ_n a_in b_n. a: (i, n, 1 or G), b: (n, G) → (i, G); one matrix product where a is the same for the batch."""
    if a.shape[2] == 1:
        return a[:, :, 0] @ b
    return np.einsum("ing,ng->ig", a, b)


def equations(fitted: ProjectiveTransfer, demo: NDArray, own: NDArray, name: str) -> tuple[Equation, ...]:
    u = (demo - fitted.demo_mean) @ fitted.basis
    shape = fitted.coefficients[0] + u @ fitted.coefficients[1:]
    recovered = fitted.recover(demo[None, :2], demo[None, 2:])[0]
    latex = (
        rf"{{}}^{{LR}}\hat{{𝐮}}_{{{HOLE}}}=\bar{{𝐲}}+\frac{{𝐚_0+𝐀^{{\top}}𝐮_{{{HOLE}}}}}{{1+𝐩\cdot 𝐮_{{{HOLE}}}}}"
        rf"={column(4)}+{column(4)}\big/{HOLE}={column(4)}"
    )
    depth = number(float(1 + u @ fitted.p), 3)
    numbers = (name, name, name, *each(fitted.own_mean, 0), *each(shape, 1), depth, *each(recovered, 1))
    return (Equation("", f"in place of (4), point {name}: one depth for L and R, px", latex, numbers, wide=True),)


METHOD = TransferMethod(
    title="Projective combination",
    assumes="Parallel optical axes: both images of a pair have one depth. Then it is exact.",
    fails="Verged cameras, and much noise: the demonstrator's is amplified, so average its frames.",
    fit=fit,
    stored=(ProjectiveTransfer,),
    equations=equations,
)
