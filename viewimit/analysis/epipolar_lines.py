"""Where a body point must lie in each image, by what is seen of it in the others.

Where images are rectified the geometry is that of the rectified ones, and its lines are mapped back: lines stay lines.
"""

import numpy as np
from numpy.typing import NDArray

from ..geometry.pairs import PAIRS
from ..snapshot import Snapshot

# Of the views l r L R, of each of twelve lines: that it is drawn in, and that it comes from
INTO, SOURCE = np.concatenate([PAIRS[:, ::-1], PAIRS]).T


def epipolar_lines(snapshot: Snapshot, point: int) -> NDArray | None:
    """(12, 3): a x + b y + c = 0 px in the views INTO, of the point's images in the views SOURCE, of every pair of
    views; None with too few points for any."""
    if snapshot.fundamental is None:
        return None
    f, f33 = snapshot.fundamental
    images = np.stack([snapshot.views.demo[point], snapshot.views.own[point]])
    rectification = snapshot.rectification
    if rectification is not None:
        images = rectification.apply(images)
    # f_p·p + f_q·q + f33 = 0 is a line of q for a given p, and of p for a given q
    normal = np.concatenate([f[:, 2:], f[:, :2]])
    of_source = np.concatenate([f[:, :2], f[:, 2:]])
    offset = np.concatenate([f33, f33]) + (of_source * images.reshape(4, 2)[SOURCE]).sum(1)
    lines = np.concatenate([normal, offset[:, None]], 1)
    if rectification is None:
        return lines
    return np.einsum("ki,kij->kj", lines, np.stack([rectification.left, rectification.right])[INTO % 2])
