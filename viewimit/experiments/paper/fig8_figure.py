"""Fig. 8: E over the grid of postures, a panel a transfer, and how many points the four pictures share."""

import numpy as np

from ...drawing import relief, svg
from ...drawing.plots import WIDTH, figure
from ...drawing.posture_plane import PosturePlane
from ...drawing.theme import OBSERVED
from ...simulation.scene import Scene
from .fig8 import PAPER_MINIMUM_DEG, Fig8, Surface

COLUMN, GAP = 207, 10  # px: the width of a panel, between two
MARGINS = (31, 3, 0, 14)  # px around a plot: left, right, top, bottom
TITLE, TOP, MOST_HIGH, BELOW = 34, 6, 110, 34  # px: of the caption, from a row's title to its plots, of these, beneath
FAINTEST = 0.25  # opacity of the cell with the fewest points


def draw(scene: Scene, found: Fig8) -> str:
    axes = next(iter(found.surfaces.values())).landscape.axes
    first, second = (np.degrees(axis) for axis in axes)
    half = [(axis[1] - axis[0]) / 2 if len(axis) > 1 else 5.0 for axis in (first, second)]
    ranges = [(float(axis.min() - h), float(axis.max() + h)) for axis, h in zip((first, second), half)]
    plane = PosturePlane(scene, COLUMN, MOST_HIGH, MARGINS, ranges)
    names = list(found.surfaces)
    panels = [_panel(plane, found, name) for name in names] + [_points(plane, found, half)]
    row = TOP + plane.box[3] + BELOW
    parts = []
    for k, (title, note, inside) in enumerate(panels):
        x, y = k % 2 * (COLUMN + GAP), TITLE + k // 2 * row
        parts.append(
            f'<g transform="translate({x} {y:.1f})"><text x="{plane.box[0]:.1f}" y="0"><tspan class="vi-b">'
            f'{svg.escape(title)}</tspan><tspan class="vi-2nd" dx="5">{svg.escape(note)}</tspan></text>'
            f'<g transform="translate(0 {TOP})">{inside}{plane.ends()}</g></g>'
        )
    bottom = TITLE + -(-len(panels) // 2) * row
    extra = f" · {found.usable.size} postures"
    return figure(found.settings, "".join(parts) + _legend(bottom), extra, bottom + 14)


def _panel(plane: PosturePlane, found: Fig8, name: str) -> tuple[str, str, str]:
    """Title, note and drawing of one transfer's surface."""
    surface = found.surfaces[name]
    E, background = surface.landscape.E, plane.frame("vi-plane")
    if np.isnan(E).all():
        return name, "", background + plane.message("nowhere are five points seen")
    grid, lowest = plane.grid(surface.landscape.axes), plane.place(np.degrees(surface.landscape.minimum))
    labels = plane.labels.copy()
    labels.take_points(np.stack([lowest, plane.place(found.demonstrator_deg)]), 9)
    levels = labels.draw(relief.level_labels(grid, E, labels.bounds, lowest))
    drawn = relief.shading(grid, E, plane.box) + relief.contours(grid, E) + levels + _marks(plane, found, surface)
    return name, f"E {svg.short(np.nanmin(E), 10)} … {svg.short(np.nanmax(E), 10)} px²", background + drawn


def _marks(plane: PosturePlane, found: Fig8, surface: Surface) -> str:
    demo = plane.place(found.demonstrator_deg)
    return (
        f'<path class="vi-seen" d="{svg.diamonds(demo[None], OBSERVED + 1)}"/>'
        + svg.cross(plane.place(np.degrees(surface.landscape.minimum)), 5.5)
        + svg.saltire(plane.place(np.array(PAPER_MINIMUM_DEG)))
    )


def _points(plane: PosturePlane, found: Fig8, half: list[float]) -> tuple[str, str, str]:
    """Title, note and drawing of how many points are seen in all four pictures: a cell a posture, with the number."""
    axes = next(iter(found.surfaces.values())).landscape.axes
    x, y = plane.grid(axes)
    wide, high = 2 * half[1] * plane.scale, 2 * half[0] * plane.scale
    most, parts = max(int(found.usable.max()), 1), []
    for (i, j), count in np.ndenumerate(found.usable):
        opacity = FAINTEST + (1 - FAINTEST) * count / most
        parts.append(
            f'<rect class="vi-bar-cost" x="{x[j] - wide / 2:.1f}" y="{y[i] - high / 2:.1f}" width="{wide:.1f}"'
            f' height="{high:.1f}" opacity="{opacity:.2f}"/>'
        )
        if len(str(count)) * 7 < wide and high > 11:
            parts.append(svg.text(float(x[j]), float(y[i]) + 4, str(count), "vi-mid"))
    return "points", f"in all four pictures: {found.usable.min()} … {most}", "".join(parts)


def _legend(y: float) -> str:
    entries = (
        (f'<path class="vi-seen" d="{svg.diamonds(np.array([[8, 0]]), OBSERVED + 1)}"/>', "demonstrator"),
        (svg.cross(np.array([8, 0]), 5.5), "smallest E"),
        (svg.saltire(np.array([8, 0])), "the paper's"),
    )
    parts = []
    for k, (mark, words) in enumerate(entries):
        label = svg.text(20, 4, words, "vi-2nd")
        parts.append(f'<g transform="translate({MARGINS[0] + k * (WIDTH - 60) / 3:.1f} {y:.1f})">{mark}{label}</g>')
    return "".join(parts)
