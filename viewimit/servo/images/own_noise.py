"""What the noise of the own images does to a landscape that is predicted from them.

Slopes that are learned from noisy images are noisy, which adds curvature to E where there is none. The gradient Jᵀe of
E is wrong by both factors, which moves the place where E is least: e by an average of the visits' noise, and J by
differences of it, so that visits that are all near each other tell e well, and next to nothing of J.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..least_squares import DIFFERENCE, aside
from .kinematic_images import KinematicImages
from .learned import Images

DRAWS = 8
SURELY = 2.0  # standard deviations of the curvature that noise adds
LEAST = 1e-9  # of the largest curvature, what is left where noise explains it all


@dataclass(frozen=True)
class OwnNoise:
    """hessian: (m, m) px²/rad², what it adds to the hessian of E; gradients: (k, m) px²/rad, of E at its least, as k
    draws of the images there have them; by_slopes: the same, as k draws of the slopes do; freedom: of the residuals
    that make E."""

    hessian: NDArray
    gradients: NDArray
    by_slopes: NDArray
    freedom: int

    def taken_off(self, hessian: NDArray) -> NDArray:
        """(..., m, m), what surely is not noise of (..., m, m)."""
        surely = 1 + SURELY * np.sqrt(2 / self.freedom)
        curvatures, directions = np.linalg.eigh(hessian - surely * self.hessian)
        least = LEAST * np.trace(hessian, axis1=-2, axis2=-1)[..., None]
        return (directions * np.maximum(curvatures, least)[..., None, :]) @ np.swapaxes(directions, -1, -2)


def own_noise(
    model: Images,
    residual_of: Callable[[NDArray], NDArray],
    place: NDArray,
    noise_px: float,
    freedom: int,
    seed: int,
) -> OwnNoise:
    """At a place, (m,) rad. residual_of: own images (..., N, 4) px → (..., n, C) px; noise_px: of an image coordinate,
    standard deviation."""
    if isinstance(model, KinematicImages):
        return _of_kinematics(model, residual_of, place, freedom, seed)
    about = model.predict(place + DIFFERENCE * aside(len(place)))
    noise = np.random.default_rng(seed).standard_normal((DRAWS, *about[0].shape))
    e = residual_of(np.concatenate([about, about[0] + noise_px * noise]))
    points = e.shape[-2]
    e = e.reshape(len(e), -1)
    J, of_noise = (e[1 : len(about)] - e[0]) / DIFFERENCE, e[len(about) :] - e[0]
    left = float((of_noise**2).sum()) / (DRAWS * points)  # px², that noise of one image makes
    slopes, images = model.slope_weights(place), model.image_weights(place)
    gradients, by_slopes = np.linalg.norm(images) * of_noise @ J.T, _by_slopes(slopes, of_noise @ e[0])
    return OwnNoise(left * slopes.T @ slopes, gradients / points, by_slopes / points, freedom)


def _of_kinematics(
    model: KinematicImages, residual_of: Callable[[NDArray], NDArray], place: NDArray, freedom: int, seed: int
) -> OwnNoise:
    """The noise of all visits together moves every image and every slope: drawn as it does."""
    about = model.predict(place + DIFFERENCE * aside(len(place)))
    images, slopes = model.drawn(place, DRAWS, seed)
    aslant = DIFFERENCE * slopes.reshape(-1, *about[0].shape)
    e = residual_of(np.concatenate([about, about[0] + images, about[0] + aslant]))
    points = e.shape[-2]
    e = e.reshape(len(e), -1)
    off = e[1:] - e[0]
    J, of_images, of_slopes = np.split(off, [len(place), len(place) + DRAWS])
    J, of_slopes = J / DIFFERENCE, of_slopes.reshape(DRAWS, len(place), -1) / DIFFERENCE
    hessian = np.einsum("dik,djk->ij", of_slopes, of_slopes) / (DRAWS * points)
    return OwnNoise(hessian, of_images @ J.T / points, of_slopes @ e[0] / points, freedom)


def _by_slopes(slopes: NDArray, along: NDArray) -> NDArray:
    """(DRAWS, m) px²/rad: draws of the slopes' noise times e. slopes: (n, m) /rad, their weights; along: (DRAWS,) px²,
    draws of what one image's noise makes of e, times e."""
    root = np.linalg.qr(slopes, mode="r")  # as far as their squares go, the slopes' noise is that of so many images
    return np.stack([np.roll(along, k + 1) for k in range(len(root))], -1) @ root
