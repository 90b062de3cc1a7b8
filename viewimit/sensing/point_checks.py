"""Find faults of image points: degenerate shapes, missing values, far outliers, and rounding to a grid.

E of degenerate points is nearly 0 at any postures, so it looks best where it says nothing.
"""

import numpy as np
from numpy.typing import NDArray

from ..estimation.views import FourViews
from ..geometry.affine import MIN_POINTS, centred

RANK_TOL = 1e-6  # of the largest extent: smaller extents count as zero
SHAPES = ("all points are in one place", "all points are on one line", "all points are in one plane")
MISSING_PX = (0.0, -1.0)  # both coordinates of a missing point, as many trackers write it
FAR = 100.0  # times the median distance from the median point of an image: no body reaches there
GRID_PER_PX = 5040  # halves to tenths of a px are whole multiples of 1/5040, and so are sixteenths
MIN_COORDINATES = 5  # different ones that show a grid: without one, 1 in 10⁸ seems to have a step above MIN_STEP_PX
UNIT_SCALES, MAX_SCALED_PX = (
    (1.0, 10.0, 100.0, 1000.0),
    50.0,
)  # coordinates in a smaller range may be in units of more px
MIN_STEP_PX, MAX_STEP_PX = 0.1, 8.0  # finer steps are harmless; coarser ones are the spacing of the points themselves


def extents(images: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the singular values [px] of the centred points in two images: (..., N, 4) px -> (..., 4)."""
    return np.linalg.svd(centred(images)[1], compute_uv=False)


def dimensions(images: NDArray[np.float64]) -> NDArray[np.int_]:
    """Return the rank of the centred points: 0 in one place, 1 on a line, 2 in a plane. (..., N, 4) px -> (...)."""
    sigma, size = extents(images), np.abs(images).max((-2, -1))
    return (sigma > RANK_TOL * np.maximum(sigma[..., :1], RANK_TOL * size[..., None])).sum(-1)


def why_degenerate(views: FourViews) -> list[str]:
    """Say for each of T frames, all of whose points are visible, why no transfer can be fitted; "" if one can.

    Parameters
    ----------
    views : FourViews
        T frames of N points, (T, N, 4) px.
    """
    why = np.full(len(views.demo), "", object)
    for pair, images in (("[l, r]", views.demo), ("[L, R]", views.own)):
        rank = dimensions(images)
        for count, shape in enumerate(SHAPES):
            why[(rank == count) & (why == "")] = f"{shape} in {pair}"
    both = np.concatenate([views.demo, views.own], -1)
    repeats = (np.diff(np.sort(both[..., 0], -1), axis=-1) == 0).any(-1)  # otherwise all points differ
    for k in np.flatnonzero(repeats & (why == "")):
        different = len(np.unique(both[k], axis=0))
        if different < MIN_POINTS:
            why[k] = f"only {different} points differ, at least {MIN_POINTS} must"
    return [str(reason) for reason in why]


def is_missing_value(image: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which points are at (0, 0) or (-1, -1) exactly, as trackers mark missing ones: (..., 2) px -> (...)."""
    return np.isin(image[..., 0], MISSING_PX) & (image[..., 0] == image[..., 1])


def is_far_outlier(image: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which visible points of one image are farther out than any body reaches: (N, 2) px -> (N,)."""
    distance = np.linalg.norm(image - np.median(image, 0), axis=-1)
    half = np.median(distance)
    return np.asarray((distance > FAR * half) & (half > 0))


def rounding_std(points: NDArray[np.float64], visible: NDArray[np.bool_]) -> float:
    """Return the noise that rounding adds to a coordinate [px], step/√12 as root mean square; 0 without a grid.

    Frames at rest do not show this noise, because they are rounded alike. Rows of parallel cameras even hide it.

    Parameters
    ----------
    points : (..., N, 2 v) array
        Points in v views [px].
    visible : (..., N, v) array
        Whether a point is visible in a view.

    Notes
    -----
    Each coordinate of each view has its own grid with its own origin. A view may be scaled, or start at the middle of
    a pixel, and another may be tracked to fractions of a pixel.
    """
    shown = np.repeat(visible, 2, -1)
    columns = [points[..., k][shown[..., k]] for k in range(points.shape[-1])]
    largest = max((float(np.ptp(column)) for column in columns if len(column)), default=0.0)
    for scale in UNIT_SCALES:
        steps = [step for step in (_grid_step(column * scale) for column in columns) if step is not None]
        if any(steps) or not largest * scale < MAX_SCALED_PX:
            break
    return float(np.sqrt(np.mean(np.square(steps)) / 12)) / scale if steps else 0.0


def _grid_step(coordinates: NDArray[np.float64]) -> float | None:
    """Largest step [px] of which all distances are multiples; 0 if there is none, None if there are too few."""
    parts = np.unique(np.round(coordinates * GRID_PER_PX).astype(np.int64))
    if len(parts) < MIN_COORDINATES:
        return None
    step = float(np.gcd.reduce(np.diff(parts))) / GRID_PER_PX
    if step > MAX_STEP_PX:
        return None
    return step if step > MIN_STEP_PX else 0.0
