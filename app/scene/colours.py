"""Colours as viser takes them."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def linear(colour: ArrayLike) -> NDArray:
    """(..., 3) sRGB, 0 … 255 → uint8. Batched meshes, and segments of several colours, read them as linear light."""
    share = np.asarray(colour) / 255
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.round(255 * light).astype(np.uint8)
