"""Linear combination of views (Ullman & Basri 1991): each own image is an affine function of the demonstrator's shape.

For affine cameras the centred [l r] = U Σ Vᵀ has rank 3. The affine coordinates u_i of point i are row i of U's first
three columns, and ŷ_i = a_0 + A u_i by least squares. No lines are intersected, so nothing becomes singular where the
epipolar lines of [l] and [r] are parallel.

Every affine transfer is one 4 x 4 map between centred image points: `AffineTransfer`.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...geometry.affine import centred, cross_scatter, require_points
from ..views import FourViews
from .transfer import Transfer


@dataclass(frozen=True)
class AffineTransfer(Transfer):
    """[L; R] - own_mean = matrix ([l; r] - demo_mean)."""

    matrix: NDArray[np.float64]  # (..., 4, 4)
    demo_mean: NDArray[np.float64]  # (..., 4) px
    own_mean: NDArray[np.float64]  # (..., 4) px

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray[np.float64]:
        demo = np.concatenate([demo_left, demo_right], -1) - self.demo_mean[..., None, :]
        recovered = _mapped(self.matrix, demo)
        recovered += self.own_mean[..., None, :]
        return recovered


def _mapped(matrix: NDArray[np.float64], points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Map points (..., M, 4), or (M, 4) for all postures, by matrices (..., 4, 4)."""
    if points.ndim > 2:
        return points @ np.swapaxes(matrix, -1, -2)
    batch = matrix.shape[:-2]
    columns = matrix.reshape(-1, 4, 4).transpose(1, 2, 0)  # batch last, as `fit` left it in memory: one product
    return (points @ columns).transpose(2, 1, 0).reshape(batch + points.shape)


@dataclass(frozen=True)
class LinearTransfer(AffineTransfer):
    """A linear combination of views."""

    sigma: NDArray[np.float64]  # (3,) or (..., 3) px: largest singular values of the centred [l r], 0 for rounding

    @cached_property
    def condition(self) -> NDArray[np.float64]:
        """σ1/σ3 of the centred [l r]: (...), inf for coplanar points."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(self.sigma[..., 2] > 0, self.sigma[..., 0] / self.sigma[..., 2], np.inf)
        return np.broadcast_to(ratio, self.matrix.shape[:-2])


def fit(views: FourViews) -> LinearTransfer:
    """Fit N ≥ 5 points. The condition is σ1/σ3 of the centred [l r]: inf for coplanar points."""
    require_points(views.own.shape[-2])
    demo = np.asarray(views.demo, float)
    demo_mean, sigma, inverse = _cached_inverse(demo.tobytes()) if demo.ndim == 2 else _pseudo_inverse(demo)
    own_mean, own = centred(views.own)
    matrix = cross_scatter(inverse, own).transpose(2, 1, 0).reshape(own.shape[:-2] + (4, 4))
    return LinearTransfer(matrix, demo_mean, own_mean, sigma)


def _pseudo_inverse(demo: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Truncate [l r], (..., N, 4) px, to rank 3: mean (..., 4) px, σ (..., 3) px, and the transposed pseudo-inverse,
    (..., N, 4) in 1/px."""
    mean, centred_demo = centred(demo)
    U, sigma, Vt = np.linalg.svd(centred_demo, full_matrices=False)
    kept = sigma[..., :3] > sigma[..., :1] * np.finfo(float).eps * demo.shape[-2]
    sigma = np.where(kept, sigma[..., :3], 0.0)
    weight = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=kept)
    return mean, sigma, (U[..., :3] * weight[..., None, :]) @ Vt[..., :3, :]


@lru_cache(64)  # the demonstrator mostly rests while a servo asks about own images
def _cached_inverse(demo: bytes) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """`_pseudo_inverse` of points (N, 4) px; read-only."""
    found = _pseudo_inverse(np.frombuffer(demo).reshape(-1, 4))
    for array in found:
        array.flags.writeable = False
    return found
