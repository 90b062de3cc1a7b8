"""Small landscapes of E, to be seen beside each other: one a transfer, of the same demonstrator."""

import numpy as np
from numpy.typing import NDArray

from ..analysis.landscape import Landscape
from ..simulation.scene import Scene
from . import relief, svg
from .posture_plane import PosturePlane
from .theme import OBSERVED

WIDTH = 207  # px
MARGINS = (31, 3, 0, 14)  # px: left, right, top, bottom


def small_plane(scene: Scene, most_high: float) -> PosturePlane:
    """most_high: px."""
    return PosturePlane(scene, WIDTH, most_high, MARGINS)


def draw_small(plane: PosturePlane, found: Landscape, minima: NDArray, theta_demo: NDArray) -> str:
    """Relief, axes, the demonstrator's diamond and a cross at the smallest E, smaller ones at other minima.

    minima: (k, 2) rad, the lowest first; theta_demo: (2,) rad.
    """
    parts = [plane.frame("vi-plane")]
    E = found.E
    if np.isnan(E).all():
        parts.append(plane.message("nowhere are five points seen"))
    else:
        grid = plane.grid(found.axes)
        parts += [relief.shading(grid, E, plane.box), relief.contours(grid, E)]
    demo = plane.place(np.degrees(theta_demo))
    parts.append(f'<path class="vi-seen" d="{svg.diamonds(demo[None], OBSERVED + 1)}"/>')
    for k, place in enumerate(plane.place(np.degrees(minima[np.isfinite(minima).all(1)]))):
        parts.append(svg.cross(place, 5.5 if k == 0 else 3.0))
    return "".join(parts) + plane.ends()
