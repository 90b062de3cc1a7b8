"""What the visitor marks, in ink and cased in paper: a cross hair, and how far it is from the truth."""

import numpy as np
from numpy.typing import NDArray

from .. import svg

RADIUS, ARM = 9.5, 15  # units: of the ring, and how far its lines go
CROWD = 4.5  # units from the middle of one of a crowd's marks to its ends, to either side
PILL = (52, 19)  # units


def cross_hair(at: NDArray, name: str, size: tuple[float, float], below: bool = False) -> str:
    """At (2,) units of a drawing of that size. below: its name is, not beside it."""
    x, y = at.tolist()
    inner = ARM - 8
    lines = "".join(
        f"M{x + dx * inner:.1f} {y + dy * inner:.1f}L{x + dx * ARM:.1f} {y + dy * ARM:.1f}"
        for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1))
    )
    hair = svg.circles(at[None], RADIUS) + lines
    left = x > size[0] - 90
    place, anchor = (
        ((x, y + 29), " vi-mid") if below else ((x + (-20 if left else 20), y + 4), " vi-end" if left else "")
    )
    words = svg.text(*place, name, f"vi-b vi-halo{anchor}")
    return f'<g class="vi-you"><path class="vi-you-case" d="{hair}"/><path class="vi-you-line" d="{hair}"/>{words}</g>'


def room(at: NDArray, name: str, width: float) -> NDArray:
    """(2, 4) left, top, right, bottom: what a cross hair and its name take in a drawing of that width."""
    x, y = at.tolist()
    long = 7.2 * len(name) + 20
    left = x - long if x > width - 90 else x
    return np.array([[x - ARM, y - ARM, x + ARM, y + ARM], [left, y - 8, left + long, y + 8]])


def distance(at: NDArray, to: NDArray, words: str) -> str:
    """A line between both, and how long it is, beside its middle."""
    dash = f'<path class="vi-apart" d="{svg.segments(at[None], to[None])}"/>'
    if not words:
        return dash
    across = np.array([-(to - at)[1], (to - at)[0]])
    length = float(np.hypot(*across))
    offset = np.array([-1.0, 0.0]) if length < 1 else across / length * (1 if across[0] <= 0 else -1)
    x, y = (at + to) / 2 + 44 * offset
    w, h = PILL
    pill = f'<rect class="vi-pill" x="{x - w / 2:.1f}" y="{y - h / 2:.1f}" width="{w}" height="{h}" rx="{h / 2}"/>'
    return dash + pill + svg.text(x, y + 4, words, "vi-pill-words vi-b vi-mid")


def crowd(at: NDArray) -> str:
    """Crosses that lean, without a name, at (k, 2) units of a drawing."""
    d = 2 * CROWD
    crosses = "".join(f"M{x - CROWD:.1f} {y - CROWD:.1f}l{d:g} {d:g}m0-{d:g}l-{d:g} {d:g}" for x, y in at.tolist())
    return f'<path class="vi-crowd-case" d="{crosses}"/><path class="vi-crowd" d="{crosses}"/>'
