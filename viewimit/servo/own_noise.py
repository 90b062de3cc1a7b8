"""What the noise of the own images does to a landscape that is predicted from them.

Slopes that are learned from noisy images are noisy, which adds curvature to E where there is none; and the images
predicted at one posture are wrong by an average of the visits' noise, which moves the place where E is least.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .minimise import DIFFERENCE
from .surrogate import Surrogate

DRAWS = 8
SURELY = 2.0  # standard deviations of the curvature that noise adds
LEAST = 1e-9  # of the largest curvature, what is left where noise explains it all


@dataclass(frozen=True)
class OwnNoise:
    """hessian: (m, m) px²/rad², what it adds to the hessian of E; gradients: (k, m) px²/rad, of E at its least, as k
    draws of it have them; freedom: of the residuals that make E."""

    hessian: NDArray
    gradients: NDArray
    freedom: int

    def taken_off(self, hessian: NDArray) -> NDArray:
        """(..., m, m), what surely is not noise of (..., m, m)."""
        surely = 1 + SURELY * np.sqrt(2 / self.freedom)
        curvatures, directions = np.linalg.eigh(hessian - surely * self.hessian)
        least = LEAST * np.trace(hessian, axis1=-2, axis2=-1)[..., None]
        return (directions * np.maximum(curvatures, least)[..., None, :]) @ np.swapaxes(directions, -1, -2)


def own_noise(
    model: Surrogate,
    residual_of: Callable[[NDArray], NDArray],
    place: NDArray,
    noise_px: float,
    freedom: int,
    seed: int,
) -> OwnNoise:
    """At a place, (m,) rad. residual_of: own images (..., N, 4) px → (..., n, C) px; noise_px: of an image coordinate,
    standard deviation."""
    about = model.predict(place + DIFFERENCE * np.eye(1 + len(place), len(place), -1))
    noise = np.random.default_rng(seed).standard_normal((DRAWS, *about[0].shape))
    e = residual_of(np.concatenate([about, about[0] + noise_px * noise]))
    points = e.shape[-2]
    e = e.reshape(len(e), -1) - e[0].ravel()
    J, of_noise = e[1 : len(about)] / DIFFERENCE, e[len(about) :]
    left = float((of_noise**2).sum()) / (DRAWS * points)  # px², that noise of one image makes
    slopes, images = model.slope_weights(place), model.image_weights(place)
    return OwnNoise(left * slopes.T @ slopes, np.linalg.norm(images) * of_noise @ J.T / points, freedom)
