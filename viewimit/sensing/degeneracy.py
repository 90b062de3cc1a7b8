"""Points that cannot tell a transfer: all in one place, on one line or in one plane, or too few that differ.

E of such points is nearly 0 whatever the postures are, so that it looks best where it says nothing.
"""

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS, centred

NONE = 1e-6  # of the largest extent: an extent that is not there
SHAPES = ("all points are in one place", "all points are on one line", "all points are in one plane")


def extents(images: NDArray) -> NDArray:
    """σ1 to σ4 px of centred points in two images, (..., N, 4) px → (..., 4)."""
    return np.linalg.svd(centred(images)[1], compute_uv=False)


def dimensions(images: NDArray) -> NDArray:
    """In how many directions points lie apart, (..., N, 4) px → (...): 0 in one place, 1 on one line, 2 in a plane."""
    sigma, size = extents(images), np.abs(images).max((-2, -1))
    return (sigma > NONE * np.maximum(sigma[..., :1], NONE * size[..., None])).sum(-1)


def why_degenerate(views: FourViews) -> list[str]:
    """Of each of T frames, T x N points that are all seen: in one line why no transfer can be fitted, "" if one can."""
    why = np.full(len(views.demo), "", object)
    for pair, images in (("[l, r]", views.demo), ("[L, R]", views.own)):
        spread = dimensions(images)
        for count, shape in enumerate(SHAPES):
            why[(spread == count) & (why == "")] = f"{shape} in {pair}"
    both = np.concatenate([views.demo, views.own], -1)
    repeats = (np.diff(np.sort(both[..., 0], -1), axis=-1) == 0).any(-1)  # else all points differ
    for k in np.flatnonzero(repeats & (why == "")):
        different = len(np.unique(both[k], axis=0))
        if different < MIN_POINTS:
            why[k] = f"only {different} points differ, at least {MIN_POINTS} must"
    return [str(words) for words in why]
