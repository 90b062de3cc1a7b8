"""Points that a tracker has lost, as many write them: at (0, 0) or (-1, -1), or where no picture goes.

No point of a body is at such a place to the last digit. Taken for seen, one of them moves all that is fitted.
"""

import numpy as np
from numpy.typing import NDArray

PLACES = (0.0, -1.0)  # px, of both coordinates
FAR = 100.0  # times the median distance from the median point of an image: no body reaches so far


def lost(image: NDArray) -> NDArray:
    """(..., 2) px → (...) bool"""
    return np.isin(image[..., 0], PLACES) & (image[..., 0] == image[..., 1])


def astray(image: NDArray) -> NDArray:
    """(N, 2) px, points seen in one picture → (N,) bool: beyond where the others can be."""
    away = np.linalg.norm(image - np.median(image, 0), axis=-1)
    half = np.median(away)
    return np.asarray((away > FAR * half) & (half > 0))
