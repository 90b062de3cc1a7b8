"""The panel Images: the learner's four image planes and what the transfer says about them."""

import math
from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from ...analysis.construction import Construction
from ...estimation.views import VIEWS
from ...geometry.affine import INTO, SOURCE
from ...loop.snapshot import Snapshot
from ...simulation.appearance import Bodies
from .. import svg
from ..glossary import ask
from ..metrics import draw_legend, draw_metrics, residual_lengths
from ..theme import HEAD, OBSERVED, RECOVERED, RING
from . import construction as build
from . import planes
from .planes import SIZES, Window, Windows

GAINS = (10, 5, 2)
READOUT_UP = 17  # px from the foot of L and R, where a caption lies over both
SMALL, LONGEST = 8.0, 20.0  # px: below SMALL the residuals are drawn larger, but not longer than LONGEST
NO_PICTURES: Mapping[str, bytes] = MappingProxyType({})
CAPTIONS = {"own": "the learner sees itself", "demo": "sees the demonstrator"}  # over L and R, over l and r
RECTIFIED = {**CAPTIONS, "own": "the learner sees itself; all four then rectified"}


def draw_images(
    snapshot: Snapshot,
    bodies: Bodies,
    windows: Windows,
    chosen: int | None = None,
    whole_frames: bool = False,
    gain: float | None = None,
    pictures: Mapping[str, bytes] = NO_PICTURES,
    standing: Bodies | None = None,
    construction: Construction | None = None,
    stage: int | None = None,
) -> str:
    """HTML of the panel: a drawing of each image, the legend and the figures, which the page places.

    chosen: a body point, to be ringed, with its construction, of which all is shown or a stage; gain: of the residual
    arrows, None for automatic; pictures: JPEGs of the whole frames by view, which stand behind the drawing; standing:
    where the learner is, if what is drawn is a see-through arm elsewhere.
    """
    shown = windows[whole_frames]
    lengths = residual_lengths(snapshot)
    gain = arrow_gain(lengths) if gain is None else gain
    images = np.concatenate([snapshot.views.demo, snapshot.views.own], 1)
    images = images.reshape(-1, 4, 2).transpose(1, 0, 2)  # (l r L R, N, 2)
    points = planes.placed(images, shown, "lrLR")
    marks = _own_marks(snapshot, points[2:], shown, gain) | _seen_marks(snapshot, points[:2])
    crossed = snapshot.method.crosses_lines
    lines = _epipolar_lines(snapshot, shown, chosen if crossed else None, stage)
    built = dict.fromkeys("lrLR", "")
    if construction is not None and chosen is not None:
        built = build.draw(construction, shown, stage, images[2:, chosen], gain)
    content = _arms(bodies, windows, whole_frames)
    if standing is not None:
        for view, (hulls, _) in planes.draw_arm(standing.own, windows, whole_frames, "LR").items():
            content[view] = f'<path class="vi-standing" d="{hulls}"/>{content[view]}'
    kind = "vi-images vi-whole" if whole_frames else "vi-images"
    kind += "" if stage is None else " vi-building"
    kind += " vi-pictured" if pictures else "" if standing is None else " vi-see-through"
    parts, rings = [], ["", "", "", ""] if chosen is None else _rings(snapshot, points, chosen)
    for k, view in enumerate("lrLR"):
        behind = planes.photograph(pictures[view], shown[view], bodies.frame) if view in pictures else ""
        all_points = marks[view] if stage is None else f'<g class="vi-faint">{marks[view]}</g>'
        inside = behind + content[view] + lines[view] + all_points + built[view]
        if build.stands(stage, crossed, view if view in "lr" else "own"):
            inside += rings[k]
        if view in "LR" and chosen is not None and build.stands(stage, crossed, "own"):
            inside += _readout(snapshot, chosen, k - 2, shown[view], SIZES[whole_frames][view])
        parts.append(planes.plane(view, shown[view], whole_frames, bodies.frame, inside))
    captions = CAPTIONS if snapshot.rectification is None else RECTIFIED
    parts += [
        f'<div class="vi-caption vi-over-{pair}">{words} {ask(f"{pair}_views")}</div>'
        for pair, words in captions.items()
    ]
    if chosen is not None:
        parts.append(f'<p class="vi-how">{build.describe(construction, chosen, stage, crossed)}</p>')
    parts.append(draw_legend(gain, chosen, crossed))
    parts.append(draw_metrics(snapshot, lengths))
    inside = "".join(parts)
    four = f'<div class="{kind}" role="group" aria-label="The four images">{inside}</div>'
    return f'<div class="vi-panel vi-four">{four}</div>'


def arrow_gain(lengths: NDArray) -> float:
    """How many times longer than they are residuals of these lengths, px, are drawn: 1, 2, 5 or 10."""
    largest = lengths.max(initial=0.0)
    if lengths.size == 0 or largest >= SMALL:
        return 1
    return next((gain for gain in GAINS if gain * largest <= LONGEST), 1)


def _arms(bodies: Bodies, windows: Windows, whole: bool) -> dict[str, str]:
    """Silhouettes and skeletons by view; in L and R also the recovered skeleton."""
    drawn = {}
    for view, (hulls, bones) in planes.draw_arm(bodies.demo, windows, whole, "lr").items():
        drawn[view] = f'<g class="vi-demo"><path class="vi-hull" d="{hulls}"/><path class="vi-bone" d="{bones}"/></g>'
    found = {"L": "", "R": ""}
    if bodies.recovered is not None:
        both = planes.placed(bodies.recovered, windows[whole], "LR")
        found = {view: f'<path class="vi-bone vi-found" d="{d}"/>' for view, d in zip("LR", svg.paths(both))}
    for view, (hulls, bones) in planes.draw_arm(bodies.own, windows, whole, "LR").items():
        drawn[view] = f'<path class="vi-hull" d="{hulls}"/><path class="vi-bone" d="{bones}"/>{found[view]}'
    return drawn


def _seen_marks(snapshot: Snapshot, points: NDArray) -> dict[str, str]:
    """Observed demonstrator points in l and r; those not seen in all four images are faint."""
    used, drawn = points[:, snapshot.usable], {}
    for k, view in enumerate("lr"):
        drawn[view] = f'<path class="vi-seen" d="{_observed(used[k].tobytes())}"/>'
    for k, idle in _idle(snapshot, "lr"):
        drawn["lr"[k]] += f'<path class="vi-seen vi-idle" d="{_observed(points[k, idle].tobytes())}"/>'
    return drawn


@lru_cache(256)  # the demonstrator mostly rests while the learner moves
def _observed(points: bytes) -> str:
    return svg.diamonds(np.frombuffer(points).reshape(-1, 2), OBSERVED)


def _own_marks(snapshot: Snapshot, points: NDArray, windows: dict[str, Window], gain: float) -> dict[str, str]:
    """Own points, recovered points and the residuals from these to those, in L and R."""
    own, known = points[:, snapshot.usable], snapshot.transfer is not None
    numbers = _with_residuals(snapshot, own, windows["L"].scale, gain) if known else own.reshape(2, -1)
    drawn = dict(zip("LR", svg.filled(_form(own.shape[1], known), numbers).split("|")))
    for k, idle in _idle(snapshot, "LR"):
        drawn["LR"[k]] += f'<path class="vi-own vi-idle" d="{svg.dots(points[k, idle])}"/>'
    return drawn


def _with_residuals(snapshot: Snapshot, own: NDArray, scale: float, gain: float) -> NDArray:
    """(2, 14 k) px: what `_form` is filled with, in L and in R. own: (2, k, 2) px."""
    e = snapshot.e.reshape(-1, 2, 2).transpose(1, 0, 2)[:, snapshot.usable] * scale  # (L R, k, 2)
    recovered = own - e
    tips = recovered + gain * e
    lines, heads = np.concatenate([recovered, tips], 2), svg.arrow_corners(recovered, tips, HEAD)
    return np.concatenate([numbers.reshape(2, -1) for numbers in (own, recovered, lines, heads)], 1)


@lru_cache(64)
def _form(count: int, known: bool) -> str:
    """Of so many own points in L and R; known: with the recovered ones and the residuals that begin there. One format
    is faster than many."""
    form = f'<path class="vi-own" d="{svg.DOT * count}"/>'
    if known:
        form += (
            f'<path class="vi-found" d="{svg.diamond(RECOVERED) * count}"/>'
            f'<path class="vi-e" d="{svg.SEGMENT * count}"/>'
            f'<path class="vi-tip" d="{svg.TIP * count}"/>'
        )
    return f"{form}|{form}"


def _idle(snapshot: Snapshot, pair: str) -> list[tuple[int, NDArray]]:
    """The places in a pair of those views that show points which not all do, and which points, (N,) bool."""
    if snapshot.views.complete:
        return []
    idle = snapshot.views.visible.T & ~snapshot.usable
    return [(k, idle[view]) for k, view in enumerate(map(VIEWS.index, pair)) if idle[view].any()]


def _rings(snapshot: Snapshot, points: NDArray, chosen: int) -> list[str]:
    """In l, r, L, R; "" where the chosen point is not seen. points: (4, N, 2) px."""
    return [
        f'<circle class="vi-ring" cx="{x:.1f}" cy="{y:.1f}" r="{RING:g}"/>' if seen else ""
        for (x, y), seen in zip(points[:, chosen].tolist(), snapshot.views.visible[chosen].tolist())
    ]


def _readout(snapshot: Snapshot, chosen: int, side: int, window: Window, size: tuple[int, int]) -> str:
    """The chosen point's residual in this image, px, in a corner that the arm leaves free."""
    e = snapshot.e[chosen, 2 * side : 2 * side + 2]
    length = svg.number(math.hypot(*e.tolist()))
    x, end = (6, "") if window.readout_left else (size[0] - 6, " vi-end")
    return svg.text(x, size[1] - READOUT_UP, f"{svg.point_name(chosen)}: {length} px", f"vi-chosen vi-halo{end}")


def _epipolar_lines(
    snapshot: Snapshot, windows: dict[str, Window], chosen: int | None, stage: int | None
) -> dict[str, str]:
    """The chosen point's lines by view: from the left and the right image of the other pair, from the partner. While
    they are built up only those in L and R that are there at the stage."""
    drawn = dict.fromkeys("lrLR", "")
    lines = None if chosen is None else snapshot.epipolar_lines(chosen)
    if chosen is None or lines is None:
        return drawn
    seen = snapshot.views.visible[chosen].tolist()
    for k, source, line in zip(INTO.tolist(), SOURCE.tolist(), lines.tolist()):
        if seen[source] and (stage is None or k > 1 >= source and build.stands(stage, True, ("left", "right")[source])):
            view = "lrLR"[k]
            if d := _chord(line, windows[view]):
                drawn[view] += f'<path class="vi-line{_line_style(source, k)}" d="{d}"/>'
    return drawn


def _line_style(source: int, into: int) -> str:
    if source // 2 == into // 2:
        return " vi-partner"
    return " vi-from-right" if source % 2 else ""


def _chord(line: list[float], window: Window) -> str:
    """A path: what the circle around a window cuts off a line a x + b y + c = 0, image px; "" where they do not meet.
    A dozen lines are soon told number by number: each call of numpy takes as long as one of them."""
    a, b, c = line
    length, middle_x, middle_y = math.hypot(a, b), window.w / 2, window.h / 2
    if not length > 0:
        return ""
    a, b = a / length, b / length
    distance = (window.x + middle_x) * a + (window.y + middle_y) * b + c / length
    square = middle_x * middle_x + middle_y * middle_y - distance * distance
    if not square > 0:
        return ""
    k, half = window.scale, math.sqrt(square)
    x, y = (middle_x - distance * a) * k, (middle_y - distance * b) * k
    along_x, along_y = -half * b * k, half * a * k
    return f"M{x - along_x:.1f} {y - along_y:.1f}L{x + along_x:.1f} {y + along_y:.1f}"
