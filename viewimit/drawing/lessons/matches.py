"""Landscapes of E beside each other: with all matches, with few of them, and with all in one plane; and which points
are matched."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape
from ...simulation.scene import Scene
from .. import relief, svg
from ..posture_plane import PosturePlane

SIZE = (440, 256)  # units: of a landscape with its words
MARGINS = (46, 4, 0, 22)
MOST_HIGH = 196
TOP = 28  # units from a row's top to its plot
LAYERS = ("all", "few", "plane")
ORDER = ("all", "few", "points", "plane")
MOST_CROSSES = 60


@dataclass(frozen=True)
class Shape:
    """A landscape and its caption. flat: E is zero everywhere, to rounding errors; found: None while it is
    computed; hidden: to be predicted."""

    title: str
    found: Landscape | None
    flat: bool = False
    hidden: bool = False


def draw_matches(
    scene: Scene,
    shapes: dict[str, Shape],
    layers: Collection[str],
    theta_demo: NDArray,
    points: NDArray,
    matched: NDArray,
    bones: NDArray,
    step_deg: float,
) -> str:
    """HTML. shapes: by layer; theta_demo: (2,) rad; points: (N, 2) px in l; matched: (N,) bool; bones: (k, 2) px;
    step_deg: of the landscapes' grids. All are drawn up to the largest E with all matches."""
    whole = shapes["all"].found
    most = np.inf if whole is None else float(np.nanmax(whole.E))
    drawn = {name: _landscape(scene, shapes[name], theta_demo, most, step_deg) for name in LAYERS if name in layers}
    drawn["points"] = _points(points, matched, bones)
    return f'<div class="vi-matches">{"".join(_wrap(drawn[name]) for name in ORDER if name in drawn)}</div>'


def _wrap(inside: str) -> str:
    return f'<svg class="vi vi-worded" viewBox="0 0 {SIZE[0]} {SIZE[1]}" role="img">{inside}</svg>'


def _landscape(scene: Scene, shape: Shape, theta_demo: NDArray, most: float, step_deg: float) -> str:
    plane = PosturePlane(scene, SIZE[0], MOST_HIGH, MARGINS)
    x, _, w, h = plane.box
    parts, words = [plane.frame("vi-plane")], ""
    if shape.hidden:
        parts.append(f'<text class="vi-giant vi-2nd vi-mid" x="{x + w / 2:.1f}" y="{h / 2 + 20:.1f}">?</text>')
    elif shape.found is None:
        parts.append(plane.message("computing …"))
    elif shape.flat:
        parts.append(svg.text(x + w / 2, h / 2 + 5, "E is 0 at every posture", "vi-flat-words vi-mid"))
        words = "no bottom: every posture fits"
    else:
        found = shape.found
        grid = plane.grid(found.axes)
        E = np.minimum(found.E, most)
        parts += [relief.shading(grid, E, plane.box), relief.contours(grid, E)]
        minima = np.degrees(found.local_minima())
        for k, place in enumerate(plane.place(minima[:MOST_CROSSES])):
            parts.append(svg.cross(place, 7 if k == 0 else 3.5))
        words = f"{'1 bottom; ' if len(minima) == 1 else ''}E up to {_rounded(float(np.nanmax(found.E)))} px²"
        parts.append(svg.text(x + 0.14 * w, h + 12, f"grid of {step_deg:g}°", "vi-2nd vi-grid-words"))
    if shape.found is not None and not shape.hidden and not shape.flat:
        demo = plane.place(np.degrees(theta_demo))
        parts.append(f'<path class="vi-seen" d="{svg.diamonds(demo[None], 5)}"/>')
    head = svg.text(x, 18, shape.title, "vi-b") + svg.text(x + w, 18, words, "vi-2nd vi-end")
    return head + f'<g transform="translate(0 {TOP})">{"".join(parts)}{plane.ends()}</g>'


def _rounded(value: float) -> str:
    """To three digits, thousands apart."""
    return f"{float(f'{value:.3g}'):,.0f}".replace(",", "\u2009")


def _points(points: NDArray, matched: NDArray, bones: NDArray) -> str:
    """The demonstrator's points in l, matched ones filled."""
    left, top, w, h = MARGINS[0], TOP, SIZE[0] - MARGINS[0] - MARGINS[1], MOST_HIGH
    everything = np.concatenate([points, bones])
    low, high = everything.min(0), everything.max(0)
    scale = float(min((w - 40) / (high - low)[0], (h - 30) / (high - low)[1]))
    place = lambda px: (px - (low + high) / 2) * scale + (left + w / 2, top + h / 2)
    drawn = [
        f'<rect class="vi-plane" x="{left}" y="{top}" width="{w}" height="{h}" rx="4"/>',
        f'<g class="vi-quiet vi-demo"><path class="vi-bone" d="{svg.path(place(bones))}"/></g>',
        f'<path class="vi-unmatched" d="{svg.diamonds(place(points[~matched]), 5)}"/>' if (~matched).any() else "",
        f'<path class="vi-seen" d="{svg.diamonds(place(points[matched]), 6)}"/>',
        svg.text(left, 18, "What is matched, in l", "vi-b"),
    ]
    if (~matched).any():
        drawn.append(svg.text(left + w, 18, "hollow: left out", "vi-2nd vi-end"))
    return "".join(drawn)
