"""Average frames of the same scene, measure their noise and latency, and find missing values and far outliers.

A point of a frame is an outlier if it is farther from the median over the frames than OUTLIER_SIGMA times the noise.
A few outliers do not move a median (Rousseeuw and Leroy, Robust Regression and Outlier Detection, 1987).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..geometry.affine import image_unit

MAD_OF_NORMAL = 0.6745  # median of |x| for a standard normal x
OUTLIER_SIGMA, MIN_OUTLIER_PX = 5.0, 0.05  # times the noise; px of typical images: never an outlier below
MIN_FRAMES = 3  # that can outvote one outlier
MAX_LATENCY_LOOKS = 3
MOVED_PX, MOVED_SIGMA = 0.2, 5.0  # px of typical images, and times the noise: by which half the points have moved
FAR_PX = 1e4  # of both coordinates, from which no picture reaches
FAR_OUTLIER = 100.0  # times the median distance from the median point of an image: no body reaches there

Points = NDArray[np.float64]
Visible = NDArray[np.bool_]
Look = Callable[[int], tuple[Points, Visible]]


def average_frames(points: Points, visible: Visible) -> tuple[Points, Visible]:
    """Average each point over the frames that show it, without outliers. points: (k, N, 2 v) k frames of N points in v
    views [px]; visible: (k, N, v) whether a frame shows a point in a view. Returns (N, 2 v), mean points [px], and
    whether any frame shows them."""
    if len(points) == 1:
        return points[0], visible[0]
    shown = np.repeat(visible, 2, -1)
    if len(points) >= MIN_FRAMES:
        deviation = np.abs(points - _median(points, shown))
        least = MIN_OUTLIER_PX * image_unit(points[0][visible[0].all(-1)])
        outlier = deviation > max(OUTLIER_SIGMA * noise_std(points, visible), least)
        visible = visible & ~outlier.reshape(visible.shape + (2,)).any(-1)
        shown = np.repeat(visible, 2, -1)
    return np.where(shown, points, 0.0).sum(0) / np.maximum(shown.sum(0), 1), np.asarray(visible.any(0))


def noise_std(points: Points, visible: Visible) -> float:
    """Return the standard deviation of a coordinate [px], from differences of successive frames.

    Shapes are those of `average_frames`. 0 if no point is visible in two successive frames.
    """
    both = np.repeat(visible[1:] & visible[:-1], 2, -1)
    steps = np.abs(np.diff(points, axis=0))[both]
    return float(np.median(steps) / (MAD_OF_NORMAL * np.sqrt(2))) if len(steps) else 0.0


def estimate_latency(before: tuple[Points, Visible], look: Look, noise_px: float) -> int | None:
    """Count the looks after a motion that still show the body as it was before: None if no look shows a motion.

    before: points before the motion, (N, 4) px, and whether they are visible, (N, 2); look(k): the k-th look after it,
    up to MAX_LATENCY_LOOKS, in the same form; noise_px: standard deviation of a coordinate.
    """
    least = MOVED_PX * image_unit(before[0][before[1].all(-1)]) + MOVED_SIGMA * noise_px
    for k in range(MAX_LATENCY_LOOKS + 1):
        points, visible = look(k)
        both = (before[1] & visible).all(-1)
        if both.any() and np.median(np.abs(points - before[0])[both].max(-1)) > least:
            return k
    return None


def is_missing_value(image: Points) -> Visible:
    """Return which points, (..., 2) px, are where trackers put missing ones, at (0, 0), (-1, -1), (-9999, -9999) …"""
    x = image[..., 0]
    return (x == image[..., 1]) & (x == np.round(x)) & ((x <= 0) | (x >= FAR_PX))


def is_far_outlier(image: Points) -> Visible:
    """Return which visible points of one image are farther out than any body reaches: (N, 2) px -> (N,)."""
    distance = np.linalg.norm(image - np.median(image, 0), axis=-1)
    half = np.median(distance)
    return np.asarray((distance > FAR_OUTLIER * half) & (half > 0))


def _median(points: Points, shown: Visible) -> Points:
    """Median over the frames that show a point, NaN if none does: (k, N, 2 v) -> (N, 2 v)."""
    ordered = np.sort(np.where(shown, points, np.inf), 0)
    count = shown.sum(0)
    low, high = np.maximum((count - 1) // 2, 0), np.minimum(count // 2, len(points) - 1)
    ends = [np.take_along_axis(ordered, k[None], 0)[0] for k in (low, high)]
    return np.where(count > 0, (ends[0] + ends[1]) / 2, np.nan)
