"""A frame of projective space in which stereo images of a body are its points.

Images [x_L y_L x_R y_R] of cameras with parallel axes, and rectified ones of any, lie in a hyperplane of their 4-space:
three coordinates of it are, with a 1, homogeneous coordinates of the point in space, up to a projective map.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

LEAST_SPREAD = 1e-6  # px: of images in a plane


@dataclass(frozen=True)
class StereoFrame:
    """mean: (4,) px; axes: (3, 4) px, along which the images were spread, by how much; off: px, rms from the
    hyperplane."""

    mean: NDArray
    axes: NDArray
    off: float

    @classmethod
    def of(cls, images: NDArray) -> "StereoFrame":
        """(M, 4) px"""
        mean = images.mean(0)
        _, spread, axes = np.linalg.svd(images - mean, full_matrices=False)
        spread = np.maximum(spread / np.sqrt(len(images)), LEAST_SPREAD)
        return cls(mean, spread[:3, None] * axes[:3], float(spread[3]))

    @property
    def spread(self) -> NDArray:
        """(3,) px, of one unit of each coordinate."""
        return np.linalg.norm(self.axes, axis=1)

    def coordinates(self, images: NDArray) -> NDArray:
        """(..., 4) px → (..., 3)"""
        return (images - self.mean) @ (self.axes.T / self.spread**2)

    @property
    def projection(self) -> NDArray:
        """(5, 4): homogeneous coordinates → homogeneous images."""
        return np.vstack([np.column_stack([self.axes.T, self.mean]), [0, 0, 0, 1]])
