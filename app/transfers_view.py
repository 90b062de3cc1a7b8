"""The landscapes of all transfers beside each other, and what each makes of the same demonstrator, in words."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from viewimit.scene import Scene

from . import svg
from .methods import TRANSFER_NOTES
from .small_landscape import WIDTH, Studied, draw_small, small_plane

GAP, ROW = 10, 131  # px between columns, a row's height
MOST_HIGH, TOP = 82, 15  # px of a plot, and from its row's top
TOTAL = (2 * WIDTH + GAP, 2 * ROW)


def draw_transfers(scene: Scene, studied: Sequence[Studied], theta_demo: NDArray) -> str:
    """HTML, two by two."""
    parts = []
    for k, one in enumerate(studied):
        plane = small_plane(scene, MOST_HIGH)
        left, _, _, high = plane.box
        title = f'<text class="vi-b" x="{left:.1f}" y="10">{svg.escape(TRANSFER_NOTES[one.transfer].name)}</text>'
        words = svg.text(4, TOP + high + 25, describe(one), "vi-2nd")
        x, y = (WIDTH + GAP) * (k % 2), ROW * (k // 2)
        parts.append(
            f'<g transform="translate({x} {y})">{title}<g transform="translate(0 {TOP})">'
            f"{draw_small(plane, one, theta_demo)}</g>{words}</g>"
        )
    return wrap("".join(parts))


def wrap(inside: str) -> str:
    width, height = TOTAL
    return f'<div class="vi-panel"><svg class="vi vi-transfers" viewBox="0 0 {width} {height}">{inside}</svg></div>'


def waiting(words: str) -> str:
    """While they are computed, or where there are none."""
    width, height = TOTAL
    return wrap(svg.text(width / 2, height / 2, words, "vi-2nd vi-mid"))


def describe(studied: Studied) -> str:
    """Bias and shape of a landscape, short."""
    count = len(studied.minima)
    if count == 0:
        return "no minimum"
    bias = svg.number(float(np.abs(studied.bias_deg).max()))
    minima = "1 minimum" if count == 1 else f"{count} minima"
    return f"bias {bias}° · {minima} · basin {svg.number(100 * studied.basin, 0)} %"
