"""Rectification of a stereo pair by its fundamental matrix, after Hartley (1999): matches get equal rows.

Rectified images are like those of cameras with parallel optical axes. No camera is known: the right homography sends
the epipole to infinity along the rows, and changes least about the middle of the matches. The left one makes its rows
the same, and the disparities least.

References
----------
Hartley, "Theory and practice of projective rectification", IJCV 35(2), 1999.
Hartley and Zisserman, Multiple View Geometry, 2nd ed. 2004, section 11.12.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .affine import centred, image_unit
from .fundamental import epipoles, fit_fundamental, fit_fundamental_with_prior, homogeneous
from .robust_fit import MIN_F_RATIO, affine_distance, fundamental_distance

MIN_DENOMINATOR = 0.1  # of a homography, which is 1 in the middle of the matches: no point is at infinity
NEAR_EPIPOLE = 0.25  # the same denominator: points with a smaller one are near the epipole, which has 0
MIN_RMS_PX = 1e-3  # of images of typical size: smaller rms distance from an affine geometry needs no rectification
MIN_MATCHES = 16
N_TRIMMINGS, TRIM_FACTOR = 4, 6.0  # rounds; times the median distance, beyond which a match is wrong
MAX_RMS_FACTOR = 3000.0  # times MIN_RMS_PX: rms distance from F beyond which the matches are wrong


@dataclass(frozen=True)
class Rectification:
    """Homographies that rectify a stereo pair."""

    left: NDArray[np.float64]  # (3, 3): of image points (x, y, 1) px
    right: NDArray[np.float64]  # (3, 3)

    def apply(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        """Rectify images (..., N, 4) px in [l, r] or [L, R]; pixels are as large as in the right image's middle."""
        return _map_both(images, self.left, self.right)

    def restore(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        """Map rectified images (..., N, 4) px back."""
        return _map_both(images, *self._inverses)

    def magnification(self, images: NDArray[np.float64]) -> NDArray[np.float64]:
        """Factor by which it enlarges noise of images (..., 4) px, the rms of all directions: (..., 2), of each image.

        It differs from point to point where an epipole is near.
        """
        return np.stack([_enlarged(images[..., :2], self.left), _enlarged(images[..., 2:], self.right)], -1)

    def meets_epipole(self, images: NDArray[np.float64]) -> bool:
        """Whether an epipole is among or near image points, (..., 4) px, NaN if hidden: there is no depth there."""
        depths = [images[..., k : k + 2] @ H[2, :2] + H[2, 2] for k, H in ((0, self.left), (2, self.right))]
        return bool(np.nanmin(depths, initial=1.0) < NEAR_EPIPOLE)

    def in_units(self, unit_px: float) -> "Rectification":
        """Return the rectification of images in units of unit_px pixels; the same object for the same unit."""
        if unit_px not in self._by_unit:
            self._by_unit[unit_px] = self._in_units(unit_px)
        return self._by_unit[unit_px]

    def _in_units(self, unit_px: float) -> "Rectification":
        scale = np.diag([unit_px, unit_px, 1.0])
        left, right = (np.linalg.inv(scale) @ H @ scale for H in (self.left, self.right))
        return Rectification(left, right)

    @cached_property
    def _by_unit(self) -> dict[float, "Rectification"]:
        return {}

    @cached_property
    def _inverses(self) -> tuple[NDArray, NDArray]:
        return np.linalg.inv(self.left), np.linalg.inv(self.right)


def fit_rectification(left: NDArray[np.float64], right: NDArray[np.float64]) -> Rectification | None:
    """Fit the rectification that matches ask for, (M, 2) px each; None if they ask for none.

    Cameras with parallel optical axes have an affine geometry, even unlike ones: both epipoles are at infinity. Matches
    ask for rectification if F fits them and no affine geometry does, by an F-test. Neither fits noise or wrong matches.
    """
    if not _needs_rectification(left, right):
        return None
    for distance in (affine_distance, fundamental_distance):
        left, right = _trim(distance, left, right)
    distances = fundamental_distance(left, right)
    squares_affine, squares_F = affine_squared_error(left, right), float(distances @ distances)
    count, min_px = len(left), _min_rms(left, right)
    if squares_affine < count * min_px**2 or squares_F > count * (MAX_RMS_FACTOR * min_px) ** 2:
        return None
    if not (squares_affine - squares_F) / 3 > MIN_F_RATIO * squares_F / (count - 7):
        return None
    return rectify(fit_fundamental(left, right), left, right)


def fit_rectification_with_prior(left: NDArray[np.float64], right: NDArray[np.float64]) -> Rectification | None:
    """Fit the rectification of few matches, (M, 2) px each, none of them wrong, without testing whether it is needed.

    None if the matches are too few, or an affine geometry fits them exactly.
    """
    if not _needs_rectification(left, right):
        return None
    return rectify(fit_fundamental_with_prior(left, right), left, right)


def rectify(F: NDArray[np.float64], left: NDArray[np.float64], right: NDArray[np.float64]) -> Rectification:
    """Rectify by F, (3, 3); the images change least in the middle of the matches, (M, 2) px each."""
    middle = right.mean(0)
    epipole = epipoles(F)[1]
    x, y = epipole[:2] - epipole[2] * middle
    angle = np.arctan2(y, x)
    angle -= np.pi * np.round(angle / np.pi)  # to the nearer end of the row: no image is turned upside down
    cos, sin = np.cos(angle), np.sin(angle)
    to_row = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]) @ np.array(
        [[1, 0, -middle[0]], [0, 1, -middle[1]], [0, 0, 1]]
    )
    along = cos * x + sin * y
    to_infinity = np.array([[1, 0, 0], [0, 1, 0], [-epipole[2] / along, 0, 1]])
    back = np.array([[1, 0, middle[0]], [0, 1, middle[1]], [0, 0, 1]])
    H_right = back @ to_infinity @ to_row
    rows = H_right @ cross_matrices(epipole) @ F  # a point of the epipolar line of each left point; row 0 is free
    l = homogeneous(left)
    H_left = rows / (l.mean(0) @ rows[2])
    target = _map(right, H_right)[:, 0]
    depth = np.maximum(l @ H_left[2], MIN_DENOMINATOR)
    H_left[0] = np.linalg.lstsq(l / depth[:, None], target, rcond=None)[0]
    return Rectification(H_left, H_right)


def has_equal_rows(left: NDArray[np.float64], right: NDArray[np.float64]) -> bool:
    """Whether equal rows fit the matches, (M, 2) px each, as of most heads: then an affine geometry does, too."""
    difference = right[:, 1] - left[:, 1]  # √2 times the distance from that geometry
    return bool(difference @ difference < 2 * len(difference) * _min_rms(left, right) ** 2)


def affine_squared_error(left: NDArray[np.float64], right: NDArray[np.float64]) -> float:
    """Sum of squared distances [px²] from the nearest affine geometry: the smallest eigenvalue of W, Eq. (2)."""
    _, matches = centred(np.concatenate([left, right], 1))
    return float(np.linalg.eigvalsh(matches.T @ matches)[0])


def _needs_rectification(left: NDArray, right: NDArray) -> bool:
    """Whether the matches are enough, and no affine geometry fits them exactly."""
    if len(left) < MIN_MATCHES or has_equal_rows(left, right):
        return False
    return not affine_squared_error(left, right) < len(left) * _min_rms(left, right) ** 2


def _trim(distance: Callable, left: NDArray, right: NDArray) -> tuple[NDArray, NDArray]:
    """Remove matches that are far from the geometry of the others, unless too few would remain."""
    for _ in range(N_TRIMMINGS):
        distances = np.abs(distance(left, right))
        near = distances <= np.maximum(TRIM_FACTOR * np.median(distances), _min_rms(left, right))
        if near.all() or near.sum() < MIN_MATCHES:
            break
        left, right = left[near], right[near]
    return left, right


def _min_rms(left: NDArray, right: NDArray) -> float:
    """MIN_RMS_PX, scaled to matches of these sizes [px]."""
    return MIN_RMS_PX * image_unit(np.concatenate([left, right], 1))


def _map_both(images: NDArray, left: NDArray, right: NDArray) -> NDArray:
    return np.concatenate([_map(images[..., :2], left), _map(images[..., 2:], right)], -1)


def _map(points: NDArray, H: NDArray) -> NDArray:
    """Map points (..., 2) by a homography."""
    mapped = points @ H[:, :2].T + H[:, 2]
    return mapped[..., :2] / np.maximum(mapped[..., 2:], MIN_DENOMINATOR)


def _enlarged(points: NDArray, H: NDArray) -> NDArray:
    """Rms singular value of the derivative of a homography at points (..., 2)."""
    depth = np.maximum(points @ H[2, :2] + H[2, 2], MIN_DENOMINATOR)[..., None, None]
    J = (H[:2, :2] - _map(points, H)[..., None] * H[2, :2]) / depth
    return np.sqrt((J**2).sum((-1, -2)) / 2)


def cross_matrices(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """[v]×, (..., 3, 3), of vectors v, (..., 3): its product with a vector is the cross product of v with it."""
    found = np.zeros((*vectors.shape, 3))
    x, y, z = vectors[..., 0], vectors[..., 1], vectors[..., 2]
    found[..., 0, 1], found[..., 0, 2], found[..., 1, 2] = -z, y, -x
    found[..., 1, 0], found[..., 2, 0], found[..., 2, 1] = z, -y, x
    return found
