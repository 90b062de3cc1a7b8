"""E as the mean of the squared arrows: every one a square, and the numbers of this very posture in the formula."""

import numpy as np

from ...snapshot import Snapshot
from .. import svg

SIZE = (620, 500)  # units
ROOM = 300  # units that the squares of an image may take
GAP = 6


def draw_formula(moment: Snapshot) -> str:
    """HTML. Each residual's squared length is a square of that area, in L and in R."""
    squares = (moment.e[moment.usable].reshape(-1, 2, 2) ** 2).sum(-1)  # (N, L R)
    if not len(squares):
        return _wrap(svg.text(SIZE[0] / 2, 60, "too few points are seen", "vi-2nd vi-mid"))
    largest = np.sqrt(squares.max())
    side = min(ROOM / np.sqrt(squares).sum(0).max(), 96 / largest) if largest > 0 else 0.0
    names = np.flatnonzero(moment.usable)
    parts = []
    for k, view in enumerate("LR"):
        y = 130 + 150 * k
        parts.append(f'<text class="vi-name" x="12" y="{y - 8}">{view}</text>')
        x = 44.0
        for i, square in zip(names, squares[:, k]):
            width = max(side * np.sqrt(square), 2.0)
            parts.append(
                f'<rect class="vi-square" x="{x:.1f}" y="{y - width:.1f}" width="{width:.1f}" height="{width:.1f}"/>'
            )
            if width > 12:
                parts.append(svg.text(x + width / 2, y + 15, svg.point_name(int(i)), "vi-2nd vi-mid"))
            x += width + GAP
        total = svg.short(float(squares[:, k].sum()))
        parts.append(svg.text(SIZE[0] - 12, y, f"together {total} px²", "vi-b vi-end"))
    count, sums = len(squares), [svg.short(float(total)) for total in squares.sum(0)]
    lines = (
        f"E = ( {sums[0]} + {sums[1]} ) ÷ ( 2 · {count} )",
        f"= {svg.short(float(squares.sum()) / (2 * count))} px²",
    )
    parts.append(svg.text(12, 36, "Every arrow, squared: the area of its square", "vi-b"))
    parts.append(svg.text(12, 54, f"{count} points in two images", "vi-2nd"))
    for k, line in enumerate(lines):
        parts.append(svg.text(44 + 22 * k, 370 + 48 * k, line, "vi-huge" if k else "vi-large-words"))
    return _wrap("".join(parts))


def _wrap(inside: str) -> str:
    label = "E, the mean of the squared residuals"
    return f'<svg class="vi" viewBox="0 0 {SIZE[0]} {SIZE[1]}" role="img" aria-label="{label}">{inside}</svg>'
