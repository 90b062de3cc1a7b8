"""The relation of rectified views as noise wants it: the maximum-likelihood fit near the demonstrator's posture.

Rectified, a pair of views of a point is a triple t = (x_L, (y_L + y_R)/2, x_R), which is the point in space up to a
projective map; so the demonstrator's images follow from the own ones by one homography G of space: ẑ_i = G [t_i; 1],
read as (x_l, y, x_r, y). e_i = z_i - ẑ_i has the covariance Σ_i = D_i D_iᵀ + κ K_i K_iᵀ px² for noise of 1 px in the
demonstrator's images and of √κ px in the own ones: D_i is the derivative of the rectification at the demonstrator's
point, K_i that of ẑ_i by the own point in px. Σ_i is frozen at one own image; farther off it may be nearly singular.

A point of the demonstrator that one camera alone sees has half of z_i, and no more than that is asked of ẑ_i.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...geometry.affine import image_unit
from ...geometry.rectification import MIN_DENOMINATOR, Rectification
from ..views import FourViews

STEPS = 3  # of Gauss and Newton
STEADY = 1e-10  # of the normal equations' mean diagonal, added to it
STEP_PX = 1e-3  # of difference quotients, in typical images
TO_TRIPLE = np.array([[1, 0, 0, 0], [0, 0.5, 0, 0.5], [0, 0, 1, 0]])
TO_PAIR = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0, 1, 0]])


@dataclass(frozen=True)
class Weighted:
    """Weights for images that are like one own image. rectification: of all; frame: about which they are fitted;
    weight: (N, 4, 4), Cᵀ with C Cᵀ = Σ⁻¹."""

    rectification: Rectification
    frame: "Frame"
    weight: NDArray

    @classmethod
    def like(cls, views: FourViews, rectification: Rectification, own_share: float) -> "Weighted":
        """views: of one posture, whose own images are taken for the weights; own_share: κ."""
        even = cls.even(views, rectification)
        z, t, frame = _demo(rectification, views), _triples(rectification, views.own), even.frame
        G = _fit(z, t, even.weight, frame)
        step_px = STEP_PX * image_unit(views.own)
        aside = step_px * np.eye(4)
        moved = [_mapped(G, _triples(rectification, views.own + step), frame) for step in aside]
        K = (np.stack(moved, -1) - _mapped(G, t, frame)[..., None]) / step_px
        stepped = [_demo(rectification, replace(views, demo=views.demo + step)) for step in aside]
        D = (np.stack(stepped, -1) - z[..., None]) / step_px
        covariance = D @ np.swapaxes(D, -1, -2) + own_share * K @ np.swapaxes(K, -1, -2)
        return cls(rectification, frame, _whitening(covariance, views.visible[:, :2]))

    @classmethod
    def even(cls, views: FourViews, rectification: Rectification) -> "Weighted":
        """All alike, as long as it is not known how noise spreads: each point's row counts once."""
        eyes, once = views.visible[:, :2].sum(1), np.ones(len(views.demo))
        covariance = np.stack([once, eyes, once, eyes], 1)[:, None] * np.eye(4)
        frame = Frame.of(_demo(rectification, views), _triples(rectification, views.own.reshape(-1, 4)))
        return cls(rectification, frame, _whitening(covariance, views.visible[:, :2]))

    def residual(self, views: FourViews) -> NDArray:
        """e C: (..., N, 4) px of the images as seen. views: own (..., N, 4) px, demo (N, 4)."""
        z, t = _demo(self.rectification, views), _triples(self.rectification, views.own)
        e = z - _mapped(_fit(z, t, self.weight, self.frame), t, self.frame)
        return np.einsum("nij,...nj->...ni", self.weight, e)


def _demo(rectification: Rectification, views: FourViews) -> NDArray:
    """(N, 4) rectified px; what one camera does not see is where a point at the mean depth of the others would be."""
    seen = views.visible[:, :2]
    if seen.all():
        return rectification.apply(views.demo)
    z = rectification.apply(np.nan_to_num(views.demo))
    left, right = z[:, :2], z[:, 2:]
    apart = (right - left)[seen.all(1)].mean(0) * [1, 0]
    return np.concatenate([np.where(seen[:, :1], left, right - apart), np.where(seen[:, 1:], right, left + apart)], 1)


def _whitening(covariance: NDArray, seen: NDArray) -> NDArray:
    """(N, 4, 4): Cᵀ of what is seen, C Cᵀ = Σ⁻¹, else 0. covariance: (N, 4, 4); seen: (N, 2) bool."""
    known = np.repeat(seen, 2, 1)
    both = known[:, :, None] & known[:, None, :]
    weight = np.linalg.inv(np.linalg.cholesky(np.where(both | np.eye(4, dtype=bool), covariance, 0.0)))
    return weight if seen.all() else np.where(both, weight, 0.0)


def _triples(rectification: Rectification, own: NDArray) -> NDArray:
    """(..., N, 4) px → (..., N, 3) rectified px."""
    return rectification.apply(own) @ TO_TRIPLE.T


@dataclass(frozen=True)
class Frame:
    """In which equations are well conditioned: means (3,) and scales px of the own and the demonstrator's triples."""

    own_mean: NDArray
    own_scale: float
    demo_mean: NDArray
    demo_scale: float

    @classmethod
    def of(cls, z: NDArray, t: NDArray) -> "Frame":
        """z: (N, 4), t: (N, 3) rectified px."""
        demo = z @ TO_TRIPLE.T
        return cls(t.mean(0), float(t.std()), demo.mean(0), float(demo.std()))


def _fit(z: NDArray, t: NDArray, weight: NDArray, frame: Frame) -> NDArray:
    """G: (..., 4, 4), in the frame. z: (N, 4), t: (..., N, 3) rectified px."""
    h = _homogeneous((t - frame.own_mean) / frame.own_scale)
    target = (z @ TO_TRIPLE.T - frame.demo_mean) / frame.demo_scale
    wanted = (z - TO_PAIR @ frame.demo_mean) / frame.demo_scale
    hh = (h[..., :, None] * h[..., None, :]).reshape(*h.shape[:-1], 16)
    A = weight @ TO_PAIR  # (N, 4, 3): of ẑ's three coordinates
    # ẑ of a G is linear in G but for its depth: first as if that were 1, by the observed triple
    M = _normal(np.concatenate([A, -(A @ target[:, :, None])], -1), hh, None)
    G = np.zeros(M.shape[:-1])
    G[..., 15] = 1.0
    G[..., :15] = np.linalg.solve(_steadied(M[..., :15, :15]), -M[..., :15, 15:])[..., 0]
    G = G.reshape(*M.shape[:-2], 4, 4)
    for _ in range(STEPS):
        q = h @ np.swapaxes(G, -1, -2)
        depth = np.maximum(q[..., 3], MIN_DENOMINATOR)
        found = q[..., :3] / depth[..., None]
        e = np.einsum("nij,...nj->...ni", weight, wanted - found @ TO_PAIR.T)
        B = np.concatenate([np.broadcast_to(A, found.shape[:-1] + (4, 3)), -(A @ found[..., None])], -1)
        M = _normal(B, hh, depth)
        gauge = G.reshape(*G.shape[:-2], 16)
        M = M + gauge[..., :, None] * gauge[..., None, :]  # G's scale moves nothing
        slope = np.einsum("...nba,...nb,...nc->...ac", B, e, h / depth[..., None])
        G = G + np.linalg.solve(_steadied(M), slope.reshape(*G.shape[:-2], 16, 1)).reshape(G.shape)
        G = G / np.maximum(np.abs(G[..., 3:, 3:]), MIN_DENOMINATOR)
    return G


def _mapped(G: NDArray, t: NDArray, frame: Frame) -> NDArray:
    """ẑ: (..., N, 4) rectified px of triples t (..., N, 3)."""
    q = _homogeneous((t - frame.own_mean) / frame.own_scale) @ np.swapaxes(G, -1, -2)
    triple = q[..., :3] / np.maximum(q[..., 3:], MIN_DENOMINATOR) * frame.demo_scale + frame.demo_mean
    return triple @ TO_PAIR.T


def _normal(B: NDArray, hh: NDArray, depth: NDArray | None) -> NDArray:
    """Σ_n BᵀB ⊗ h hᵀ / depth²: (..., 16, 16). B: (..., N, 4, 4), hh: (..., N, 16), depth: (..., N)."""
    BB = (np.swapaxes(B, -1, -2) @ B).reshape(*B.shape[:-2], 16)
    if depth is not None:
        hh = hh / (depth * depth)[..., None]
    blocks = np.swapaxes(BB, -1, -2) @ hh
    blocks = blocks.reshape(*blocks.shape[:-2], 4, 4, 4, 4)
    return np.swapaxes(blocks, -3, -2).reshape(*blocks.shape[:-4], 16, 16)


def _steadied(M: NDArray) -> NDArray:
    size = np.trace(M, axis1=-2, axis2=-1)[..., None, None] / M.shape[-1]
    return M + STEADY * size * np.eye(M.shape[-1])


def _homogeneous(points: NDArray) -> NDArray:
    return np.concatenate([points, np.ones(points.shape[:-1] + (1,))], -1)
