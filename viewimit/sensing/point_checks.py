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


# Points that a tracker has lost, as many write them: at (0, 0) or (-1, -1), or where no picture goes.
# No point of a body is at such a place to the last digit. Taken for seen, one of them moves all that is fitted.

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


# Coordinates in whole pixels, halves, or steps of any grid: what rounding them has left of noise.
# Images at rest do not show it: they are rounded alike. Rows of parallel cameras even hide it: most are equal to the
# last bit, and the others one step off.

PARTS = 5040  # of a px: halves to tenths are whole numbers of them, and sixteenths, as of images scaled to 256 px
FEWEST = 5  # different coordinates that tell a grid: of so many on none, one in 10⁸ has a step of FINEST_PX by chance
SCALES, LARGEST_PX = (1.0, 10.0, 100.0, 1000.0), 50.0  # coordinates within less than that may be in such units of a px
FINEST_PX, COARSEST_PX = 0.1, 8.0  # steps: finer ones are harmless; coarser ones are an order of the points themselves


def rounding(points: NDArray, visible: NDArray) -> float:
    """Standard deviation px of a coordinate, root mean square of all, step/√12 each; 0 of what lies on no grid.

    points: (..., N, 2 v) px of v views; visible: (..., N, v). Each coordinate of each view has a grid of its own, from
    anywhere: a view may be scaled, or begin at the middle of a pixel, and another may be tracked to fractions.
    """
    shown = np.repeat(visible, 2, -1)
    each = [points[..., k][shown[..., k]] for k in range(points.shape[-1])]
    largest = max((float(np.ptp(coordinates)) for coordinates in each if len(coordinates)), default=0.0)
    for scale in SCALES:
        steps = [_step(coordinates * scale) for coordinates in each]
        told = [step for step in steps if step is not None]
        if any(told) or not largest * scale < LARGEST_PX:
            break
    return float(np.sqrt(np.mean(np.square(told)) / 12)) / scale if told else 0.0


def _step(coordinates: NDArray) -> float | None:
    """px: the largest one of which all distances are multiples, 0 if there is none; None where nothing is told."""
    parts = np.unique(np.round(coordinates * PARTS).astype(np.int64))
    if len(parts) < FEWEST:
        return None
    step = float(np.gcd.reduce(np.diff(parts))) / PARTS
    if step > COARSEST_PX:
        return None
    return step if step > FINEST_PX else 0.0
