"""One image, large: the arm in it, and of the layers over it only those that are asked for."""

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...analysis.construction import Construction
from ...estimation.views import Pairs
from ...geometry.affine import LINE_VIEWS, POINT_VIEWS
from ...loop.snapshot import Snapshot
from ...simulation.appearance import ArmImages, Bodies
from .. import svg
from ..theme import HEAD
from . import mark, narrow
from .ellipse import draw_ellipse
from .pair import draw_pairs
from .see_through import LAYERS as OF_SEE_THROUGH
from .see_through import SeeThrough, draw_see_through

SIZES = {  # by how it is shown, and by its name
    "large": dict.fromkeys("lrLR", (340, 500)),
    "small": dict.fromkeys("lr", (200, 226)) | dict.fromkeys("LR", (200, 294)),
    "narrow": dict.fromkeys("lrLR", (300, 420)),
    "half": dict.fromkeys("lrLR", (narrow.HALF, 262)),
    "small half": dict.fromkeys("lr", (narrow.HALF, 200)) | dict.fromkeys("LR", (narrow.HALF, 262)),
}
MARGIN = 14  # image px around the arm
HEAD_ROOM = 16  # units above it, for the name
CAPTIONS = {
    "l": "left eye",
    "r": "right eye",
    "L": "own left eye",
    "R": "own right eye",
}
LAYERS = (
    "points", "own points", "recovered points", "arrows", "skeleton", "chosen", "line from l", "line from r",
    "crossing", "own chosen", "arrow", "ellipse", "framed", "pair", *OF_SEE_THROUGH,
)  # fmt: skip
EYES = {"line from l": 0, "line from r": 1}
LABEL_ALONG = (0.78, 0.22)  # of a line's chord, where its name stands


@dataclass(frozen=True)
class Window:
    """A drawing of (w, h) units shows px (x, y) at its corner, `scale` times as large."""

    corner: NDArray
    scale: float
    size: tuple[int, int]

    def place(self, points: NDArray) -> NDArray:
        """px → units."""
        return (points - self.corner) * self.scale

    def unplace(self, points: NDArray) -> NDArray:
        """units → px"""
        return points / self.scale + self.corner


def window_of(
    view: str, bodies: Bodies, moment: Snapshot, shown: str = "large", see_through: SeeThrough | None = None
) -> Window:
    """That holds the arm, and in L and R the recovered points and a see-through arm. shown: of SIZES."""
    side = "lrLR".index(view) % 2
    arm = bodies.demo if view in "lr" else bodies.own
    parts = [arm.hulls[side].reshape(-1, 2), arm.origins[side]]
    if view in "LR" and moment.transfer is not None:
        parts.append(moment.recovered[moment.usable][:, 2 * side : 2 * side + 2])
    if view in "LR" and see_through is not None:
        parts.append(see_through.room[side])
    points = np.concatenate(parts)
    low, high = points.min(0) - MARGIN, points.max(0) + MARGIN
    above, size = np.array([0, HEAD_ROOM]), np.array(SIZES[shown][view], float)
    scale = float(((size - above) / (high - low)).min())
    return Window((low + high - (size + above) / scale) / 2, scale, SIZES[shown][view])


def draw_view(
    view: str,
    moment: Snapshot,
    bodies: Bodies,
    layers: Collection[str],
    chosen: int | None = None,
    guess: NDArray | None = None,
    distance: str = "",
    shown: str = "large",
    spread: Construction | None = None,
    pairs: Pairs = (),
    see_through: SeeThrough | None = None,
    others: NDArray | None = None,
) -> str:
    """HTML. guess: (2,) px, the visitor's mark; distance: in words, from there to the recovered point; shown: of SIZES;
    spread: of the chosen point, for its ellipse; pairs: points that may be taken for each other; see_through: of which
    the layers about it show what is asked for; others: (k, 2) px, of a class."""
    window = window_of(view, bodies, moment, shown, see_through)
    side, (w, h) = "lrLR".index(view) % 2, window.size
    parts = [_arm(bodies.demo if view in "lr" else bodies.own, side, window, view)]
    images = (moment.views.demo if view in "lr" else moment.views.own)[:, 2 * side : 2 * side + 2]
    seen = moment.views.visible[:, "lrLR".index(view)]
    points = window.place(images)
    if "skeleton" in layers and bodies.recovered is not None:
        parts.append(f'<path class="vi-bone vi-found" d="{svg.path(window.place(bodies.recovered[side]))}"/>')
    parts += _points(view, moment, layers, points, seen, window, side)
    if see_through is not None and view in "LR":
        parts += draw_see_through(see_through, side, layers, window.place)
    if spread is not None and "ellipse" in layers and view in "LR":
        at, half_axes = window.place(spread.recovered[side]), window.scale * spread.half_axes[side]
        parts.append(draw_ellipse(at, half_axes, float(spread.direction[side])))
    if "pair" in layers:
        parts.append(draw_pairs(points, pairs, window.size))
    if chosen is not None and seen[chosen]:
        parts += _chosen(view, moment, layers, points[chosen], chosen, window, side)
    if others is not None:
        parts.append(mark.crowd(window.place(others)))
    if guess is not None:
        parts.append(_guess(view, moment, layers, window.place(guess), chosen, window, side, distance))
    frame = " vi-framed" if "framed" in layers else ""
    name = f'<text class="vi-name vi-halo vi-view-name" x="10" y="22">{view}</text>'
    name += svg.text(30, 21, CAPTIONS[view], "vi-2nd vi-halo")
    plane = f'<rect class="vi-plane{frame}" x=".5" y=".5" width="{w - 1}" height="{h - 1}" rx="4"/>'
    inside = f"{plane}{''.join(parts)}{name}"
    label = f"Image {view}: {CAPTIONS[view]}"
    kind = narrow.CLASS if shown in ("narrow", "half", "small half") else ""
    return f'<svg class="vi vi-large-view{kind}" viewBox="0 0 {w} {h}" role="img" aria-label="{label}">{inside}</svg>'


def _arm(arm: ArmImages, side: int, window: Window, view: str) -> str:
    hulls, bones = window.place(arm.hulls[side])[None], window.place(arm.origins[side])
    drawn = f'<path class="vi-hull" d="{svg.polygons(hulls)[0]}"/><path class="vi-bone" d="{svg.path(bones)}"/>'
    return f'<g class="vi-quiet{" vi-demo" if view in "lr" else ""}">{drawn}</g>'


def _points(
    view: str, moment: Snapshot, layers: Collection[str], points: NDArray, seen: NDArray, window: Window, side: int
) -> list[str]:
    """All body points, where they are asked for."""
    parts = []
    if view in "lr" and "points" in layers:
        parts.append(f'<path class="vi-seen" d="{svg.diamonds(points[seen], 4.4)}"/>')
    if view in "lr" or moment.transfer is None:
        return parts
    usable = moment.usable
    recovered = window.place(moment.recovered[usable][:, 2 * side : 2 * side + 2])
    own = points[usable]
    if "own points" in layers:
        parts.append(f'<path class="vi-own" d="{svg.dots(own)}"/>')
    if "recovered points" in layers:
        parts.append(f'<path class="vi-found" d="{svg.diamonds(recovered, 5)}"/>')
    if "arrows" in layers:
        heads = svg.arrow_tips(recovered[None], own[None], 1.6 * HEAD)[0]
        parts.append(f'<path class="vi-e" d="{svg.segments(recovered, own)}"/><path class="vi-tip" d="{heads}"/>')
    return parts


def _chosen(
    view: str, moment: Snapshot, layers: Collection[str], at: NDArray, chosen: int, window: Window, side: int
) -> list[str]:
    """The point that the step is about, its lines, and where they cross."""
    parts = []
    if view in "LR":
        for k, name in enumerate(("line from l", "line from r")):
            line = line_of(view, moment, chosen, k)
            if name in layers and line is not None:
                parts.append(_line(line, window, name, k))
    if (view in "lr" and "chosen" in layers) or (view in "LR" and "own chosen" in layers):
        style = "seen" if view in "lr" else "own"
        shape = svg.diamonds(at[None], 5.4) if view in "lr" else svg.dots(at[None])
        parts.append(f'<path class="vi-{style}" d="{shape}"/>{_ring(at)}')
    if view in "LR" and moment.usable[chosen]:
        found = window.place(moment.recovered[chosen, 2 * side : 2 * side + 2])
        if "arrow" in layers:
            tip = svg.arrow_tips(found[None, None], at[None, None], 1.6 * HEAD)[0]
            parts.append(
                f'<path class="vi-e" d="{svg.segments(found[None], at[None])}"/><path class="vi-tip" d="{tip}"/>'
            )
        if "crossing" in layers:
            x, y = found.tolist()
            left = x > window.size[0] - 150
            side_x, end = (x - 15, " vi-end") if left else (x + 15, "")
            words = svg.text(side_x, y - 6, "recovered point", f"vi-of-found vi-halo{end}")
            words += svg.text(side_x, y + 8, "where the two lines cross", f"vi-2nd vi-halo{end}")
            parts.append(f'<path class="vi-found" d="{svg.diamonds(found[None], 6)}"/>{_ring(found)}{words}')
    return parts


def line_of(view: str, moment: Snapshot, point: int, eye: int) -> NDArray | None:
    """(3,) the epipolar line, px, that a point in l (0) or r (1) gives in L or R; None if there is none."""
    lines = moment.epipolar_lines(point)
    if lines is None:
        return None
    return lines[int(np.flatnonzero((LINE_VIEWS == "lrLR".index(view)) & (POINT_VIEWS == eye))[0])]


def _line(line: NDArray, window: Window, name: str, eye: int) -> str:
    """Across the drawing, and named along it."""
    normal = line[:2] / np.hypot(*line[:2])
    offset = (line[:2] @ window.corner + line[2]) / np.hypot(*line[:2]) * window.scale  # in units of the drawing
    ends = chord(normal, offset, window.size)
    if ends is None:
        return ""
    first, last = ends
    x, y = first + LABEL_ALONG[eye] * (last - first)
    turn = np.degrees(np.arctan2(*(last - first)[::-1]))
    words = svg.text(0, -6, name, "vi-chosen vi-halo vi-mid")
    words = f'<g transform="translate({x:.1f} {y:.1f})rotate({turn:.1f})">{words}</g>'
    kind = " vi-from-right" if eye else ""
    return (
        f'<path class="vi-line-case" d="{svg.segments(first[None], last[None])}"/>'
        f'<path class="vi-line vi-line-large{kind}" d="{svg.segments(first[None], last[None])}"/>{words}'
    )


def chord(normal: NDArray, offset: float, size: tuple[int, int]) -> tuple[NDArray, NDArray] | None:
    """Where the line n·x + c = 0 enters and leaves the box, from left to right; None if it misses it."""
    w, h = size
    ends = []
    if abs(normal[1]) > 1e-9:
        ends += [(x, -(offset + normal[0] * x) / normal[1]) for x in (0, w)]
    if abs(normal[0]) > 1e-9:
        ends += [(-(offset + normal[1] * y) / normal[0], y) for y in (0, h)]
    inside = sorted({(round(x, 3), round(y, 3)) for x, y in ends if -1e-6 <= x <= w + 1e-6 and -1e-6 <= y <= h + 1e-6})
    if len(inside) < 2:
        return None
    return np.array(inside[0]), np.array(inside[-1])


def _ring(at: NDArray) -> str:
    return f'<circle class="vi-ring" cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="11"/>'


def _guess(
    view: str,
    moment: Snapshot,
    layers: Collection[str],
    at: NDArray,
    chosen: int | None,
    window: Window,
    side: int,
    said: str,
) -> str:
    """The visitor's mark; once the crossing is there, how far it is from that."""
    between = ""
    if "crossing" in layers and chosen is not None:
        found = window.place(moment.recovered[chosen, 2 * side : 2 * side + 2])
        between = mark.distance(at, found, said)
    return between + mark.cross_hair(at, "your mark", window.size, below="crossing" in layers)
