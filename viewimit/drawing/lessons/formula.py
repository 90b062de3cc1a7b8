"""E as the mean of the squared arrows: every one a square, and the numbers of this very posture in the formula."""

import numpy as np

from ...loop.snapshot import Snapshot
from .. import svg
from . import narrow

SIZE, NARROW = (620, 500), (narrow.WIDTH, 420)  # units
ROOM, NARROW_ROOM = 300, 150  # units that the squares of an image may take
GAP = 6


def draw_formula(moment: Snapshot, in_narrow: bool = False) -> str:
    """HTML. Each residual's squared length is a square of that area, in L and in R."""
    squares = (moment.e[moment.usable].reshape(-1, 2, 2) ** 2).sum(-1)  # (N, L R)
    size, room, most, left = (NARROW, NARROW_ROOM, 60, 24) if in_narrow else (SIZE, ROOM, 96, 44)
    if not len(squares):
        return _wrap(svg.text(size[0] / 2, 60, "too few points are seen", "vi-2nd vi-mid"), size)
    largest = np.sqrt(squares.max())
    side = min(room / np.sqrt(squares).sum(0).max(), most / largest) if largest > 0 else 0.0
    names = np.flatnonzero(moment.usable)
    row = 96 if in_narrow else 150
    parts = []
    for k, view in enumerate("LR"):
        y = 130 + row * k
        parts.append(f'<text class="vi-name" x="{left - 22 if in_narrow else 12}" y="{y - 8}">{view}</text>')
        x = float(left)
        for i, square in zip(names, squares[:, k]):
            width = max(side * np.sqrt(square), 2.0)
            parts.append(
                f'<rect class="vi-square" x="{x:.1f}" y="{y - width:.1f}" width="{width:.1f}" height="{width:.1f}"/>'
            )
            if width > 12:
                parts.append(svg.text(x + width / 2, y + 15, str(int(i)), "vi-2nd vi-mid"))
            x += width + GAP
        total = svg.short(float(squares[:, k].sum()))
        parts.append(svg.text(size[0] - (2 if in_narrow else 12), y, f"together {total} px²", "vi-b vi-end"))
    count, sums = len(squares), [svg.short(float(total)) for total in squares.sum(0)]
    lines = (
        f"E = ( {sums[0]} + {sums[1]} ) ÷ ( 2 · {count} )",
        f"= {svg.short(float(squares.sum()) / (2 * count))} px²",
    )
    parts.append(svg.text(2 if in_narrow else 12, 36, "Every arrow, squared: the area of its square", "vi-b"))
    parts.append(svg.text(2 if in_narrow else 12, 54, f"{count} points in two images", "vi-2nd"))
    for k, line in enumerate(lines):
        words = "vi-huge" if k else "vi-mended-title" if in_narrow else "vi-large-words"
        parts.append(svg.text(left + 22 * k, (300 if in_narrow else 370) + 48 * k, line, words))
    return _wrap("".join(parts), size)


def _wrap(inside: str, size: tuple[int, int]) -> str:
    label = "E, the mean of the squared residuals"
    kind = narrow.CLASS if size is NARROW else ""
    return f'<svg class="vi{kind}" viewBox="0 0 {size[0]} {size[1]}" role="img" aria-label="{label}">{inside}</svg>'
