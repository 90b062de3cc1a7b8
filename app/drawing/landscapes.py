"""Landscapes of all transfers side by side, and the basin of attraction of one over its landscape, with words."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.convergence import Basin, Place
from viewimit.analysis.minima import TransferStudy
from viewimit.drawing import svg
from viewimit.drawing.landscape import SMALL_WIDTH, draw_bars, draw_small, small_plane
from viewimit.drawing.posture_plane import PosturePlane
from viewimit.estimation.transfers import TRANSFERS
from viewimit.simulation.scene import Scene
from viewimit.wording import sentences

GAP, ROW = 10, 111  # px between columns, height of a row
MAX_HEIGHT, TOP = 62, 15  # px of a plot, and above it
TOTAL = 2 * SMALL_WIDTH + GAP
MARK = 4.6  # px, half the size of a start's mark
CLASSES: dict[Place, str] = {"demonstrator": "there", "smallest E": "lowest", "elsewhere": "elsewhere"}


def draw_compared(scene: Scene, studied: TransferStudy, theta_demo: NDArray[np.float64]) -> str:
    """Draw one transfer's landscape with its words. theta_demo: (2,) rad."""
    plane = small_plane(scene, MAX_HEIGHT)
    drawing = draw_small(plane, studied.landscape, studied.minima.theta, theta_demo)
    return _placed(studied.transfer, drawing, describe_landscape(studied), plane.box)


def draw_costs(joints: Sequence[int], transfer: str, spread: NDArray[np.float64] | None) -> str:
    """Draw what 1 px of noise costs at each joint, (m,) rad, by one transfer; None with too few points."""
    bars = "" if spread is None else draw_bars(joints, spread, SMALL_WIDTH, (MAX_HEIGHT + 10) / len(joints))
    words = "Fewer than five points are visible." if spread is None else "° per pixel of noise"
    return _placed(transfer, bars, words, (8, 0, SMALL_WIDTH, MAX_HEIGHT))


def draw_together(drawn: Sequence[str]) -> str:
    """Arrange the transfers' drawings in two columns, as HTML."""
    move = lambda k: f"translate({(SMALL_WIDTH + GAP) * (k % 2)} {ROW * (k // 2)})"
    return _wrap("".join(f'<g transform="{move(k)}">{one}</g>' for k, one in enumerate(drawn)), len(drawn))


def _placed(transfer: str, drawing: str, words: str, box: tuple[float, float, float, float]) -> str:
    """Add title and words to a drawing. box: of its plot, px."""
    return (
        f'<text class="vi-b" x="{box[0]:.1f}" y="10">{svg.escape(TRANSFERS[transfer].title)}</text>'
        f'<g transform="translate(0 {TOP})">{drawing}</g>{svg.text(4, TOP + box[3] + 25, words, "vi-2nd")}'
    )


def _height(count: int) -> int:
    """Return the height of this number of transfers in two columns, px."""
    return ROW * -(-count // 2)


def _wrap(inside: str, count: int) -> str:
    box = f"0 0 {TOTAL} {_height(count)}"
    return f'<div class="vi-panel"><svg class="vi vi-transfers" viewBox="{box}">{inside}</svg></div>'


def waiting(words: str) -> str:
    """Draw a sentence instead of the landscapes."""
    count = len(TRANSFERS)
    return _wrap(svg.text(TOTAL / 2, _height(count) / 2, words, "vi-2nd vi-mid"), count)


def describe_landscape(studied: TransferStudy) -> str:
    """Say bias and shape of a landscape in a few words."""
    count = len(studied.minima)
    if count == 0:
        return "no minimum"
    bias, share = svg.number(float(np.abs(studied.bias_deg).max())), svg.number(100 * studied.basin, 0)
    return f"bias {bias}° · {count} {'minimum' if count == 1 else 'minima'} · basin {share} %"


def draw_basin(scene: Scene, found: Basin) -> str:
    """Draw a mark at each start by where its run ends, hollow without a claim to have arrived; with the counts."""
    plane = PosturePlane(scene)
    places = plane.place(np.degrees(found.starts))
    waiting = places[len(found.endings) :]
    parts = [f'<path class="vi-basin-waiting" d="{svg.dots(waiting)}"/>'] if len(waiting) else []
    marks = []
    for place, ending in zip(places, found.endings):
        if ending.place == "elsewhere":
            end = plane.place(np.degrees(ending.end))
            parts.append(f'<path class="vi-basin-way" d="{svg.segments(place[None], end[None])}"/>')
        marks.append(_mark(ending.place, place, "" if ending.claimed else " vi-basin-hollow"))
    parts += marks
    return plane.wrap("".join(parts), "vi-over") + f'<div class="vi-basin">{describe_basin(found)}</div>'


def describe_basin(found: Basin) -> str:
    """Count how many runs end where and how many claim to have arrived, as HTML."""
    count, made = found.count, len(found.endings)
    if made < len(found.starts):
        return f"{made} of {len(found.starts)} learners have come to rest …"
    said = (
        f"{_icon('demonstrator')} <b>{count('demonstrator')} of {made}</b> end at the demonstrator,"
        f" {_icon('smallest E')} {count('smallest E')} at the smallest E, {_icon('elsewhere')} {count('elsewhere')}"
        " elsewhere."
    )
    claims, false = sum(count(place, True) for place in CLASSES), count("elsewhere", True)
    if not claims:
        return sentences(said, "None claims to have converged.")
    how_many = f"<b>{false} of them falsely</b>" if false else "none of them falsely"
    return sentences(said, f"{claims} claim to have converged (filled), {how_many}.")


def _mark(where: Place, place: NDArray[np.float64], more: str = "") -> str:
    x, y = place.tolist()
    classes = f'class="vi-basin-mark vi-basin-{CLASSES[where]}{more}"'
    if where == "demonstrator":
        return f'<circle {classes} cx="{x:.1f}" cy="{y:.1f}" r="{MARK}"/>'
    if where == "smallest E":
        return f'<path {classes} d="M{x:.1f} {y - MARK - 1:.1f}l{MARK + 1:g} {2 * MARK:g}h-{2 * MARK + 2:g}z"/>'
    return f'<path {classes} d="M{x - MARK:.1f} {y - MARK:.1f}h{2 * MARK:g}v{2 * MARK:g}h-{2 * MARK:g}z"/>'


def _icon(where: Place) -> str:
    """Draw a mark in a sentence."""
    return f'<svg viewBox="0 0 14 14" width="13" height="13">{_mark(where, np.full(2, 7.0))}</svg>'
