"""How far the smallest E is from the demonstrator, over the distance of the eyes: a curve a transfer, both scales
logarithmic, the present distance marked, and the visitor's prediction."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from .. import svg
from ..plots import Axes, log10
from . import narrow

SIZE = (640, 342)  # units
PLOT = (56, 34, 480, 288)  # left, top, right, bottom
NARROW, NARROW_PLOT = (narrow.WIDTH, 300), (46, 50, 240, 252)
LAYERS = ("curves", "here", "foretold", "found")
FLOOR = 0.01  # degrees, to which smaller ones are raised
HIGHEST = 30.0
Y_TICKS = ((0.01, "0.01°"), (0.1, "0.1°"), (1.0, "1°"), (10.0, "10°"))
X_TICKS = ((1.0, "1 ×"), (3.0, "3 ×"), (10.0, "10 ×"), (30.0, "30 ×"))
NAMES = {
    "epipolar": "epipolar (here)",
    "linear": "linear combination",
    "rank3": "rank 3",
    "projective": "projective",
}
STYLES = {"epipolar": "used", "linear": "second", "rank3": "third", "projective": "exact"}


def draw_biases(
    times: NDArray,
    degrees: Mapping[str, NDArray] | None,
    layers: Collection[str],
    here: float,
    asked: float,
    guess: float | None = None,
    transfer: str = "epipolar",
    in_narrow: bool = False,
) -> str:
    """HTML. times: (K,); degrees: by transfer, (K,), None while they are computed; here: the present distance; asked:
    the distance for which the visitor predicted `guess`, in degrees."""
    size, box = (NARROW, NARROW_PLOT) if in_narrow else (SIZE, PLOT)
    left, top, right, bottom = box
    plot = Axes(box, (1.0, 30.0), (FLOOR, HIGHEST), log10, log10)
    title, note = "From the smallest E to the demonstrator", "the joint that is farthest off"
    parts = [
        plot.title(title, "" if in_narrow else note, 4, 16),
        svg.text(4, 33, note, "vi-2nd") if in_narrow else "",
        plot.rules(Y_TICKS) + plot.beside(Y_TICKS, 8) + plot.below(X_TICKS, 18),
        f'<path class="vi-axis" d="M{left} {top}V{bottom}H{right}"/>',
        svg.text((left + right) / 2, bottom + 42, "distance of the eyes", "vi-mid"),
    ]
    if degrees is None:
        parts.append(svg.text((left + right) / 2, 150, "computing …", "vi-2nd vi-mid"))
        return _wrap("".join(parts), size)
    shown = {name: np.clip(values, FLOOR, HIGHEST) for name, values in degrees.items()}
    if "here" in layers:
        x = float(plot.x_px(here))
        parts.append(f'<path class="vi-here-line" d="M{x:.1f} {top}V{bottom}"/>')
        offset, end = (-6, " vi-end") if x > right - 60 else (6, "")
        parts.append(svg.text(x + offset, top + 11, "here", f"vi-b vi-halo{end}"))
    if "curves" in layers:
        parts.append(_curves(plot, times, degrees, shown))
    elif "here" in layers:
        known = plot.place(times[:1], shown[transfer][:1])
        parts.append(f'<path class="vi-bias-dots vi-bias-used" d="{svg.dots(known)}"/>')
    parts.append(_foretold(plot, times, degrees[transfer], layers, asked, guess))
    return _wrap("".join(parts), size)


def _curves(plot: Axes, times: NDArray, degrees: Mapping[str, NDArray], shown: Mapping[str, NDArray]) -> str:
    """With their names. shown: degrees within the plot."""
    parts, labels = [], []
    for name in reversed(STYLES):  # the one that is used last, on top
        if name not in shown:
            continue
        points, kind = plot.place(times, shown[name]), STYLES[name]
        parts.append(f'<path class="vi-bias vi-bias-{kind}" d="{svg.path(points)}"/>')
        below = " < 0.01°" if degrees[name].max() < FLOOR else ""
        labels.append((float(points[-1, 1]), NAMES[name] + below, f"vi-bias-words-{kind}"))
    return "".join(parts) + plot.labels(labels)


def _foretold(
    plot: Axes, times: NDArray, found: NDArray, layers: Collection[str], asked: float, guess: float | None
) -> str:
    """The visitor's number at the distance that was asked about, and the truth there."""
    parts = []
    truth = np.interp(np.log(asked), np.log(times), found)
    there = plot.place([asked], [np.clip(truth, FLOOR, HIGHEST)])[0]
    if "found" in layers:
        parts.append(f'<path class="vi-bias-ring" d="{svg.circles(there[None], 6.5)}"/>')
        parts.append(svg.text(there[0] + 12, there[1] - 8, f"{svg.short(truth)}°", "vi-b vi-halo"))
    if guess is not None and "foretold" in layers:
        at = plot.place([asked], [np.clip(guess, FLOOR, HIGHEST)])[0]
        if "found" in layers:
            parts.append(f'<path class="vi-apart" d="{svg.segments(at[None], there[None])}"/>')
        hair = svg.circles(at[None], 7)
        parts.append(f'<path class="vi-you-case" d="{hair}"/><path class="vi-you-line" d="{hair}"/>')
        parts.append(svg.text(at[0] - 13, at[1] - 8, f"you: {guess:g}°", "vi-b vi-halo vi-end"))
    return "".join(parts)


def _wrap(inside: str, size: tuple[int, int]) -> str:
    label = "How far the smallest E is from the demonstrator, over the distance of the eyes"
    kind = narrow.CLASS if size is NARROW else ""
    return (
        f'<svg class="vi vi-worded vi-biases{kind}" viewBox="0 0 {size[0]} {size[1]}" role="img" aria-label="{label}">'
        f"{inside}</svg>"
    )
