"""Links on a landscape, a cell a posture, and the mark of one that is looked at without a motion.

Cells are exact at every size and pixel ratio; where in a picture it was clicked only a script could tell.
"""

import numpy as np
from numpy.typing import NDArray

from ...loop.snapshot import Snapshot
from ...simulation.scene import Scene
from .. import svg
from ..posture_plane import PosturePlane
from .links import link, sink

CELL_DEG, STOP_DEG = 5.0, 45.0  # postures a cell apart; Tab stops at some only
AIM, ARM = 8, 13  # px: radius of the ring of the cross hair, and how far its lines go


def posture_links(address: str, scene: Scene) -> str:
    """Over a landscape; nothing without two moving joints."""
    plane = PosturePlane(scene)
    if not plane.has_plane:
        return ""
    (ups, rows), (acrosses, columns) = (_cells(low, high) for low, high in scene.range_deg)
    x = plane.place(np.stack([np.full_like(columns, scene.range_deg[0][0]), columns], -1))[:, 0]
    y = plane.place(np.stack([rows, np.full_like(rows, scene.range_deg[1][0])], -1))[:, 1]
    stops: list[str] = []
    others: list[str] = []
    for i, up in enumerate(ups):
        for k, across in enumerate(acrosses):
            cell = f'<path d="M{x[k]:.1f} {y[i]:.1f}H{x[k + 1]:.1f}V{y[i + 1]:.1f}H{x[k]:.1f}z"/>'
            stop = up % STOP_DEG == 0 and across % STOP_DEG == 0
            one = link(address, f"posture/{up:g},{across:g}", named(scene, (up, across)), cell, stop)
            (stops if stop else others).append(one)
    group = f'<g role="group" aria-label="Postures for the learner">{"".join(others + stops)}</g>'
    return plane.wrap(group, "vi-over vi-links vi-cells") + sink()


def named(scene: Scene, angles_deg: tuple[float, ...]) -> str:
    """A posture in words."""
    return ", ".join(
        f"{svg.joint_symbol(joint)} {svg.number(angle, 0)}°" for joint, angle in zip(scene.moving_joints, angles_deg)
    )


def _cells(low: float, high: float) -> tuple[NDArray, NDArray]:
    """Multiples of CELL_DEG within a range, (k,), and the borders between them with the range's ends, (k + 1,)."""
    middles = CELL_DEG * np.arange(np.ceil(low / CELL_DEG), np.floor(high / CELL_DEG) + 1)
    return middles, np.array([low, *(middles[1:] - CELL_DEG / 2), high])


def draw_see_through(scene: Scene, moment: Snapshot) -> str:
    """A cross hair over the landscape."""
    plane = PosturePlane(scene)
    if not plane.has_plane:
        return ""
    x, y = plane.place(np.degrees(moment.theta)).tolist()
    hair = (
        f"M{x - ARM:.1f} {y:.1f}h{ARM - 3}m6 0h{ARM - 3}M{x:.1f} {y - ARM:.1f}v{ARM - 3}m0 6v{ARM - 3}"
        + svg.circles(np.array([[x, y]]), AIM)
    )
    return plane.wrap(f'<path class="vi-aim-case" d="{hair}"/><path class="vi-aim" d="{hair}"/>', "vi-over")


def describe_see_through(scene: Scene, moment: Snapshot) -> str:
    """A sentence: what is seen there, and that nothing has moved."""
    posture = ", ".join(svg.degrees(angle) for angle in moment.theta) if len(moment.theta) < 4 else "this posture"
    E = f"E {svg.short(moment.E)} px²" if np.isfinite(moment.E) else "too few points are seen for an E"
    return f"({posture}): {E}; nothing has moved."
