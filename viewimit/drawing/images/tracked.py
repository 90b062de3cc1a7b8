"""Tracked points in the four views with recovered points and residuals; each view has axes in its pixels."""

from collections.abc import Mapping, Sequence

import numpy as np

from ...geometry.arrays import Floats
from .. import svg
from ..labels import Labels
from ..plots import Axes, linear_ticks
from ..theme import HEAD, RECOVERED

WIDTH, HEIGHT = 420, 330  # px of one view
LEFT, TOP, RIGHT, BOTTOM = 44, 24, 8, 24  # px around its plot
MARGIN = 0.08  # around the points, in units of their extent
DOT = 3.2  # px
DEMO = {"demo_left": "[l] demonstrator", "demo_right": "[r] demonstrator"}
TITLES = {**DEMO, "own_left": "[L] learner", "own_right": "[R] learner"}  # by the view's name in files
LEGEND = 26  # px of the heading above four views, and of the legend below


def draw_view(view: str, seen: Floats, recovered: Floats | None, names: Sequence[str]) -> str:
    """Draw one view as SVG.

    view: its name in files, such as demo_left; seen, recovered: points, (k, 2) px of the image, y downwards; names: of
    the points, (k,).
    """
    return f'<svg class="vi" viewBox="0 0 {WIDTH} {HEIGHT}">{_view(view, seen, recovered, names)}</svg>'


def draw_views(seen: Mapping[str, Floats], recovered: Mapping[str, Floats], names: Sequence[str], heading: str) -> str:
    """Draw all four views as SVG, two by two, with a heading and a legend; parameters as for `draw_view`."""
    parts = [svg.text(LEFT, 12, heading, "vi-b")]
    for k, view in enumerate(TITLES):
        inside = _view(view, seen[view], recovered.get(view), names)
        parts.append(f'<g transform="translate({k % 2 * WIDTH} {LEGEND + k // 2 * HEIGHT})">{inside}</g>')
    bottom = LEGEND + 2 * HEIGHT + 14
    parts += [
        f'<g transform="translate({x} {bottom})">{mark}{svg.text(27, 4, words, "vi-2nd")}</g>'
        for x, (mark, words) in zip((LEFT, 200, 300, 460), legend())
    ]
    return f'<svg class="vi" viewBox="0 0 {2 * WIDTH} {bottom + 12}">{"".join(parts)}</svg>'


def legend() -> list[tuple[str, str]]:
    """List marks, 20 px wide, and their meanings."""
    middle = np.array([[10.0, 0.0]])
    start, end = np.array([[[1.0, 0.0]]]), np.array([[[20.0, 0.0]]])
    arrow = f'<path class="vi-e" d="M1 0H16"/><path class="vi-tip" d="{svg.arrow_tips(start, end, HEAD)[0]}"/>'
    return [
        (_dot("vi-seen", 10, 0), "seen, demonstrator"),
        (_dot("vi-point", 10, 0), "seen, own"),
        (f'<path class="vi-found" d="{svg.diamonds(middle, RECOVERED)}"/>', "recovered from [l], [r]"),
        (arrow, "residual e"),
    ]


def _view(view: str, seen: Floats, recovered: Floats | None, names: Sequence[str]) -> str:
    axes = _axes(seen if recovered is None else np.concatenate([seen, recovered]))
    (left, right), (lower, upper) = axes.x, axes.y
    parts = [axes.frame(TITLES[view], "px", linear_ticks(left, right), linear_ticks(upper, lower))]
    places = axes.place(*seen.T)
    labels = Labels(axes.left, axes.top, axes.right, axes.bottom)
    if recovered is not None:
        found = axes.place(*recovered.T)
        parts.append(f'<path class="vi-found" d="{svg.diamonds(found, RECOVERED)}"/>')
        parts.append(f'<path class="vi-e" d="{svg.segments(found, places)}"/>')
        parts.append(f'<path class="vi-tip" d="{svg.arrow_tips(found[None], places[None], HEAD)[0]}"/>')
        labels.take_points(found, RECOVERED)
    labels.take_points(places, DOT)
    for (u, v), name in zip(places.tolist(), names):
        parts.append(_dot("vi-seen" if view in DEMO else "vi-point", u, v))
        parts.append(labels.beside(u, v, name, "vi-halo", DOT + 2))
    return "".join(parts)


def _axes(points: Floats) -> Axes:
    """Make axes around all points, with one scale for both directions, y downwards."""
    low, high = points.min(0), points.max(0)
    margin = MARGIN * max(*(high - low), 1.0)
    low, high = low - margin, high + margin
    w, h = WIDTH - LEFT - RIGHT, HEIGHT - TOP - BOTTOM
    half = max((high - low)[0] / w, (high - low)[1] / h) * np.array([w, h]) / 2
    (left, upper), (right, lower) = ((low + high) / 2 - half).tolist(), ((low + high) / 2 + half).tolist()
    return Axes(LEFT, TOP, WIDTH - RIGHT, HEIGHT - BOTTOM, (left, right), (lower, upper))


def _dot(kind: str, x: float, y: float) -> str:
    return f'<circle class="{kind}" cx="{x:.1f}" cy="{y:.1f}" r="{DOT}"/>'
