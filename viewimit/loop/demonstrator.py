"""All looks at a demonstrator that stands still: their mean, and the noise that they show."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..sensing.frames import MIN_FRAMES, average_frames, noise_std

MAX_DEMO_LOOKS = 64  # that are remembered
OWN_NOISE_COUNTS = 8  # differences of images that the noise of the own images counts as much as

Images = tuple[NDArray[np.float64], NDArray[np.bool_]]  # of one body: points (N, 4) px, visible (N, 2)


def average_looks(looks: Sequence[Images], noise_px: float, fixed_px: float) -> tuple[Images, float]:
    """Average looks at a body that stands still.

    Parameters
    ----------
    looks : sequence of (N, 4) and (N, 2) arrays
        Its points [px], and whether they are visible.
    noise_px : float
        Standard deviation of a coordinate in a look, as of the own images.
    fixed_px : float
        The part of it that no averaging reduces, as of rounded images.

    Returns
    -------
    images : (N, 4) and (N, 2) arrays
        The mean of each point that some look shows. Too few looks to outvote an outlier, or equal
        ones: the first of those that show the most points.
    noise_px : float
        Standard deviation of a coordinate of the mean. It is measured by what the looks differ. Equal images show no
        noise, but an error that all have.
    """
    fullest = max(looks, key=lambda look: int(np.count_nonzero(look[1])))
    if len(looks) < MIN_FRAMES:
        return fullest, noise_px
    points, visible = np.array([one for one, _ in looks]), np.array([seen for _, seen in looks])
    measured = noise_std(points, visible)
    if measured == 0:
        return fullest, noise_px
    differences = 2 * int(np.count_nonzero(visible[1:] & visible[:-1]))
    squares = OWN_NOISE_COUNTS * noise_px**2 + differences * measured**2
    single = np.sqrt(squares / (OWN_NOISE_COUNTS + differences))
    return average_frames(points, visible), float(np.hypot(single / np.sqrt(len(looks)), fixed_px))
