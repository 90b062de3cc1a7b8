"""Rank-3 factorisation (Tomasi & Kanade 1992): affine cameras make the centred [l r L R] a matrix of rank 3.

The nearest matrix of rank 3 is the maximum-likelihood affine fit of all four views at once. The squared distance to it
gives E = 1/(2N) Σ λ_k(W), k = 1…5, of the eight eigenvalues of the scatter matrix W, ascending. The residual has
components in the demonstrator's images, too, so it is white for equal noise in all images.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...geometry.affine import centred, cross_scatter, require_points
from ...geometry.small_matrices import tail_eigenvalue_sum
from ..views import FourViews
from .transfer import Transfer

RANK = 3


@dataclass(frozen=True)
class Rank3Transfer(Transfer):
    """A rank-3 factorisation of all four views."""

    is_whitened: ClassVar[bool] = True
    scatter: NDArray[np.float64]  # (..., 8, 8) px², W of the centred [l r L R]
    demo_mean: NDArray[np.float64]  # (..., 4) px
    own_mean: NDArray[np.float64]  # (..., 4) px
    flat: NDArray[np.float64]  # (...) σ1/σ3 of the centred [l r]

    @cached_property
    def condition(self) -> NDArray[np.float64]:
        """σ1/σ3 of the centred [l r]: inf for coplanar points."""
        return np.broadcast_to(self.flat, self.scatter.shape[:-2])

    @cached_property
    def shape(self) -> NDArray[np.float64]:
        """(..., 8, 3): the principal axes of the points' images."""
        return np.linalg.eigh(self.scatter)[1][..., -RANK:]

    @cached_property
    def matrix(self) -> NDArray[np.float64]:
        """(..., 4, 4): centred [L; R] of centred [l; r]."""
        return self.shape[..., 4:, :] @ np.linalg.pinv(self.shape[..., :4, :])

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray[np.float64]:
        demo = np.concatenate([demo_left, demo_right], -1) - self.demo_mean[..., None, :]
        return self.own_mean[..., None, :] + demo @ np.swapaxes(self.matrix, -1, -2)

    def residual(self, views: FourViews) -> NDArray[np.float64]:
        """Compute residuals in [l r L R], (..., N, 8) px, from the nearest points of rank 3."""
        demo = views.demo - self.demo_mean[..., None, :]
        own = views.own - self.own_mean[..., None, :]
        both = np.concatenate([np.broadcast_to(demo, own.shape), own], -1)
        return both - (both @ self.shape) @ np.swapaxes(self.shape, -1, -2)

    def conflict(self, views: FourViews) -> NDArray[np.float64]:
        """Compute E, (...) px², from the eigenvalues alone."""
        left = tail_eigenvalue_sum(self.scatter.reshape(-1, 8, 8).transpose(1, 2, 0), RANK)
        left = np.maximum(left, 0.0).reshape(self.scatter.shape[:-2])  # rounding may leave -1e-12
        return left / (2 * views.own.shape[-2])


def fit(views: FourViews) -> Rank3Transfer:
    """Fit N ≥ 5 points. The condition is σ1/σ3 of the centred [l r]."""
    require_points(views.own.shape[-2])
    demo_mean, demo = centred(views.demo)
    own_mean, own = centred(views.own)
    batch = own.shape[:-2]
    W = np.empty((8, 8, math.prod(batch)))
    W[:4, :4] = (demo.T @ demo)[:, :, None] if demo.ndim == 2 else cross_scatter(demo, demo)
    W[:4, 4:] = cross_scatter(demo, own)
    W[4:, :4] = W[:4, 4:].swapaxes(0, 1)
    W[4:, 4:] = cross_scatter(own, own)
    sigma = np.linalg.svd(demo, compute_uv=False)
    known = sigma[..., 2] > sigma[..., 0] * np.finfo(float).eps * demo.shape[-2]
    with np.errstate(divide="ignore", invalid="ignore"):
        flat = np.where(known, sigma[..., 0] / sigma[..., 2], np.inf)
    return Rank3Transfer(W.transpose(2, 0, 1).reshape(batch + (8, 8)), demo_mean, own_mean, flat)
