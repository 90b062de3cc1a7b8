"""Find faults of single image points: missing values and far outliers."""

import numpy as np
from numpy.typing import NDArray

MISSING_PX = (0.0, -1.0)  # both coordinates of a missing point, as many trackers write it
FAR = 100.0  # times the median distance from the median point of an image: no body reaches there


def is_missing_value(image: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which points are at (0, 0) or (-1, -1) exactly, as trackers mark missing ones: (..., 2) px -> (...)."""
    return np.isin(image[..., 0], MISSING_PX) & (image[..., 0] == image[..., 1])


def is_far_outlier(image: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which visible points of one image are farther out than any body reaches: (N, 2) px -> (N,)."""
    distance = np.linalg.norm(image - np.median(image, 0), axis=-1)
    half = np.median(distance)
    return np.asarray((distance > FAR * half) & (half > 0))
