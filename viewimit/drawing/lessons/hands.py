"""Where hands go, large: their paths and the arms that draw them, in an image or from the side, up to a moment; and
below how far they are apart on the way."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .. import svg
from ..plots import Axes, decade_ticks, decades, log10

WIDTH, HEIGHT, CURVE_HIGH = 340, 500, 104  # units
MARGIN = 24  # units around the drawing
HEAD_ROOM = 30  # units, for the name
ROW, SAMPLE = 19, 26  # units: of names below the drawing, and of the line before each
BARS = (1, 2, 5, 10, 20, 50, 100, 200, 500)  # of the scale, in its unit


@dataclass(frozen=True)
class Hand:
    """role: demonstrator, recovered, learner or opponent; path: (T, 2), NaN where there is none; skeleton: (T, k, 2)
    from base to hand, None for none; still: the arm is seen, its path is not."""

    name: str
    role: str
    path: NDArray
    skeleton: NDArray | None = None
    still: bool = False


@dataclass(frozen=True)
class Curve:
    """values: (T,) over the way, by name and role; around: what its logarithmic axis shows in any case."""

    title: str
    unit: str
    values: Sequence[tuple[str, str, NDArray]]
    around: tuple[float, float]


@dataclass(frozen=True)
class Picture:
    """name, caption: over it; room: (k, 2) that it holds; upwards: its second axis; unit: of its scale's bar, and how
    many of those one of its axes is; names_at: share of the width at which names of
    lines begin."""

    name: str
    caption: str
    room: NDArray
    upwards: bool
    unit: str
    units: float
    names_at: float = 0.04


def draw_hands(picture: Picture, hands: Sequence[Hand], curves: Sequence[Curve], so_far: int | None) -> str:
    """HTML. so_far: the frame that is shown, None for the whole way."""
    high = HEIGHT - len(curves) * CURVE_HIGH
    place = _placing(picture, high, ROW * len(hands))
    parts = [f'<rect class="vi-plane" x=".5" y=".5" width="{WIDTH - 1}" height="{high - 1}" rx="4"/>']
    for hand in hands:
        parts.append(_arm(hand, place, so_far))
    for hand in hands:
        parts.append(_path(hand, place, so_far))
    left = WIDTH * picture.names_at
    parts += [_name(hand, left, high - 12 - ROW * (len(hands) - 1 - k)) for k, hand in enumerate(hands)]
    parts.append(f'<text class="vi-name vi-halo vi-view-name" x="10" y="22">{svg.escape(picture.name)}</text>')
    at = (30, 21) if len(picture.name) == 1 else (10, 40)
    parts.append(svg.text(*at, picture.caption, "vi-2nd vi-halo vi-line-words"))
    parts.append(_scale_bar(picture, place, high))
    for k, curve in enumerate(curves):
        parts.append(_curve(curve, high + k * CURVE_HIGH, so_far))
    label = f"{picture.name}: {picture.caption}"
    return (
        f'<svg class="vi vi-large-view" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{svg.escape(label)}">'
        f"{''.join(parts)}</svg>"
    )


@dataclass(frozen=True)
class _Placing:
    low: NDArray
    scale: float
    upwards: bool
    high: float

    def __call__(self, points: NDArray) -> NDArray:
        at = (points - self.low) * self.scale
        return np.stack([at[..., 0], self.high - at[..., 1]], -1) if self.upwards else at


def _placing(picture: Picture, high: float, foot: float) -> _Placing:
    """What it holds, in the middle, below its name and above the names of its lines."""
    low, top = np.nanmin(picture.room, 0), np.nanmax(picture.room, 0)
    size = np.array([WIDTH, high - HEAD_ROOM - foot]) - 2 * MARGIN
    scale = float((size / np.maximum(top - low, 1e-9)).min())
    middle = np.array([WIDTH / 2, high / 2 + (-1 if picture.upwards else 1) * (HEAD_ROOM - foot) / 2])
    return _Placing((low + top) / 2 - middle / scale, scale, picture.upwards, high)


def _arm(hand: Hand, place: _Placing, so_far: int | None) -> str:
    if hand.skeleton is None:
        return ""
    bones = svg.path(place(hand.skeleton[-1 if so_far is None else min(so_far, len(hand.skeleton) - 1)]))
    drawn = f'<path class="vi-limb" d="{bones}"/><path class="vi-limb-line" d="{bones}"/>'
    return f'<g class="vi-hand-{hand.role}">{drawn}</g>'


def _path(hand: Hand, place: _Placing, so_far: int | None) -> str:
    if hand.still or not np.isfinite(hand.path).all(-1).any():
        return ""
    points = place(hand.path[: None if so_far is None else so_far + 1])
    line = svg.path(points)
    drawn = f'<path class="vi-hand-line" d="{line}"/>'
    end = points[-1:]
    if hand.role in ("demonstrator", "recovered"):
        drawn += f'<path class="vi-hand-mark" d="{svg.diamonds(end, 5.5)}"/>'
    else:
        drawn += f'<path class="vi-hand-dot" d="{svg.dots(end)}"/>'
    return f'<g class="vi-hand-{hand.role}">{drawn}</g>'


def _name(hand: Hand, x: float, y: float) -> str:
    """A row that tells what a line is."""
    line = f'<path class="{"vi-limb" if hand.still else "vi-hand-line"}" d="M{x:.1f} {y - 5:.1f}h{SAMPLE}"/>'
    words = svg.text(x + SAMPLE + 9, y, hand.name, f"vi-hand-name vi-hand-{hand.role}")
    return f'<g class="vi-hand-{hand.role}">{line}</g>{words}'


def _scale_bar(picture: Picture, place: _Placing, high: float) -> str:
    scale = place.scale / picture.units
    length = max((size for size in BARS if size * scale < WIDTH / 3), default=BARS[0])
    x, y = WIDTH - 12, high - 10
    bar = f'<path class="vi-lead" d="M{x - length * scale:.1f} {y}H{x}"/>'
    return bar + svg.text(x, y - 5, f"{length:g} {picture.unit}", "vi-2nd vi-end vi-halo vi-line-words")


def _curve(curve: Curve, top: float, so_far: int | None) -> str:
    y = decades(np.concatenate([values for _, _, values in curve.values] or [np.array([])]), *curve.around)
    count = max((len(values) for _, _, values in curve.values), default=2)
    plot = Axes((40, top + 37, WIDTH - 12, top + CURVE_HIGH - 8), (0.0, count - 1.0), y, up=log10)
    ticks = decade_ticks(*y, 3)
    parts = [
        f'<g class="vi-hand-plot">{plot.title(curve.title, curve.unit, 0, top + 26)}{plot.frame("", "", (), ticks)}</g>'
    ]
    for name, role, values in curve.values:
        shown = values[: None if so_far is None else so_far + 1]
        points = plot.place(np.arange(len(shown), dtype=float), np.maximum(shown, y[0]))
        drawn = f'<path class="vi-hand-line" d="{svg.path(points)}"/>'
        drawn += f'<path class="vi-hand-dot" d="{svg.dots(points[-1:])}"/>'
        parts.append(f'<g class="vi-hand-{role}">{drawn}</g>')
        at = plot.place(np.array([0.0]), values[:1])[0]
        if name:
            parts.append(svg.text(at[0] + 6, at[1] - 7, name, f"vi-hand-name vi-hand-{role} vi-halo"))
    return "".join(parts)
