"""Plots: axes with ticks and labels, and the size, caption and line styles of the experiments' figures."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, wraps
from typing import Concatenate, NamedTuple, ParamSpec

import numpy as np
from numpy.typing import ArrayLike

from ..geometry.arrays import Floats
from ..loop.settings import Settings
from ..simulation.disturbances import Disturbance
from . import svg
from .labels import CHARACTER

MIN_POSITIVE = 1e-30  # smaller values have no place on a logarithmic axis
MAX_DECADES = 12
LABEL_SPACING = 13  # px between labels
GAP = 5  # px from a plot to the words at its left
NICE = (1, 2, 5, 10)  # steps of a linear scale, times a power of ten
WIDTH, HEIGHT = 424, 212  # px of every experiment's figure
MARK = 3.4  # px, half the size of the mark at a line's end
MAX_CAPTION = 92  # characters

Tick = tuple[float, str]  # value, words
CurveLabel = tuple[float, str, str]  # height in px, words, classes
More = ParamSpec("More")


def linear(values: ArrayLike) -> Floats:
    """Return values as they are, for a linear axis."""
    return np.asarray(values, float)


def log10(values: ArrayLike) -> Floats:
    """Return logarithms for a logarithmic axis; NaN for values below MIN_POSITIVE."""
    values = np.asarray(values, float)
    return np.log10(np.where(values > MIN_POSITIVE, values, np.nan))


def _kept(
    draw: Callable[Concatenate["Axes", Iterable[Tick], More], str],
) -> Callable[Concatenate["Axes", Iterable[Tick], More], str]:
    """Keep what is drawn: the same axes are drawn for many motions, and their words take longer than the curve."""
    kept: Callable[..., str] = lru_cache(256)(draw)

    @wraps(draw)
    def drawn(axes: "Axes", ticks: Iterable[Tick], *more: More.args, **named: More.kwargs) -> str:
        return kept(axes, tuple(ticks), *more, **named)

    return drawn


@dataclass(frozen=True)
class Axes:
    """Two scales over a box of px."""

    left: float  # px, as top, right and bottom
    top: float
    right: float
    bottom: float
    x: tuple[float, float]  # values at the left and at the right
    y: tuple[float, float]  # values at the bottom and at the top
    across: Callable[[ArrayLike], Floats] = linear  # scale of x: `linear` or `log10`
    up: Callable[[ArrayLike], Floats] = linear  # scale of y

    def x_px(self, values: ArrayLike) -> Floats:
        """Return the px of values of x."""
        low, high = self._ends[0]
        return self.left + (self.right - self.left) * (self.across(values) - low) / (high - low)

    def y_px(self, values: ArrayLike) -> Floats:
        """Return the px of values of y."""
        low, high = self._ends[1]
        return self.bottom + (self.top - self.bottom) * (self.up(values) - low) / (high - low)

    def place(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """Return points as (k, 2) px; NaN for points that have no place."""
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
        """Draw the title above, `out` px left of the box, rules at y_ticks, and numbers at both sides."""
        sides = f'<path class="vi-axis" d="M{self.left:.1f} {self.top:.1f}V{self.bottom:.1f}H{self.right:.1f}"/>'
        title = self.title(title, note, self.left - out, self.top - 6)
        return title + self.rules(y_ticks) + sides + self.beside(y_ticks) + self.below(x_ticks)

    def title(self, words: str, note: str, x: float, y: float) -> str:
        """Draw a title with a note behind it at (x, y) px."""
        return (
            f'<text x="{x:.1f}" y="{y:.1f}"><tspan class="vi-b">{svg.escape(words)}</tspan>'
            f'<tspan class="vi-2nd" dx="5">{svg.escape(note)}</tspan></text>'
        )

    @_kept
    def rules(self, ticks: Iterable[Tick]) -> str:
        """Draw a horizontal line at each tick."""
        lines = (f"M{self.left:.1f} {self.y_px(value):.1f}H{self.right:.1f}" for value, __ in ticks)
        return f'<path class="vi-rule" d="{"".join(lines)}"/>'

    @_kept
    def beside(self, ticks: Iterable[Tick], gap: float = GAP) -> str:
        """Draw the ticks' words left of the plot."""
        places = [(float(self.y_px(value)) + 4, words) for value, words in ticks]
        return "".join(svg.text(self.left - gap, y, words, "vi-2nd vi-end") for y, words in places)

    @_kept
    def below(self, ticks: Iterable[Tick], drop: float = 13) -> str:
        """Draw the ticks' words below the plot."""
        places = [(float(self.x_px(value)), words) for value, words in ticks]
        return "".join(svg.text(x, self.bottom + drop, words, "vi-2nd vi-mid") for x, words in places)

    def line(self, x: ArrayLike, y: ArrayLike, classes: str) -> str:
        """Draw a line through points; "" if none has a place."""
        points = self.place(x, y)
        return f'<path class="{classes}" d="{svg.path(points)}"/>' if np.isfinite(points).any() else ""

    def level(self, y: float, classes: str) -> str:
        """Draw a horizontal line through the whole plot."""
        return self.line(np.array(self.x), np.full(2, y), classes)

    def labels(self, labels: Iterable[CurveLabel]) -> str:
        """Draw labels right of the plot, each at the height of its curve, moved where they would overlap."""
        ordered = sorted(labels)
        places = spread_heights([height for height, *__ in ordered], self.top + 2, self.bottom - 1)
        x = self.right + 7
        return "".join(svg.text(x, y + 4, words, classes) for y, (__, words, classes) in zip(places, ordered))

    @cached_property
    def _ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        (left, right), (low, high) = self.across(self.x).tolist(), self.up(self.y).tolist()
        return (left, right), (low, high)


def spread_heights(heights: Sequence[float], top: float, bottom: float) -> list[float]:
    """Move ascending heights, px, LABEL_SPACING from each other and, if there is room, between top and bottom."""
    y = [min(max(height, top), bottom) for height in heights]
    for __ in range(3):
        for i in range(1, len(y)):
            y[i] = max(y[i], y[i - 1] + LABEL_SPACING)
        over = y[-1] - bottom if y else 0
        if over <= 0:
            break
        y[-1] -= over
        for i in range(len(y) - 1, 0, -1):
            y[i - 1] = min(y[i - 1], y[i] - LABEL_SPACING)
    return y


def decades(values: ArrayLike, *around: float) -> tuple[float, float]:
    """Return powers of ten around all positive values and those of `around`; 1 and 1000 without any."""
    values = np.append(np.asarray(values, float), around)
    known = values[np.isfinite(values) & (values > 0)]
    if not len(known):
        return 1.0, 1000.0
    first, last = int(np.floor(np.log10(known.min()) + 1e-9)), int(np.ceil(np.log10(known.max()) - 1e-9))
    last = max(last, first + 1)
    return 10.0 ** max(first, last - MAX_DECADES), 10.0**last


def decade_ticks(low: float, high: float, most: int = 4) -> list[Tick]:
    """Return ticks at about `most` powers of ten from low to high."""
    first, last = int(np.ceil(np.log10(low) - 1e-9)), int(np.floor(np.log10(high) + 1e-9))
    every = max(1, -(-(last - first) // most))
    return [(10.0**k, f"{10.0**k:g}" if abs(k) < 5 else f"1e{k}") for k in range(first, last + 1, every)]


def angle_ticks(low: float, high: float, spacing: float = 0.0) -> list[Tick]:
    """Return ticks of an axis in degrees, with at least `spacing` between them but at most 180 degrees."""
    span = high - low
    step = 45 if span > 130 or span == 90 else 30 if span > 45 else 15
    step = next((wider for wider in (step, 90, 180) if wider >= spacing), 180)
    angles = np.arange(np.ceil(low / step) * step, high + 1e-9, step).tolist()
    return [(float(angle), svg.number(angle, 0) + "°") for angle in angles]


def linear_ticks(low: float, high: float, most: int = 4) -> list[Tick]:
    """Return ticks at round values from low to high, at most `most` + 1."""
    power = 10.0 ** np.floor(np.log10((high - low) / most))
    step = next(nice * power for nice in NICE if nice * power * most >= (high - low) * (1 - 1e-9))
    digits = max(0, -int(np.floor(np.log10(step))))
    values = np.arange(np.ceil(low / step) * step, high + 1e-9, step).tolist()
    return [(value, svg.number(value, digits)) for value in values]


# Experiments' figures


class Style(NamedTuple):
    """How a line is drawn: lines differ by more than their colour."""

    role: str  # colour
    dash: str  # solid, dashed, dash-dot or dotted
    mark: str  # circle, diamond, ring or square

    @property
    def line(self) -> str:
        """Classes of the line."""
        return f"vi-x vi-x-{self.role} vi-x-{self.dash}"

    def marks(self, places: Floats, size: float = MARK) -> str:
        """Draw marks at places, (k, 2) px, without those that are NaN."""
        places = places[np.isfinite(places).all(-1)]
        if self.mark == "circle":
            return f'<path class="vi-x-fill-{self.role}" d="{svg.circles(places, size)}"/>'
        d = {"diamond": svg.diamonds, "ring": svg.circles, "square": _squares}[self.mark](places, size)
        return f'<path class="vi-x-hollow vi-x-{self.role}" d="{d}"/>'

    def sample(self, x: float, y: float) -> str:
        """Draw a piece of the line with its mark for a legend, 22 px wide."""
        return f'<path class="{self.line}" d="M{x:.1f} {y:.1f}h22"/>' + self.marks(np.array([[x + 11, y]]))


STYLES = (
    Style("learner", "solid", "circle"),
    Style("recovered", "dash-dot", "diamond"),
    Style("residual", "dashed", "square"),
    Style("ink", "dotted", "ring"),
    Style("chosen", "solid", "diamond"),
)


def style_of(name: str, names: Iterable[str]) -> Style:
    """Return the style of a name among others; the first ones are the most distinct."""
    return STYLES[list(names).index(name) % len(STYLES)]


def figure(settings: Settings | None, inside: str, extra: str = "", height: float = HEIGHT) -> str:
    """Wrap a drawing in an `<svg>` with a caption of its settings. extra: further words of the caption; height: px."""
    caption = ""
    if settings is not None:  # long captions are condensed, and very long ones cut off
        words = " · ".join(filter(None, (describe_settings(settings), extra)))
        words = words if len(words) <= MAX_CAPTION else words[: MAX_CAPTION - 1] + "…"
        fitted = f' textLength="{WIDTH}" lengthAdjust="spacingAndGlyphs"' if CHARACTER * len(words) > WIDTH else ""
        caption = f'<text class="vi-2nd" x="0" y="10"{fitted}>{svg.escape(words)}</text>'
    return f'<svg class="vi vi-figure" viewBox="0 0 {WIDTH} {height:g}">{caption}{inside}</svg>'


def describe_settings(settings: Settings) -> str:
    """Write the conditions of a result in one line."""
    angles = settings.demonstrator_deg or ()  # none: the scene's own
    posture = ", ".join(svg.number(angle, 1 if len(angles) <= 3 else 0) + "°" for angle in angles)
    points = svg.count_points(settings.points)
    if settings.body_points is not None:
        points += " by hand"
    transfer = f"{settings.transfer} transfer"
    words = [f"{transfer[0].upper()}{transfer[1:]}"]
    if posture:
        words = [f"Demonstrator ({posture})", transfer]
    disturbed = [found.caption.format(amount) for found, amount in settings.amounts(Disturbance) if amount]
    return " · ".join([*words, f"{settings.scene_title}, {points}", *([", ".join(disturbed)] if disturbed else [])])


def sentence(words: Sequence[str], x: float, y: float) -> str:
    """Draw the lines of an empty figure's sentence, centred at (x, y) px."""
    wide, high = CHARACTER * max(map(len, words)), 15 * len(words) + 8
    box = f'x="{x - wide / 2:.1f}" y="{y - high / 2:.1f}" width="{wide:.1f}" height="{high}" rx="4"'
    lines = [svg.text(x, y - high / 2 + 15 + 15 * k, line, "vi-mid") for k, line in enumerate(words)]
    return f'<rect class="vi-x-blank" {box}/>{"".join(lines)}'


def _squares(places: Floats, size: float) -> str:
    d = f"{2 * size:g}"
    return svg.filled(f"M%s %sm-{size:g}-{size:g}h{d}v{d}h-{d}z" * len(places), places)
