"""Rectification of a stereo pair by its fundamental matrix: Hartley's homographies (1999), after which matches lie in
equal rows, as those of cameras with parallel optical axes do.

No camera is known: the right homography sends the epipole to infinity along the rows and changes least about the middle
of the matches; the left one makes its rows the same, and the disparities least.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .affine import centred, image_unit
from .fundamental import epipoles, fit_fundamental, fit_fundamental_with_prior, homogeneous, perturbed_fundamentals
from .robust_fit import affine_distance, fundamental_distance

MIN_DENOMINATOR = 0.1  # of a homography, which is 1 in the middle of the matches: no point is at infinity
LEAST_PX = 1e-3  # for images of the typical size: rms distance from any affine geometry that needs no rectification
FEWEST = 16  # matches
AFFINE_FREEDOM = 4  # parameters of an affine geometry
TRIMMED, FAR = 4, 6.0  # rounds; times the median distance, beyond which a match is wrong
TELLING = 12.0  # F-ratio of what the three further parameters of F explain to what they leave
MOST = 3000.0  # times that: rms distance from F beyond which matches are wrong, and tell nothing


@dataclass(frozen=True)
class Rectification:
    """left, right: (3, 3), of image points (x, y, 1) px; others: what it would be if F were one standard deviation
    elsewhere, along each of its independent directions, () of matches without noise."""

    left: NDArray
    right: NDArray
    others: tuple["Rectification", ...] = ()

    def apply(self, images: NDArray) -> NDArray:
        """(..., N, 4) px in [l, r] or [L, R] → rectified px, which are those of the right image in its middle."""
        return _both(images, self.left, self.right)

    def restore(self, images: NDArray) -> NDArray:
        """The inverse: rectified (..., N, 4) px → px."""
        return _both(images, *self._inverses)

    def in_units(self, unit_px: float) -> "Rectification":
        """Return the same for images in units of so many pixels; the same object for the same unit."""
        if unit_px not in self._by_unit:
            self._by_unit[unit_px] = self._in_units(unit_px)
        return self._by_unit[unit_px]

    def _in_units(self, unit_px: float) -> "Rectification":
        scale = np.diag([unit_px, unit_px, 1.0])
        left, right = (np.linalg.inv(scale) @ H @ scale for H in (self.left, self.right))
        return Rectification(left, right, tuple(other._in_units(unit_px) for other in self.others))

    @cached_property
    def _by_unit(self) -> dict[float, "Rectification"]:
        """Of the units that were asked for."""
        return {}

    @cached_property
    def _inverses(self) -> tuple[NDArray, NDArray]:
        return np.linalg.inv(self.left), np.linalg.inv(self.right)


def rectify(F: NDArray, left: NDArray, right: NDArray) -> Rectification:
    """F: (3, 3); left, right: (M, 2) px, the matches in whose middle the images are to change least."""
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
    rows = H_right @ _cross(epipole) @ F  # a point of the epipolar line of each left point; its first row is free
    l = homogeneous(left)
    H_left = rows / (l.mean(0) @ rows[2])
    found = _mapped(right, H_right)[:, 0]
    depth = np.maximum(l @ H_left[2], MIN_DENOMINATOR)
    H_left[0] = np.linalg.lstsq(l / depth[:, None], found, rcond=None)[0]
    return Rectification(H_left, H_right)


def level(left: NDArray, right: NDArray) -> Rectification:
    """Of cameras with parallel optical axes: the images turned so that their affine epipolar lines, Eq. (2), are rows,
    the right ones as far apart as the left ones. left, right: (M, 2) px"""
    mean, matches = centred(np.concatenate([left, right], 1))
    normal = np.linalg.eigh(matches.T @ matches)[1][:, 0]
    normal = normal * np.copysign(1.0, normal[1]) / np.hypot(*normal[:2])
    (a, b, c, d), offset = normal, float(normal @ mean)
    H_left = np.array([[b, -a, 0], [a, b, 0], [0, 0, 1]])
    H_right = np.array([[-d, c, 0], [-c, -d, offset], [0, 0, 1]])
    return Rectification(H_left, H_right)


def rectification_of(left: NDArray, right: NDArray) -> Rectification | None:
    """The matches' own, (M, 2) px each; None if they ask for none.

    Cameras with parallel optical axes, also unlike ones, have an affine geometry: both epipoles are at infinity. What
    no affine geometry fits, but F does, asks for rectification; noise and wrong matches are fitted by neither.
    """
    if not _needed(left, right):
        return None
    for distance in (affine_distance, fundamental_distance):
        left, right = _most(distance, left, right)
    affine, left_over = affine_squares(left, right), _squares(fundamental_distance(left, right))
    count, least_px = len(left), _least(left, right)
    if affine < count * least_px**2 or left_over > count * (MOST * least_px) ** 2:
        return None
    told = (affine - left_over) / 3 > TELLING * left_over / (count - 7)
    if not told:
        return None
    F = fit_fundamental(left, right)
    found = rectify(F, left, right)
    if left_over < count * least_px**2:
        return found
    return replace(found, others=tuple(rectify(other, left, right) for other in perturbed_fundamentals(F, left, right)))


def rectification_with_prior(left: NDArray, right: NDArray) -> Rectification | None:
    """Rectification by few matches, (M, 2) px each, none of them wrong, without a test of whether images ask for it.

    None if the matches are too few, or an affine geometry fits them exactly.
    """
    if not _needed(left, right):
        return None
    return rectify(fit_fundamental_with_prior(left, right), left, right)


def _needed(left: NDArray, right: NDArray) -> bool:
    """Whether matches are enough, and no affine geometry fits them exactly."""
    if len(left) < FEWEST or in_equal_rows(left, right):
        return False
    return not affine_squares(left, right) < len(left) * _least(left, right) ** 2


def _most(distance: Callable, left: NDArray, right: NDArray) -> tuple[NDArray, NDArray]:
    """The matches without those that are far from the geometry of the others; all, if these would be too few."""
    for _ in range(TRIMMED):
        away = np.abs(distance(left, right))
        near = away <= np.maximum(FAR * np.median(away), _least(left, right))
        if near.all() or near.sum() < FEWEST:
            break
        left, right = left[near], right[near]
    return left, right


def in_equal_rows(left: NDArray, right: NDArray) -> bool:
    """Whether equal rows are an affine geometry near enough, as of most heads: then the nearest one is, too."""
    apart = right[:, 1] - left[:, 1]
    return bool(apart @ apart < 2 * len(apart) * _least(left, right) ** 2)  # √2 times as far as from that geometry


def _least(left: NDArray, right: NDArray) -> float:
    """px: LEAST_PX of matches of these sizes."""
    return LEAST_PX * image_unit(np.concatenate([left, right], 1))


def affine_squares(left: NDArray, right: NDArray) -> float:
    """px², of all distances from the nearest affine geometry: the least eigenvalue of the matches' scatter, Eq. (2)."""
    _, matches = centred(np.concatenate([left, right], 1))
    return float(np.linalg.eigvalsh(matches.T @ matches)[0])


def _squares(distance: NDArray) -> float:
    return float(distance @ distance)


def _both(images: NDArray, left: NDArray, right: NDArray) -> NDArray:
    return np.concatenate([_mapped(images[..., :2], left), _mapped(images[..., 2:], right)], -1)


def _mapped(points: NDArray, H: NDArray) -> NDArray:
    """(..., 2) → (..., 2)"""
    mapped = points @ H[:, :2].T + H[:, 2]
    return mapped[..., :2] / np.maximum(mapped[..., 2:], MIN_DENOMINATOR)


def _cross(v: NDArray) -> NDArray:
    """[v]×"""
    x, y, z = v
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
