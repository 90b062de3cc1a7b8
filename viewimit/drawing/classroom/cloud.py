"""Where a class has placed a posture of two joints, and which is true. HTML."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...simulation.scene import Scene
from .. import svg
from ..lessons import mark
from ..posture_plane import PosturePlane

WIDTH, MOST_HIGH, MARGINS = 264, 150, (31, 8, 4, 16)  # px


def draw_postures(scene: Scene, places: Sequence[tuple[float, float]], truth: NDArray | None) -> str:
    """places: degrees of both joints; truth: (2,) degrees, None while it is not shown."""
    plane = PosturePlane(scene, WIDTH, MOST_HIGH, MARGINS)
    if not plane.has_plane:
        return ""
    parts = [plane.frame("vi-plane"), plane.ends()]
    if places:
        low, high = np.array(scene.range_deg, float).T
        parts.append(mark.crowd(plane.place(np.clip(np.array(places), low, high))))
    if truth is not None and np.isfinite(truth).all():
        parts.append(f'<path class="vi-seen" d="{svg.diamonds(plane.place(truth)[None], 6)}"/>')
    box, label = f"0 0 {WIDTH} {plane.height:.1f}", f"{len(places)} postures"
    return f'<svg class="vi" viewBox="{box}" role="img" aria-label="{label}">{"".join(parts)}</svg>'
