"""Linear combination of views (Ullman & Basri 1991): each of the learner's images is an affine function of the
demonstrator's affine shape.

Centred [l r] = U Σ Vᵀ has rank 3 for affine cameras; u_i, the affine coordinates of point i, are the row i of
U's first three columns, and ŷ_i = a_0 + A u_i by least squares. No lines are intersected, so nothing
becomes singular where the epipolar lines of [l] and [r] are parallel.
"""

import numpy as np

from ..geometry.affine import centred, require_points, scatter
from ..views import FourViews
from .affine_map import AffineTransfer


def fit(views: FourViews) -> AffineTransfer:
    """For N ≥ 5 points. `condition` is σ1/σ3 of the centred [l r]: inf for coplanar points."""
    require_points(views.own.shape[-2])
    demo_mean, demo = centred(views.demo)
    own_mean, own = centred(views.own)
    U, sigma, Vt = np.linalg.svd(demo, full_matrices=False)
    kept = sigma[..., :3] > sigma[..., :1] * np.finfo(float).eps * demo.shape[-2]
    weight = np.where(kept, 1 / np.where(kept, sigma[..., :3], 1.0), 0.0)
    inverse = (U[..., :3] * weight[..., None, :]) @ Vt[..., :3, :]  # transposed pseudo-inverse of [l r] at rank 3
    batch = own.shape[:-2]
    matrix = scatter(inverse, own).transpose(2, 1, 0).reshape(batch + (4, 4))

    def condition():
        with np.errstate(divide="ignore"):
            ratio = sigma[..., 0] / np.where(kept[..., 2], sigma[..., 2], 0.0)
        return np.broadcast_to(ratio, batch)

    return AffineTransfer(matrix, demo_mean, own_mean, condition)
