"""Small landscapes of E, to be seen beside each other: one a transfer, of the same demonstrator."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..analysis.landscape import Landscape, conflict_at, grid_axes, landscape
from ..analysis.minima import Minima, local_minima
from ..simulation.scene import Scene
from ..simulation.world import World
from ..snapshot import Snapshot
from ..transfer import TRANSFERS
from . import relief, svg
from .posture_plane import PosturePlane
from .theme import OBSERVED

WIDTH = 207  # px
MARGINS = (31, 3, 0, 14)  # px: left, right, top, bottom


@dataclass(frozen=True)
class Studied:
    """E of one transfer over the postures. minima: between the grid's points; basin: share of the postures from which
    descent ends at the lowest; bias_deg: (2,), of that from the demonstrator's posture, NaN without a minimum."""

    transfer: str
    landscape: Landscape
    minima: Minima
    basin: float
    bias_deg: NDArray


def study(world: World, snapshot: Snapshot, transfer: str) -> Studied:
    """Around the demonstrator as the learner has seen it; two joints must move. Takes about 0.1 s."""
    views, fit = snapshot.views, TRANSFERS[transfer]
    demo, visible = views.demo, views.visible[:, :2]
    found = landscape(world, fit, demo, visible, grid_axes(world))
    minima = local_minima(found, lambda theta: conflict_at(world, fit, demo, visible, theta)[0])
    bias = np.degrees(minima.theta[0] - snapshot.theta_demo) if len(minima) else np.full(2, np.nan)
    return Studied(transfer, found, minima, found.basin_fraction(), bias)


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
        parts += [relief.shading(grid, E, plane.box), relief.plain_contours(grid, E)]
    demo = plane.place(np.degrees(theta_demo))
    parts.append(f'<path class="vi-seen" d="{svg.diamonds(demo[None], OBSERVED + 1)}"/>')
    for k, (x, y) in enumerate(plane.place(np.degrees(minima[np.isfinite(minima).all(1)]))):
        size = 5.5 if k == 0 else 3.0
        parts.append(
            f'<path class="vi-cross" d="M{x - size:.1f} {y:.1f}h{2 * size:g}M{x:.1f} {y - size:.1f}v{2 * size:g}"/>'
        )
    return "".join(parts) + plane.ends()
