"""Linear combination of views (Ullman & Basri 1991): each of the learner's images is an affine function of the
demonstrator's affine shape.

Centred [l r] = U Σ Vᵀ has rank 3 for affine cameras; u_i, the affine coordinates of point i, are the row i of
U's first three columns, and ŷ_i = a_0 + A u_i by least squares. No lines are intersected, so nothing
becomes singular where the epipolar lines of [l] and [r] are parallel.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..equations import Equation
from ..geometry.affine import centred, require_points, scatter
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
    demo_mean, demo = centred(views.demo)
    own_mean, own = centred(views.own)
    U, sigma, Vt = np.linalg.svd(demo, full_matrices=False)
    kept = sigma[..., :3] > sigma[..., :1] * np.finfo(float).eps * demo.shape[-2]
    sigma = np.where(kept, sigma[..., :3], 0.0)
    weight = np.divide(1.0, sigma, out=np.zeros_like(sigma), where=kept)
    inverse = (U[..., :3] * weight[..., None, :]) @ Vt[..., :3, :]  # transposed pseudo-inverse of [l r] at rank 3
    matrix = scatter(inverse, own).transpose(2, 1, 0).reshape(own.shape[:-2] + (4, 4))
    return LinearTransfer(matrix, demo_mean, own_mean, sigma)


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
