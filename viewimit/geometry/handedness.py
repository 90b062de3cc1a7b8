"""Handedness of the map between two stereo images of a body: one head cannot see a body as its own mirror image.

With parallel or rectified cameras the two images (x_l, y_l, x_r, y_r) of a point lie in a 3-D subspace of their 4-space
and are the point in space up to a projective map, the same one for every body in front of the head. So the map from one
body's images to those of another body in the same posture preserves orientation: its 3 x 3 linear part has a positive
determinant. Affine and projective transfers also allow reflections, and a body whose points are symmetric about its own
plane then fits its mirrored posture exactly.

With orthonormal coordinates U of the first body, the least-squares linear map has the matrix M = YᵀU, Y the images of
the second body. If det M < 0, the nearest map that does not reflect is M without its smallest singular value s₃
(Eckart and Young 1936), and leaves s₃² px² more.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .affine import centred

MIN_DEPTH_SIGMA = 3.0  # rms depth of the points, in standard deviations: noise hides the handedness of flatter bodies
MIN_SHARE = 1e-6  # of the largest extent of the images: a smaller third extent is rounding error
DIMENSIONS = 3


def principal_axes(images: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the three orthonormal directions (4, 3) in which stereo images (M, 4) px vary most."""
    return np.linalg.svd(centred(images)[1], full_matrices=False)[2][:DIMENSIONS].T


@dataclass(frozen=True)
class Handedness:
    """The handedness of a body, which all images of that body by the same head share."""

    basis: NDArray[np.float64]  # (N, 3): orthonormal coordinates of its points
    axes: NDArray[np.float64]  # (4, 3): the directions of the images that are compared
    sign: float  # of the basis, 1 or -1
    min_singular_px: float  # singular value of a map up to which noise may have made it

    @classmethod
    def from_images(
        cls, demo: NDArray[np.float64], axes: NDArray[np.float64], noise_px: float = 0.0
    ) -> "Handedness | None":
        """Return that of a body with images (N, 4) px; None if it is too flat for its handedness to show.

        axes: as from `principal_axes`, of rectified images if these are; noise_px: standard deviation of an image
        coordinate.
        """
        basis, extent, Vt = np.linalg.svd(centred(demo @ axes)[1], full_matrices=False)
        least = max(MIN_DEPTH_SIGMA * noise_px * np.sqrt(len(demo)), MIN_SHARE * extent[0])
        return cls(basis, axes, float(np.sign(np.linalg.det(Vt))), float(least)) if extent[-1] > least else None

    def mirror_residual(self, own: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return the residuals by which the best linear map to each body grows if it must not reflect.

        own: (..., N, 4) px. The residuals, (..., N, 3) px, have squares that sum to s₃² where the map reflects and are
        0 elsewhere; None if no map reflects.
        """
        images = own.reshape(-1, len(self._products))
        M = images @ self._products  # the basis is centred, so the images need not be
        a, b, c, d, e, f, g, h, i = M.T
        reflects = self.sign * (a * (e * i - f * h) + b * (f * g - d * i) + c * (d * h - e * g)) < 0
        if not reflects.any():
            return None
        residual = np.zeros((len(images), len(self.basis), DIMENSIONS))
        P, s, Qt = np.linalg.svd(M[reflects].reshape(-1, DIMENSIONS, DIMENSIONS))
        residual[reflects] = (self.basis @ Qt[:, -1, :, None]) * (s[:, -1:, None] * P[:, None, :, -1])
        return residual.reshape(*own.shape[:-1], DIMENSIONS)

    def is_mirrored(self, own: NDArray[np.float64]) -> bool | None:
        """Return whether the best linear map to a body with images (N, 4) px reflects; None if noise hides that."""
        M = (own.reshape(-1) @ self._products).reshape(DIMENSIONS, DIMENSIONS)
        if np.linalg.svd(M, compute_uv=False)[-1] <= self.min_singular_px:
            return None
        return bool(self.sign * np.linalg.det(M) < 0)

    @cached_property
    def _products(self) -> NDArray:
        """(4 N, 9): maps the images of N points, one after the other, to M, row by row."""
        return np.einsum("nj,ka->nkaj", self.basis, self.axes).reshape(-1, DIMENSIONS**2)
