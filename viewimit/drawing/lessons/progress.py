"""E as one number, large, how it went, motion by motion, and the goal."""

from collections.abc import Sequence

import numpy as np

from .. import svg
from ..plots import Axes, decade_ticks, decades, log10
from . import narrow

SIZE = (224, 400)  # units
PLOT = (34, 150, 216, 300)  # units: left, top, right, bottom
NARROW, NARROW_PLOT = (narrow.WIDTH, 158), (206, 14, 358, 138)


def draw_progress(E: Sequence[float], goal: float | None, note: str = "", in_narrow: bool = False) -> str:
    """HTML. E: px² of the start and after each motion; goal: to be brought below; note: in the last line; in_narrow:
    the curve beside the numbers, not between them."""
    now, motions = E[-1], len(E) - 1
    parts = [svg.text(0, 14, "E, the conflict you see", "vi-2nd vi-b")]
    parts.append(
        f'<text class="vi-giant vi-of-E" x="0" y="76">{svg.short(now)}<tspan class="vi-unit" dx="6">px²</tspan></text>'
    )
    if motions:
        change = (now - E[-2]) / E[-2] if E[-2] > 0 else 0.0
        word = f"{'▼' if change < 0 else '▲'} {abs(change):.0%} by your last motion"
        parts.append(svg.text(0, 104, word, "vi-line-words"))
    parts.append(_plot(np.maximum(np.array(E, float), 1e-3), goal, NARROW_PLOT if in_narrow else PLOT))
    counted, y = (70, 152) if in_narrow else (0, 378)
    parts.append(svg.text(0, 134 if in_narrow else 336, "Motion", "vi-2nd vi-b"))
    parts.append(f'<text class="vi-big-count" x="{counted}" y="{y}">{motions}</text>')
    if note:
        parts.append(svg.text(0, y - 2 if in_narrow else y + 20, note, "vi-2nd"))
    w, h = NARROW if in_narrow else SIZE
    kind = narrow.CLASS if in_narrow else ""
    return (
        f'<svg class="vi vi-progress-of-E{kind}" viewBox="0 0 {w} {h}" role="img"'
        f' aria-label="E {svg.short(now)} px² after {motions} motions">{"".join(parts)}</svg>'
    )


def _plot(E: np.ndarray, goal: float | None, box: tuple[float, float, float, float]) -> str:
    everything = E if goal is None else np.append(E, goal)
    low, high = decades(everything, float(everything.min()), float(everything.max()))
    last = max(4, len(E) - 1)
    plot = Axes(box, (0, last), (low, high), up=log10)
    ticks = sorted({0, last // 2, last})
    parts = [
        plot.frame(
            "", "", [(k, str(k)) for k in ticks], [(v, words) for v, words in decade_ticks(low, high, 3)], box[0]
        )
    ]
    if goal is not None:
        parts.append(plot.level(goal, "vi-goal"))
        x, y = plot.place(np.array(float(last)), np.array(goal)).tolist()
        parts.append(svg.text(x, y + 13, f"goal {goal:g}", "vi-of-found vi-halo vi-end"))
    points = plot.place(np.arange(len(E), dtype=float), E)
    parts.append(f'<path class="vi-line-E" d="{svg.path(points)}"/><path class="vi-dot-E" d="{svg.dots(points)}"/>')
    return "".join(parts)
