"""Rank-3 factorisation (Tomasi & Kanade 1992): affine cameras make the centred [l r L R] a matrix of rank 3.

Its nearest one of rank 3 is the maximum-likelihood affine fit of all four views at once, and what is left over is
E = 1/(2N) Σ λ_k(W), k = 1…5, of W's eight eigenvalues, ascending. The demonstrator's images answer for it as well.
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
    """scatter: (..., 8, 8) px² of the centred [l r L R]; demo_mean, own_mean: (..., 4) px; flat: σ1/σ3 of [l r]."""

    is_whitened: ClassVar[bool] = True
    scatter: NDArray
    demo_mean: NDArray
    own_mean: NDArray
    flat: NDArray

    @cached_property
    def condition(self) -> NDArray:
        """σ1/σ3 of the centred [l r]: inf for coplanar points."""
        return np.broadcast_to(self.flat, self.scatter.shape[:-2])

    @cached_property
    def shape(self) -> NDArray:
        """(..., 8, 3): the axes in which the points' images differ most."""
        return np.linalg.eigh(self.scatter)[1][..., -RANK:]

    @cached_property
    def matrix(self) -> NDArray:
        """(..., 4, 4): centred [L; R] of centred [l; r]."""
        return self.shape[..., 4:, :] @ np.linalg.pinv(self.shape[..., :4, :])

    def recover(self, demo_left: ArrayLike, demo_right: ArrayLike) -> NDArray:
        demo = np.concatenate([demo_left, demo_right], -1) - self.demo_mean[..., None, :]
        return self.own_mean[..., None, :] + demo @ np.swapaxes(self.matrix, -1, -2)

    def residual(self, views: FourViews) -> NDArray:
        """(..., N, 8) px, in [l r L R], from the nearest points of rank 3."""
        demo = views.demo - self.demo_mean[..., None, :]
        own = views.own - self.own_mean[..., None, :]
        both = np.concatenate([np.broadcast_to(demo, own.shape), own], -1)
        return both - (both @ self.shape) @ np.swapaxes(self.shape, -1, -2)

    def conflict(self, views: FourViews) -> NDArray:
        """From the eigenvalues alone."""
        left = tail_eigenvalue_sum(self.scatter.reshape(-1, 8, 8).transpose(1, 2, 0), RANK)
        left = np.maximum(left, 0.0).reshape(self.scatter.shape[:-2])  # rounding may leave -1e-12
        return left / (2 * views.own.shape[-2])


def fit(views: FourViews) -> Rank3Transfer:
    """For N ≥ 5 points. `condition` is σ1/σ3 of the centred [l r]."""
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
