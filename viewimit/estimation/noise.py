"""Noise of image points that rounding to a grid of pixels has left, which images at rest do not show."""

import numpy as np
from numpy.typing import NDArray

from .views import FourViews

Array = NDArray[np.float64]

GRID_PARTS = 5040  # of a px: halves to tenths are whole numbers of these, and sixteenths, as of images scaled to 256 px
MIN_GRID_COORDINATES = 5  # different coordinates that show a grid; off any grid, 1 in 10⁸ has a step of MIN_STEP_PX
GRID_SCALES = 1.0, 10.0, 100.0, 1000.0  # px per unit of the coordinates, which may be normalised: tried in turn
MAX_EXTENT_PX = 50.0  # the next scale is tried only while the scaled points extend over less than this
MIN_STEP_PX, MAX_STEP_PX = 0.1, 8.0  # grid steps: finer ones are harmless; coarser ones are an order of the points


def rounding_std(points: Array, visible: NDArray[np.bool_]) -> float:
    """Compute the noise that rounding to whole pixels, or to another grid, has left.

    Images at rest do not show it: they are rounded alike. Rows of parallel cameras even hide it: most are equal to the
    last bit, and the others one step off. points: (..., N, 2 v) points in v views [px]. Each coordinate of each view
    has a grid of its own, with any origin; visible: (..., N, v). Returns standard deviation of a coordinate [px], root
    mean square of all, step/√12 each; 0 without a grid.
    """
    shown = np.repeat(visible, 2, -1)
    each = [points[..., k][shown[..., k]] for k in range(points.shape[-1])]
    largest = max((float(np.ptp(coordinates)) for coordinates in each if len(coordinates)), default=0.0)
    for scale in GRID_SCALES:
        steps = [step for coordinates in each if (step := _grid_step(coordinates * scale)) is not None]
        if any(steps) or not largest * scale < MAX_EXTENT_PX:
            break
    return float(np.sqrt(np.mean(np.square(steps)) / 12)) / scale if steps else 0.0


def _grid_step(coordinates: Array) -> float | None:
    """Largest step [px] of which all distances are multiples, 0 without one; None for too few coordinates."""
    parts = np.unique(np.round(coordinates * GRID_PARTS).astype(np.int64))
    if len(parts) < MIN_GRID_COORDINATES:
        return None
    step = float(np.gcd.reduce(np.diff(parts))) / GRID_PARTS
    if step > MAX_STEP_PX:
        return None
    return step if step > MIN_STEP_PX else 0.0


def views_rounding_std(views: FourViews) -> float:
    """Compute `rounding_std` of all four views [px]."""
    return rounding_std(np.concatenate([views.demo, views.own], -1), views.visible)
