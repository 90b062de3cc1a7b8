"""Two methods from the same starts: how far each ended from the demonstrator, what that comes to, and what came of
other choices before."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import svg
from ..plots import Axes, decade_ticks, log10
from . import narrow

SIZE = (480, 460)  # units
PLOT = (46, 62, 470, 420)  # units: left, top, right, bottom
NARROW, NARROW_PLOT = (narrow.WIDTH, 360), (40, 82, 358, 318)
RANGE = (0.01, 180.0)  # degrees


@dataclass(frozen=True)
class Method:
    """off_deg: (k,) at the end of as many runs as were made; motions: (k,) of each; there: how many came there."""

    name: str
    role: str
    off_deg: NDArray
    motions: NDArray
    there: int


@dataclass(frozen=True)
class Choice:
    """Of an earlier scene or this. seed: its number; what: the choice; yours, others: how many came there."""

    seed: int
    what: str
    yours: int
    others: int
    now: bool


def draw_rounds(
    methods: Sequence[Method], count: int, most_motions: int, within: float, in_narrow: bool = False
) -> str:
    """HTML. count: of runs each; most_motions: of a run; within: degrees of the demonstrator, that count as there."""
    size, box = (NARROW, NARROW_PLOT) if in_narrow else (SIZE, PLOT)
    left, top, right, _ = box
    plot = Axes(box, (0.4, count + 0.6), RANGE, up=log10)
    ticks = [(k, str(k)) for k in range(1, count + 1) if k == 1 or k % 5 == 0]
    parts = [
        plot.frame(
            "Off the demonstrator at the end",
            "degrees" if in_narrow else f"degrees, after {most_motions} motions at most",
            ticks,
            decade_ticks(*RANGE, 4),
            left - 8,
        )
    ]
    parts.append(svg.text((left + right) / 2, size[1] - 6, "start", "vi-2nd vi-mid"))
    parts.append(plot.level(within, "vi-goal"))
    x_goal, y = (2, 44) if in_narrow else (300, 18)
    parts.append(
        f'<path class="vi-goal" d="M{x_goal} {y - 5}h30"/>'
        + svg.text(x_goal + 37, y, f"within {within:g}°: there", "vi-of-found")
    )
    if not any(len(one.off_deg) for one in methods):
        middle = (left + right) / 2, (top + float(plot.y_px(within))) / 2
        parts.append(svg.text(*middle, f"both will be run from the same {count} starts", "vi-2nd vi-halo vi-mid"))
    places = [plot.place(np.arange(1.0, len(one.off_deg) + 1), np.clip(one.off_deg, *RANGE)) for one in methods]
    if len(places) == 2 and len(places[0]):
        parts.append(f'<path class="vi-round-link" d="{svg.segments(places[0], places[1])}"/>')
    for k, (one, at) in enumerate(zip(methods, places)):
        x = 2.0 + 134 * k
        parts.append(_marks(one.role, at) + _marks(one.role, np.array([[x + 8, 13.0]])))
        parts.append(svg.text(x + 22, 18.0, one.name, f"vi-hand-name vi-way-{one.role}-words"))
    label = "Off the demonstrator at the end, by start"
    kind, view_box = narrow.CLASS if in_narrow else "", f"0 0 {size[0]} {size[1]}"
    drawn = (
        f'<svg class="vi vi-rounds{kind}" viewBox="{view_box}" role="img" aria-label="{label}">{"".join(parts)}</svg>'
    )
    return drawn + _table(methods, within)


def _marks(role: str, at: NDArray) -> str:
    """Yours are squares on their tips, the page's discs."""
    if role == "you":
        return f'<path class="vi-round-you" d="{svg.diamonds(at, 6)}"/>'
    return f'<path class="vi-way-{role} vi-round-dot" d="{svg.dots(at)}"/>'


def _table(methods: Sequence[Method], within: float) -> str:
    heads = ("choice", f"there, within {within:g}°", "off, median", "motions, median")
    rows = []
    for one in methods:
        runs = len(one.off_deg)
        cells = [f"{one.there} of {runs}" if runs else "–"]
        cells.append(f"{svg.short(float(np.median(one.off_deg)))}°" if runs else "–")
        cells.append(svg.number(float(np.median(one.motions)), 0) if runs else "–")
        kind = ' class="vi-own-row"' if one.role == "you" else ""
        rows.append(f"<tr{kind}><td>{svg.escape(one.name)}</td>{_cells(cells)}</tr>")
    return f'<table class="vi-standings vi-rounds-table">{_head(heads)}<tbody>{"".join(rows)}</tbody></table>'


def draw_choices(choices: Sequence[Choice]) -> str:
    """HTML: a table of all results so far, the newest first; nothing without any."""
    if not choices:
        return ""
    heads = ("your results so far", "there", "the page")
    rows = []
    for one in reversed(choices):
        kind = ' class="vi-own-row"' if one.now else ""
        what = f"scene {one.seed}: {one.what}"
        rows.append(f"<tr{kind}><td>{svg.escape(what)}</td>{_cells([str(one.yours), str(one.others)])}</tr>")
    return f'<table class="vi-standings vi-choices">{_head(heads)}<tbody>{"".join(rows)}</tbody></table>'


def _head(words: Sequence[str]) -> str:
    return f"<thead><tr>{''.join(f'<th>{svg.escape(word)}</th>' for word in words)}</tr></thead>"


def _cells(words: Sequence[str]) -> str:
    return "".join(f"<td>{svg.escape(word)}</td>" for word in words)
