"""Linear combination of views (Ullman & Basri 1991): each of the learner's images is an affine function of the
demonstrator's affine shape.

Centred [l r] = U Σ Vᵀ has rank 3 for affine cameras; u_i, the affine coordinates of point i, are the row i of
U's first three columns, and ŷ_i = a_0 + A u_i by least squares. No lines are intersected, so nothing
becomes singular where the epipolar lines of [l] and [r] are parallel.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ...geometry.affine import centred, cross_scatter, require_points
from ..equations import Equation
from ..views import FourViews
from .affine_map import AffineTransfer, map_equation
from .transfer import TransferMethod


@dataclass(frozen=True)
class LinearTransfer(AffineTransfer):
    """sigma: (3,) or (..., 3) px, the largest singular values of the centred [l r], 0 for rounding errors."""

    sigma: NDArray

    @cached_property
    def condition(self) -> NDArray:
        """σ1/σ3 of the centred [l r]: (...), inf for coplanar points."""
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.where(self.sigma[..., 2] > 0, self.sigma[..., 0] / self.sigma[..., 2], np.inf)
        return np.broadcast_to(ratio, self.matrix.shape[:-2])


def fit(views: FourViews) -> LinearTransfer:
    """For N ≥ 5 points. `condition` is σ1/σ3 of the centred [l r]: inf for coplanar points."""
    require_points(views.own.shape[-2])
    demo = np.asarray(views.demo, float)
    demo_mean, sigma, inverse = _kept(demo.tobytes()) if demo.ndim == 2 else _inverted(demo)
    own_mean, own = centred(views.own)
    matrix = cross_scatter(inverse, own).transpose(2, 1, 0).reshape(own.shape[:-2] + (4, 4))
    return LinearTransfer(matrix, demo_mean, own_mean, sigma)


def _inverted(demo: NDArray) -> tuple[NDArray, NDArray, NDArray]:
    """[l r], (..., N, 4) px → its mean (..., 4) px, its σ (..., 3) px, and the transposed pseudo-inverse of what is
    left of rank 3, (..., N, 4) in 1/px."""
    mean, centred_demo = centred(demo)
    U, sigma, Vt = np.linalg.svd(centred_demo, full_matrices=False)
    kept = sigma[..., :3] > sigma[..., :1] * np.finfo(float).eps * demo.shape[-2]
    sigma = np.where(kept, sigma[..., :3], 0.0)
    weight = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=kept)
    return mean, sigma, (U[..., :3] * weight[..., None, :]) @ Vt[..., :3, :]


@lru_cache(64)  # the demonstrator mostly rests while a servo asks about own images
def _kept(demo: bytes) -> tuple[NDArray, NDArray, NDArray]:
    """Of points (N, 4) px, not to be written to."""
    found = _inverted(np.frombuffer(demo).reshape(-1, 4))
    for array in found:
        array.flags.writeable = False
    return found


def equations(fitted: LinearTransfer, demo: NDArray, own: NDArray, name: str) -> tuple[Equation, ...]:
    return (map_equation(fitted.matrix, fitted.demo_mean, fitted.own_mean, demo, name),)


METHOD = TransferMethod(
    title="Linear combination",
    assumes="Affine cameras: each own image is an affine function of the demonstrator's shape.",
    fails="Depth in the views, as for the epipolar one; but no lines are crossed, so none can be parallel.",
    fit=fit,
    stored=(LinearTransfer,),
    equations=equations,
)
