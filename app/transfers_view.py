"""The landscapes of all transfers beside each other, and what each makes of the same demonstrator, in words."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from viewimit.scene import Scene

from . import svg
from .methods import TRANSFER_NOTES
from .observability_view import draw_bars
from .small_landscape import WIDTH, Studied, draw_small, small_plane

GAP, ROW = 10, 131  # px between columns, a row's height
MOST_HIGH, TOP = 82, 15  # px of a plot, and from its row's top
TOTAL = (2 * WIDTH + GAP, 2 * ROW)


def draw_transfers(scene: Scene, studied: Sequence[Studied], theta_demo: NDArray) -> str:
    """HTML, two by two."""
    plane = small_plane(scene, MOST_HIGH)
    return _two_by_two(
        {one.transfer: (draw_small(plane, one, theta_demo), describe(one)) for one in studied}, plane.box
    )


def draw_costs(joints: Sequence[int], spreads: dict[str, NDArray | None]) -> str:
    """HTML, two by two, without two moving joints: what 1 px of noise costs at each. spreads: by transfer, rad/px."""
    drawn = {}
    for transfer, spread in spreads.items():
        if spread is None:
            drawn[transfer] = "", "fewer than five points are seen"
        else:
            drawn[transfer] = draw_bars(joints, spread, WIDTH, (MOST_HIGH + 10) / len(joints)), "° a px of noise"
    return _two_by_two(drawn, (8, 0, WIDTH, MOST_HIGH))


def _two_by_two(drawn: dict[str, tuple[str, str]], box: tuple[float, float, float, float]) -> str:
    """drawn: a drawing and words for below it, by transfer; box: px of its plot."""
    parts = []
    for k, (transfer, (drawing, words)) in enumerate(drawn.items()):
        x, y = (WIDTH + GAP) * (k % 2), ROW * (k // 2)
        parts.append(
            f'<g transform="translate({x} {y})">'
            f'<text class="vi-b" x="{box[0]:.1f}" y="10">{svg.escape(TRANSFER_NOTES[transfer].name)}</text>'
            f'<g transform="translate(0 {TOP})">{drawing}</g>'
            f"{svg.text(4, TOP + box[3] + 25, words, 'vi-2nd')}</g>"
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
