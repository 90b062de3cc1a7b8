"""Axes of all that is plotted: two scales over a box of px, what stands around it, and labels kept apart."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..loop.settings import Settings
from ..simulation.disturbances import Disturbance
from . import svg
from .labels import CHARACTER

LEAST = 1e-30  # below, a logarithmic axis has no place
MOST_DECADES = 12
APART = 13  # px between labels
GAP = 5  # px from a plot to the words at its left
NICE = (1, 2, 5, 10)  # steps of a linear scale, times a power of ten

Tick = tuple[float, str]  # value, words
Label = tuple[float, str, str]  # height in px, words, classes


def linear(values: ArrayLike) -> NDArray:
    return np.asarray(values, float)


def log10(values: ArrayLike) -> NDArray:
    """NaN for what has no logarithm."""
    values = np.asarray(values, float)
    return np.log10(np.where(values > LEAST, values, np.nan))


@dataclass(frozen=True)
class Axes:
    """box: left, top, right, bottom px; x, y: what the sides stand for, from left to right and from bottom to top;
    across, up: what makes them even, such as log10."""

    box: tuple[float, float, float, float]
    x: tuple[float, float]
    y: tuple[float, float]
    across: Callable[[ArrayLike], NDArray] = linear
    up: Callable[[ArrayLike], NDArray] = linear

    @property
    def left(self) -> float:
        return self.box[0]

    @property
    def top(self) -> float:
        return self.box[1]

    @property
    def right(self) -> float:
        return self.box[2]

    @property
    def bottom(self) -> float:
        return self.box[3]

    def x_px(self, values: ArrayLike) -> NDArray:
        low, high = self._even[0]
        return self.left + (self.right - self.left) * (self.across(values) - low) / (high - low)

    def y_px(self, values: ArrayLike) -> NDArray:
        low, high = self._even[1]
        return self.bottom + (self.top - self.bottom) * (self.up(values) - low) / (high - low)

    def place(self, x: ArrayLike, y: ArrayLike) -> NDArray:
        """(k, 2) px; NaN for what has no place"""
        px_x, px_y = self.x_px(x), self.y_px(y)
        px = np.empty(np.broadcast(px_x, px_y).shape + (2,))
        px[..., 0], px[..., 1] = px_x, px_y
        known = np.isfinite(px)
        if not known.all():
            px[~known.all(-1)] = np.nan
        return px

    def frame(
        self, title: str, note: str = "", x_ticks: Iterable[Tick] = (), y_ticks: Sequence[Tick] = (), out: float = 0
    ) -> str:
        """Title above, `out` px left of the box; rules at y_ticks, words below at x_ticks."""
        sides = f'<path class="vi-axis" d="M{self.left:.1f} {self.top:.1f}V{self.bottom:.1f}H{self.right:.1f}"/>'
        title = self.title(title, note, self.left - out, self.top - 6)
        return title + self.rules(y_ticks) + sides + self.beside(y_ticks) + self.below(x_ticks)

    def title(self, words: str, note: str, x: float, y: float) -> str:
        """x, y: px."""
        return (
            f'<text x="{x:.1f}" y="{y:.1f}"><tspan class="vi-b">{svg.escape(words)}</tspan>'
            f'<tspan class="vi-2nd" dx="5">{svg.escape(note)}</tspan></text>'
        )

    def rules(self, ticks: Iterable[Tick]) -> str:
        """Lines across."""
        return _rules(self, tuple(ticks))

    def beside(self, ticks: Iterable[Tick], gap: float = GAP) -> str:
        """Words at the left."""
        return _beside(self, tuple(ticks), gap)

    def below(self, ticks: Iterable[Tick], drop: float = 13) -> str:
        return _below(self, tuple(ticks), drop)

    def line(self, x: ArrayLike, y: ArrayLike, classes: str) -> str:
        points = self.place(x, y)
        return f'<path class="{classes}" d="{svg.path(points)}"/>' if np.isfinite(points).any() else ""

    def level(self, y: float, classes: str) -> str:
        """A line across."""
        return self.line(np.array(self.x), np.full(2, y), classes)

    def labels(self, labels: Iterable[Label]) -> str:
        """Right of the plot, at the height of what they name, moved apart where they would meet."""
        ordered = sorted(labels)
        places = apart([height for height, _, _ in ordered], self.top + 2, self.bottom - 1)
        x = self.right + 7
        return "".join(svg.text(x, y + 4, words, classes) for y, (_, words, classes) in zip(places, ordered))

    @cached_property
    def _even(self) -> tuple[tuple[float, float], tuple[float, float]]:
        (left, right), (low, high) = self.across(self.x).tolist(), self.up(self.y).tolist()
        return (left, right), (low, high)


# axes stay as they are for many motions, and what stands around them takes longer than the curve does
@lru_cache(256)
def _rules(axes: Axes, ticks: tuple[Tick, ...]) -> str:
    lines = "".join(f"M{axes.left:.1f} {axes.y_px(value):.1f}H{axes.right:.1f}" for value, _ in ticks)
    return f'<path class="vi-rule" d="{lines}"/>'


@lru_cache(256)
def _beside(axes: Axes, ticks: tuple[Tick, ...], gap: float) -> str:
    return "".join(
        svg.text(axes.left - gap, float(axes.y_px(value)) + 4, words, "vi-2nd vi-end") for value, words in ticks
    )


@lru_cache(256)
def _below(axes: Axes, ticks: tuple[Tick, ...], drop: float) -> str:
    return "".join(
        svg.text(float(axes.x_px(value)), axes.bottom + drop, words, "vi-2nd vi-mid") for value, words in ticks
    )


def apart(heights: Sequence[float], top: float, bottom: float) -> list[float]:
    """Ascending heights in px, moved so that they are APART and, where there is room, between top and bottom."""
    y = [min(max(height, top), bottom) for height in heights]
    for _ in range(3):
        for i in range(1, len(y)):
            y[i] = max(y[i], y[i - 1] + APART)
        over = y[-1] - bottom if y else 0
        if over <= 0:
            break
        y[-1] -= over
        for i in range(len(y) - 1, 0, -1):
            y[i - 1] = min(y[i - 1], y[i] - APART)
    return y


def decades(values: ArrayLike, *around: float) -> tuple[float, float]:
    """Powers of ten below and above all positive values and what must be among them; 1 and 1000 if there is none."""
    values = np.append(np.asarray(values, float), around)
    known = values[np.isfinite(values) & (values > 0)]
    if not len(known):
        return 1.0, 1000.0
    first, last = int(np.floor(np.log10(known.min()) + 1e-9)), int(np.ceil(np.log10(known.max()) - 1e-9))
    last = max(last, first + 1)
    return 10.0 ** max(first, last - MOST_DECADES), 10.0**last


def decade_ticks(low: float, high: float, most: int = 4) -> list[Tick]:
    """The powers of ten from low to high, every so many of them."""
    first, last = int(np.ceil(np.log10(low) - 1e-9)), int(np.floor(np.log10(high) + 1e-9))
    every = max(1, -(-(last - first) // most))
    return [(10.0**k, f"{10.0**k:g}" if abs(k) < 5 else f"1e{k}") for k in range(first, last + 1, every)]


def angle_ticks(low: float, high: float, apart: float = 0.0) -> list[Tick]:
    """Of an axis in degrees, so many degrees apart at least, if that is 180 at most."""
    span = high - low
    step = 45 if span > 130 or span == 90 else 30 if span > 45 else 15
    step = next((wider for wider in (step, 90, 180) if wider >= apart), 180)
    return [
        (float(angle), svg.number(angle, 0) + "°") for angle in np.arange(np.ceil(low / step) * step, high + 1e-9, step)
    ]


def linear_ticks(low: float, high: float, most: int = 4) -> list[Tick]:
    """Round values from low to high, at most so many of them and one."""
    power = 10.0 ** np.floor(np.log10((high - low) / most))
    step = next(nice * power for nice in NICE if nice * power * most >= (high - low) * (1 - 1e-9))
    digits = max(0, -int(np.floor(np.log10(step))))
    return [
        (float(value), svg.number(value, digits)) for value in np.arange(np.ceil(low / step) * step, high + 1e-9, step)
    ]


# The experiments' figures: their size and caption, and lines told apart by more than their colour.

WIDTH, HEIGHT = 424, 212  # px of a figure, whatever it shows: nothing below it moves
END = 3.4  # px, half the size of the mark at a line's end
LONGEST = 92  # letters of a caption


class Style(NamedTuple):
    """role: colour; dash: solid, dashed, dash-dot or dotted; mark: circle, diamond, ring or square."""

    role: str
    dash: str
    mark: str

    @property
    def line(self) -> str:
        return f"vi-x vi-x-{self.role} vi-x-{self.dash}"

    def marks(self, places: NDArray, size: float = END) -> str:
        """places: (k, 2) px; those that are NaN are left out."""
        places = places[np.isfinite(places).all(-1)]
        if self.mark == "circle":
            return f'<path class="vi-x-fill-{self.role}" d="{svg.circles(places, size)}"/>'
        d = {"diamond": svg.diamonds, "ring": svg.circles, "square": _squares}[self.mark](places, size)
        return f'<path class="vi-x-hollow vi-x-{self.role}" d="{d}"/>'

    def sample(self, x: float, y: float) -> str:
        """A piece of the line with its mark, for a legend; 22 px wide."""
        return f'<path class="{self.line}" d="M{x:.1f} {y:.1f}h22"/>' + self.marks(np.array([[x + 11, y]]))


STYLES = (
    Style("learner", "solid", "circle"),
    Style("recovered", "dash-dot", "diamond"),
    Style("residual", "dashed", "square"),
    Style("ink", "dotted", "ring"),
    Style("chosen", "solid", "diamond"),
)


def style_of(name: str, names: Iterable[str]) -> Style:
    """Each of a list has a style of its own, the first ones the most distinct."""
    return STYLES[list(names).index(name) % len(STYLES)]


def figure(settings: Settings | None, inside: str, extra: str = "", height: float = HEIGHT) -> str:
    """A drawing with the words of what it was made. extra: what else belongs into them; height: px."""
    words = _caption(described(settings) + extra) if settings else ""
    return f'<svg class="vi vi-figure" viewBox="0 0 {WIDTH} {height:g}">{words}{inside}</svg>'


def _caption(words: str) -> str:
    """Long ones are condensed, and cut off in the end."""
    words = words if len(words) <= LONGEST else words[: LONGEST - 1] + "…"
    fitted = f' textLength="{WIDTH}" lengthAdjust="spacingAndGlyphs"' if CHARACTER * len(words) > WIDTH else ""
    return f'<text class="vi-2nd" x="0" y="10"{fitted}>{svg.escape(words)}</text>'


def described(settings: Settings) -> str:
    """The conditions under which a result was found, in one line."""
    angles = settings.demonstrator_deg or ()  # none: the scene's own
    posture = ", ".join(svg.number(angle, 1 if len(angles) <= 3 else 0) + "°" for angle in angles)
    points = f"{settings.points} points{'' if settings.body_points is None else ' by hand'}"
    said = f"{settings.transfer} transfer · {settings.scene_called}, {points}"
    said = f"Demonstrator ({posture}) · {said}" if posture else said[0].upper() + said[1:]
    disturbed = [found.caption.format(amount) for found, amount in settings.amounts(Disturbance) if amount]
    return " · ".join([said, ", ".join(disturbed)] if disturbed else [said])


def sentence(words: Sequence[str], x: float, y: float) -> str:
    """Lines of an empty figure's sentence, centred at px (x, y)."""
    wide, high = CHARACTER * max(map(len, words)), 15 * len(words) + 8
    box = f'x="{x - wide / 2:.1f}" y="{y - high / 2:.1f}" width="{wide:.1f}" height="{high}" rx="4"'
    lines = [svg.text(x, y - high / 2 + 15 + 15 * k, line, "vi-mid") for k, line in enumerate(words)]
    return f'<rect class="vi-x-blank" {box}/>{"".join(lines)}'


def _squares(places: NDArray, size: float) -> str:
    d = f"{2 * size:g}"
    form = f"M%.1f %.1fm-{size:g}-{size:g}h{d}v{d}h-{d}z"
    return form * len(places) % tuple(places.ravel().tolist())
