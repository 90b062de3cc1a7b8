"""Where two lines cross, through a magnifying glass: pixels are squares, one line stands a pixel aside as well, and the
ellipse holds the recovered point if pixels are off."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import svg
from . import narrow
from .ellipse import draw_ellipse
from .view import chord

SIZE, NARROW = (560, 640), (narrow.WIDTH, 330)  # units
LAYERS = ("lines", "moved line", "ellipse")
NEAREST, ROOM = 8.0, 0.36  # units a px at most; share of the drawing's sides that the way of the crossing may take
NAMES = ("line from l", "line from r")
KINDS = ("vi-line vi-line-large", "vi-line vi-line-large vi-from-right")
LEGEND, LINE = 268, 21  # units: its width, and from one of its lines to the next


@dataclass(frozen=True)
class Crossing:
    """px in an image. lines: (2, 3), from l and from r; at: (2,) where they cross; moved: (3,) the line from r, one px
    aside; moved_at: (2,) where that crosses; half_axes: (2,) and direction, rad: of the recovered point's ellipse."""

    lines: NDArray
    at: NDArray
    moved: NDArray
    moved_at: NDArray
    half_axes: NDArray
    direction: float


def draw_crossing(
    found: Crossing | None, layers: Collection[str], view: str, angle: str, shift: str, in_narrow: bool = False
) -> str:
    """HTML. found: None where there are no lines; angle, shift: in words, at which they cross, and how far the crossing
    goes; in_narrow: the legend stands below, not in a corner."""
    w, h = box = NARROW if in_narrow else SIZE
    plane = f'<rect class="vi-plane" x=".5" y=".5" width="{w - 1}" height="{h - 1}" rx="4"/>'
    if found is None:
        return _wrap(plane + svg.text(w / 2, h / 2, "too few points are seen", "vi-2nd vi-mid"), view, box)
    size = np.array(box)
    way = np.abs(found.moved_at - found.at)
    scale = float(min(NEAREST, (ROOM * size / np.maximum(way, 1e-9)).min()))
    start, end = size / 2, (found.moved_at - found.at) * scale + size / 2
    parts, rows = [plane, _pixels(found.at, scale, size)], []
    if "ellipse" in layers:
        parts.append(draw_ellipse(start, scale * found.half_axes, found.direction))
    if "lines" in layers:
        for line, kind, name in zip(found.lines, KINDS, NAMES):
            parts.append(_line(line, found.at, scale, kind, size))
            rows.append((f'<path class="{kind}" d="M0 0h30"/>', name))
    if "moved line" in layers:
        parts.append(_line(found.moved, found.at, scale, "vi-line-moved", size) + _way(start, end, shift))
        rows.append(('<path class="vi-line-moved" d="M0 0h30"/>', "line from r, one pixel aside"))
    parts.append(f'<path class="vi-found vi-found-large" d="{svg.diamonds(start[None], 8)}"/>')
    rows.append((f'<path class="vi-found vi-found-large" d="{svg.diamonds(np.array([[15.0, 0.0]]), 6)}"/>', "crossing"))
    if "ellipse" in layers:
        rows.append(('<ellipse class="vi-spread" cx="15" rx="14" ry="6"/>', "recovered point, 19 times of 20"))
    rows.append(('<path class="vi-pixels vi-pixel" d="M9 -6h12v12h-12z"/>', f"one pixel; the lines cross at {angle}"))
    falls = -found.lines[0, 0] * found.lines[0, 1] > 0  # to the right: the corner at the right top is free
    title = f"{view}, through a magnifying glass"
    if in_narrow:
        inside = f'<svg width="{w}" height="{h}">{"".join(parts)}</svg>'  # which cuts off the rest
        return _wrap(inside + _legend(title, rows, 0, h + 8), view, (w, h + 46 + LINE * len(rows)), narrow.CLASS)
    x = w - LEGEND - 10 if falls else 10
    return _wrap("".join(parts) + _legend(title, rows, x, 10), view, box)


def _legend(title: str, rows: Sequence[tuple[str, str]], x: float, y: float) -> str:
    """Legend. rows: a sample, 30 units wide, and words."""
    w, h = LEGEND, 34 + LINE * len(rows)
    inside = svg.text(12, 21, title, "vi-b") + "".join(
        f'<g transform="translate(12 {40 + LINE * k})">{sample}</g>{svg.text(52, 44 + LINE * k, words)}'
        for k, (sample, words) in enumerate(rows)
    )
    box = f'<rect class="vi-legend" width="{w}" height="{h}" rx="6"/>'
    return f'<g transform="translate({x} {y})">{box}{inside}</g>'


def _pixels(at: NDArray, scale: float, size: NDArray) -> str:
    """The grid of pixels."""
    low, high = at - size / 2 / scale, at + size / 2 / scale
    lines = "".join(f"M{x:.1f} 0V{size[1]}" for x in (np.arange(np.ceil(low[0]), high[0]) - low[0]) * scale) + "".join(
        f"M0 {y:.1f}H{size[0]}" for y in (np.arange(np.ceil(low[1]), high[1]) - low[1]) * scale
    )
    return f'<path class="vi-pixels" d="{lines}"/>'


def _line(line: NDArray, at: NDArray, scale: float, kind: str, size: NDArray) -> str:
    length = np.hypot(*line[:2])
    corner = at - size / 2 / scale
    ends = chord(line[:2] / length, (line[:2] @ corner + line[2]) / length * scale, (int(size[0]), int(size[1])))
    return "" if ends is None else f'<path class="{kind}" d="{svg.segments(ends[0][None], ends[1][None])}"/>'


def _way(start: NDArray, end: NDArray, shift: str) -> str:
    """Where the crossing was, where it is, and how far that is."""
    tip = svg.arrow_tips(start[None, None], end[None, None], 12)[0]
    across = np.array([-(end - start)[1], (end - start)[0]])
    offset = across / max(float(np.hypot(*across)), 1e-9)
    offset = offset if offset[1] > 0 else -offset
    x, y = (start + end) / 2 + 64 * offset
    return (
        f'<path class="vi-e vi-e-large" d="{svg.segments(start[None], end[None])}"/><path class="vi-tip" d="{tip}"/>'
        f"{svg.text(x, y + 6, shift, 'vi-shift vi-halo vi-mid')}"
    )


def _wrap(inside: str, view: str, size: tuple[int, int], kind: str = "") -> str:
    label = f"Where both lines cross in {view}, enlarged"
    return (
        f'<svg class="vi vi-worded vi-crossing-of-lines{kind}" viewBox="0 0 {size[0]} {size[1]}" role="img"'
        f' aria-label="{label}">{inside}</svg>'
    )
