"""Landscapes below each other, each with its least E, the demonstrator's posture, and the distance between both."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape
from ...simulation.scene import Scene
from .. import relief, svg
from ..labels import Label
from ..posture_plane import PosturePlane
from ..theme import OBSERVED
from . import narrow

WIDTH, MOST_HIGH, HEAD = 520, 236, 30  # units: of each, and of its title
MARGINS = (40, 12, 4, 36)
LAYERS = ("as seen", "rectified")


@dataclass(frozen=True)
class Case:
    """layer: of LAYERS; title: in words; found, least_deg: the landscape and where its E is
    smallest, None while they are computed; off_deg: from there to the truth."""

    layer: str
    title: str
    found: Landscape | None
    least_deg: NDArray | None
    off_deg: float


def draw_mended(
    scene: Scene, theta_demo: NDArray, cases: Sequence[Case], layers: Collection[str], in_narrow: bool = False
) -> str:
    """HTML. theta_demo: (2,) rad. A case whose layer is not shown leaves its plane empty, without its
    title."""
    width = narrow.WIDTH if in_narrow else WIDTH
    plane = PosturePlane(scene, width, MOST_HIGH, MARGINS)
    if in_narrow:
        plane.labels.letter = narrow.LETTER
    each = plane.height + HEAD
    drawn = "".join(
        f'<g transform="translate(0 {k * each:.1f})">{_case(plane, case, theta_demo, case.layer in layers)}</g>'
        for k, case in enumerate(cases)
    )
    box = f"0 0 {width} {each * len(cases):.1f}"
    label = "Landscapes of E: " + ", ".join(case.title for case in cases if case.layer in layers)
    kind = narrow.CLASS if in_narrow else ""
    return f'<svg class="vi vi-mended{kind}" viewBox="{box}" role="img" aria-label="{label}">{drawn}</svg>'


def _case(plane: PosturePlane, case: Case, theta_demo: NDArray, shown: bool) -> str:
    left, _, width, _ = plane.box
    parts, above, found = [plane.frame("vi-plane")], [], case.found
    labels = plane.labels.copy()
    levels: list[Label] = []
    words = ""
    if shown and found is None:
        parts.append(plane.message("computing …"))
    elif shown and found is not None and case.least_deg is not None:
        grid = plane.grid(found.axes)
        lowest = plane.place(case.least_deg)
        demo = plane.place(np.degrees(theta_demo))
        parts += [relief.shading(grid, found.E, plane.box), relief.contours(grid, found.E)]
        parts.append(f'<path class="vi-apart" d="{svg.segments(lowest[None], demo[None])}"/>')
        labels.take_points(np.stack([lowest, demo]), 9)
        levels = relief.level_labels(grid, found.E, labels.bounds, lowest)
        above.append(f'<path class="vi-seen" d="{svg.diamonds(demo[None], OBSERVED + 2)}"/>' + svg.cross(lowest, 8))
        left_first = bool(demo[0] <= lowest[0])
        above.append(labels.led(float(demo[0]), float(demo[1]), "demonstrator", "vi-lead-demo", left_first))
        above.append(labels.led(float(lowest[0]), float(lowest[1]), "smallest E", "vi-lead", not left_first))
        words = f"{svg.number(case.off_deg, 1)}° off"
    head = svg.text(left, 20, case.title if shown else "", "vi-b vi-mended-title")
    head += svg.text(left + width, 20, words, "vi-b vi-end vi-mended-title vi-of-E")
    inside = "".join(parts) + labels.draw(levels) + plane.axes() + "".join(above)
    return f'{head}<g transform="translate(0 {HEAD - 4})">{inside}</g>'
