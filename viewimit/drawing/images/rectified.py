"""The four images as seen and as rectified: rectification moves matched points of a pair to equal rows.

Lines across each pair mark the rows of some points in its left image, and the distances of their right images.
"""

import numpy as np

from ...geometry.arrays import Floats
from ...geometry.rectification import Rectification
from ...loop.snapshot import Snapshot
from ...simulation.appearance import ArmImages, Bodies
from .. import svg
from ..theme import OBSERVED
from .panel import draw_metrics, metrics_of, write_metrics

SIZE = (424, 256)  # px of the drawing
IMAGE = (96, 96)  # px of an image
LEFTS = (0, 226)  # px of the pairs as seen, and as rectified
TOPS = (22, 140)  # px of the pairs' rows, which are [l, r] and [L, R]
GAP = 6  # px between the images of a pair
MARGIN = 8  # px around the points
ROWS = 5  # that are drawn
MIN_DISTANCE = 0.01  # px: smaller ones are written as "less than"
AS_THEY_ARE = "Not rectified: one affine\ngeometry fits all matched points."
OFF = "Rectification is off\n(folder Display)."


def draw_rectified(snapshot: Snapshot, bodies: Bodies, print_size: bool = False) -> str:
    """Draw the panel as HTML; without rectification it says why there is none. print_size: as in `draw_images`."""
    by = snapshot.rectification
    parts = [svg.text(LEFTS[0], 14, "as seen", "vi-b"), svg.text(LEFTS[1], 14, "rectified", "vi-b")]
    off = OFF if snapshot.settings.rectify == "off" else AS_THEY_ARE
    for top, names, images, arm in (
        (TOPS[0], "lr", snapshot.views.demo, bodies.demo),
        (TOPS[1], "LR", snapshot.views.own, bodies.own),
    ):
        seen = images[snapshot.usable]
        parts.append(_pair(LEFTS[0], top, names, seen, arm, None))
        if by is not None:
            parts.append(_pair(LEFTS[1], top, names, seen, arm, by))
        else:
            parts += [svg.text(LEFTS[1], top + IMAGE[1] / 2 + 18 * k, words) for k, words in enumerate(off.split("\n"))]
    box = f"0 0 {SIZE[0]} {SIZE[1]}"
    label, drawn = "Pictures as seen and as rectified", "".join(parts)
    drawing = f'<svg class="vi" viewBox="{box}" role="img" aria-label="{label}">{drawn}</svg>'
    metrics = (draw_metrics if print_size else write_metrics)(metrics_of(snapshot))
    return f'<div class="vi-panel">{drawing}{metrics}</div>'


def row_distance(images: Floats) -> float:
    """Return the rms difference between the rows of matches, (N, 4) px; NaN without any."""
    return float(np.sqrt(np.mean((images[:, 3] - images[:, 1]) ** 2))) if len(images) else np.nan


def _pair(left: float, top: float, names: str, images: Floats, arm: ArmImages, by: Rectification | None) -> str:
    """Draw both images of a pair, (N, 4) px, with one scale, at one height. by: rectification, None for none."""
    both = lambda found: found if by is None else by.apply(found)
    images = both(images)
    hulls, bones = both(np.concatenate(list(arm.hulls), -1)), both(np.concatenate(list(arm.origins), -1))
    drawn, scale, low = [], 1.0, np.zeros(4)
    if len(images):
        low, high = images.min(0), images.max(0)
        low[[1, 3]], high[[1, 3]] = low[[1, 3]].min(), high[[1, 3]].max()
        room = (np.array(IMAGE) - 2 * MARGIN) / np.maximum((high - low).reshape(2, 2), 1.0)
        scale = float(room.min())
        low = (low + high) / 2 - np.tile(IMAGE, 2) / (2 * scale)  # in the middle
    for side, name in enumerate(names):
        axes = slice(2 * side, 2 * side + 2)
        placed = [(found[..., axes] - low[axes]) * scale for found in (images, hulls, bones)]
        drawn.append(_image(left + side * (IMAGE[0] + GAP), top, name, *placed))
    order = np.argsort(images[:, 1])
    for k in order[np.unique(np.linspace(0, len(order) - 1, min(ROWS, len(order))).astype(int))]:
        y, there = top + (images[k, [1, 3]] - low[[1, 3]]) * scale
        x = left + IMAGE[0] + GAP + (images[k, 2] - low[2]) * scale
        drawn.append(f'<path class="vi-row-line" d="M{left} {y:.1f}h{2 * IMAGE[0] + GAP}"/>')
        drawn.append(f'<path class="vi-e" d="M{x:.1f} {y:.1f}V{there:.1f}"/>')
    distance = row_distance(images)
    text = "rows differ by less than {px} px" if distance < MIN_DISTANCE else "rows differ by {px} px"
    words = text.format(px=svg.number(max(distance, MIN_DISTANCE), 2))
    return "".join(drawn) + svg.text(left, top + IMAGE[1] + 16, words)


def _image(x: float, y: float, name: str, points: Floats, hulls: Floats, bones: Floats) -> str:
    """Draw one image. points: (N, 2), hulls: (links, corners, 2), bones: (k, 2), px of its box."""
    demo = name in "lr"
    arm = f'<path class="vi-hull" d="{svg.polygons(hulls[None])[0]}"/><path class="vi-bone" d="{svg.path(bones)}"/>'
    kind, d = ("vi-seen", svg.diamonds(points, OBSERVED)) if demo else ("vi-own", svg.dots(points))
    return (
        f'<svg x="{x}" y="{y}" width="{IMAGE[0]}" height="{IMAGE[1]}">'
        f'<rect class="vi-plane" x=".5" y=".5" width="{IMAGE[0] - 1}" height="{IMAGE[1] - 1}" rx="4"/>'
        f'<g class="{"vi-demo" if demo else ""}">{arm}</g><path class="{kind}" d="{d}"/>'
        f'<text class="vi-name vi-halo" x="5" y="15">{name}</text></svg>'
    )
