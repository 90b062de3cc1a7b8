"""The landscapes of all transfers beside each other, and what each makes of the same demonstrator, in words."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..analysis.minima import TransferStudy
from ..estimation.transfers import TRANSFERS
from ..simulation.scene import Scene
from . import svg
from .observability import draw_bars
from .small_landscape import WIDTH, draw_small, small_plane

GAP, ROW = 10, 111  # px between columns, a row's height
MOST_HIGH, TOP = 62, 15  # px of a plot, and from its row's top
TOTAL = 2 * WIDTH + GAP


def draw_compared(scene: Scene, studied: TransferStudy, theta_demo: NDArray) -> str:
    """One transfer's landscape."""
    plane = small_plane(scene, MOST_HIGH)
    drawing = draw_small(plane, studied.landscape, studied.minima.theta, theta_demo)
    return _placed(studied.transfer, drawing, describe(studied), plane.box)


def draw_costs(joints: Sequence[int], transfer: str, spread: NDArray | None) -> str:
    """One transfer without two moving joints: what 1 px of noise costs at each, (m,) rad; None with too few points."""
    bars, words = "", "fewer than five points are seen"
    if spread is not None:
        bars, words = draw_bars(joints, spread, WIDTH, (MOST_HIGH + 10) / len(joints)), "° a px of noise"
    return _placed(transfer, bars, words, (8, 0, WIDTH, MOST_HIGH))


def draw_together(drawn: Sequence[str]) -> str:
    """HTML, in two columns."""
    parts = []
    for k, one in enumerate(drawn):
        parts.append(f'<g transform="translate({(WIDTH + GAP) * (k % 2)} {ROW * (k // 2)})">{one}</g>')
    return _wrap("".join(parts), len(drawn))


def _placed(transfer: str, drawing: str, words: str, box: tuple[float, float, float, float]) -> str:
    """box: px of the drawing's plot."""
    return (
        f'<text class="vi-b" x="{box[0]:.1f}" y="10">{svg.escape(TRANSFERS[transfer].title)}</text>'
        f'<g transform="translate(0 {TOP})">{drawing}</g>{svg.text(4, TOP + box[3] + 25, words, "vi-2nd")}'
    )


def _height(count: int) -> int:
    """px, of so many transfers."""
    return ROW * -(-count // 2)


def _wrap(inside: str, count: int) -> str:
    box = f"0 0 {TOTAL} {_height(count)}"
    return f'<div class="vi-panel"><svg class="vi vi-transfers" viewBox="{box}">{inside}</svg></div>'


def waiting(words: str) -> str:
    """While they are computed, or where there are none."""
    count = len(TRANSFERS)
    return _wrap(svg.text(TOTAL / 2, _height(count) / 2, words, "vi-2nd vi-mid"), count)


def describe(studied: TransferStudy) -> str:
    """Bias and shape of a landscape, short."""
    count = len(studied.minima)
    if count == 0:
        return "no minimum"
    bias = svg.number(float(np.abs(studied.bias_deg).max()))
    minima = "1 minimum" if count == 1 else f"{count} minima"
    return f"bias {bias}° · {minima} · basin {svg.number(100 * studied.basin, 0)} %"
