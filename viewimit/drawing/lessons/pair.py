"""Two points of an image that may be taken for each other: both ringed, named, and joined."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from .. import svg

RING = 10.0  # units
NAME = 18.0  # units from a point to the middle of its name
EDGE = 14.0  # units that a name keeps from the drawing's edge


def draw_pairs(points: NDArray, pairs: Iterable[tuple[int, int]], size: tuple[float, float]) -> str:
    """points: (N, 2) units of a drawing of that size."""
    return "".join(_pair(points[[i, j]], (i, j), size) for i, j in pairs)


def _pair(ends: NDArray, names: tuple[int, int], size: tuple[float, float]) -> str:
    along = ends[1] - ends[0]
    length = max(float(np.hypot(*along)), 1e-9)
    unit = along / length
    from_, to = ends[0] + RING * unit, ends[1] - RING * unit
    joined = svg.segments(from_[None], to[None]) if length > 2 * RING else ""
    drawn = f'<path class="vi-pair-case" d="{joined}"/><path class="vi-pair" d="{joined}"/>'
    drawn += f'<path class="vi-pair-ring" d="{svg.circles(ends, RING)}"/>'
    for at, way, name in zip(ends, (-unit, unit), names):
        x, y = np.clip(at + NAME * way, EDGE, np.array(size) - EDGE).tolist()
        drawn += svg.text(x, y + 4.5, str(name), "vi-pair-name vi-halo vi-mid")
    return drawn
