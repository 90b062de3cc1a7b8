"""Coordinates in whole pixels, halves, or steps of any grid: what rounding them has left of noise.

Images at rest do not show it: they are rounded alike. Rows of parallel cameras even hide it: most are equal to the last
bit, and the others one step off.
"""

import numpy as np
from numpy.typing import NDArray

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
