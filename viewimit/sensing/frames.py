"""Several images of the same: averaged, with gross errors found and set aside, and their noise measured.

A point of a frame is a gross error if it is farther from the median of its frames than GROSS times the noise; medians
are not moved by a few of them (Rousseeuw & Leroy 1987).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import image_unit

NORMAL_MAD = 0.6745  # median of |x| for a standard normal x
GROSS, LEAST_PX = 5.0, 0.05  # times the noise; px of typical images that are never a gross error
FEWEST = 3  # frames that can outvote one


def merge(points: NDArray, visible: NDArray) -> tuple[NDArray, NDArray]:
    """points: (k, N, 2 v) px of k frames, visible: (k, N, v) → their means (N, 2 v) over the frames that show a point
    and are no gross error of it, and (N, v), whether one does."""
    if len(points) == 1:
        return points[0], visible[0]
    shown = np.repeat(visible, 2, -1)
    if len(points) >= FEWEST:
        away = np.abs(points - _median(points, shown))
        least = LEAST_PX * image_unit(points[0][visible[0].all(-1)])
        far = away > max(GROSS * noise(points, visible), least)
        visible = visible & ~far.reshape(visible.shape + (2,)).any(-1)
        shown = np.repeat(visible, 2, -1)
    return np.where(shown, points, 0.0).sum(0) / np.maximum(shown.sum(0), 1), np.asarray(visible.any(0))


def noise(points: NDArray, visible: NDArray) -> float:
    """Standard deviation of a coordinate, px, from how frames differ from their predecessors; 0 if none can be told."""
    both = np.repeat(visible[1:] & visible[:-1], 2, -1)
    steps = np.abs(np.diff(points, axis=0))[both]
    return float(np.median(steps) / (NORMAL_MAD * np.sqrt(2))) if len(steps) else 0.0


def _median(points: NDArray, shown: NDArray) -> NDArray:
    """Over the frames that show a point; NaN if none does. (k, N, 2 v) → (N, 2 v)"""
    ordered = np.sort(np.where(shown, points, np.inf), 0)
    count = shown.sum(0)
    low, high = np.maximum((count - 1) // 2, 0), np.minimum(count // 2, len(points) - 1)
    ends = [np.take_along_axis(ordered, k[None], 0)[0] for k in (low, high)]
    return np.where(count > 0, (ends[0] + ends[1]) / 2, np.nan)


# Pictures that come late: found out from how many looks a first motion takes to show, then waited for.

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
