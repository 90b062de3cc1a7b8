"""Pictures that come late: found out from how many looks a first motion takes to show, then waited for."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import image_unit

MOST_LAG = 3  # looks
MOVED_PX, MOVED_NOISE = 0.2, 5.0  # of typical images, times the noise: half of the points move by more, or none moved

Look = Callable[[int], tuple[NDArray, NDArray]]


def lag_of(before: tuple[NDArray, NDArray], look: Look, noise_px: float) -> int | None:
    """How many looks after a motion still show the body as it was before; None if the motion does not show at all.

    before, and look(k), the k-th look after the motion: points (N, 4) px, seen (N, 2).
    """
    least = MOVED_PX * image_unit(before[0][before[1].all(-1)]) + MOVED_NOISE * noise_px
    for lag in range(MOST_LAG + 1):
        if _moved(before, look(lag)) > least:
            return lag
    return None


def _moved(before: tuple[NDArray, NDArray], after: tuple[NDArray, NDArray]) -> float:
    """Median displacement of the points seen in both, px: a few wrong points do not move it."""
    both = (before[1] & after[1]).all(-1)
    if not both.any():
        return 0.0
    return float(np.median(np.abs(after[0] - before[0])[both].max(-1)))
