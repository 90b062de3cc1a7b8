"""Small plots of the experiments' figures: a box with two scales, and lines told apart by more than their colour."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..snapshot import Settings
from . import svg
from .labels import CHARACTER

WIDTH, HEIGHT = 424, 212  # px of a figure, whatever it shows: nothing below it moves
END = 3.4  # px, half the size of the mark at a line's end
LEAST = 1e-30
LONGEST = 92  # letters of a caption
DISTURBANCES = (
    ("noise_px", "noise {:g} px"),
    ("missing", "missing {:.0%}"),
    ("outliers", "outliers {:.0%}"),
    ("gain_error", "gain error {:.0%}"),
    ("quantum_deg", "steps of {:g}°"),
)


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


def style_of(name: str, names: Sequence[str]) -> Style:
    """Each of a list has a style of its own, the first ones the most distinct."""
    return STYLES[list(names).index(name) % len(STYLES)]


@dataclass(frozen=True)
class Plot:
    """left, top, right, bottom: px; x, y: what the sides stand for; across, up: what makes them even, such as log10."""

    left: float
    top: float
    right: float
    bottom: float
    x: tuple[float, float]
    y: tuple[float, float]
    across: Callable[[NDArray], NDArray] = np.asarray
    up: Callable[[NDArray], NDArray] = np.asarray

    def place(self, x: NDArray, y: NDArray) -> NDArray:
        """(k, 2) px; NaN for what has no place"""
        share_x, share_y = _share(x, self.x, self.across), _share(y, self.y, self.up)
        px = np.stack(np.broadcast_arrays(share_x, share_y), -1).astype(float)
        px *= (self.right - self.left, self.top - self.bottom)
        px += (self.left, self.bottom)
        px[~np.isfinite(px).all(-1)] = np.nan
        return px

    def frame(self, title: str, note: str = "", x_ticks: Sequence = (), y_ticks: Sequence = (), out: float = 0) -> str:
        """Title above, `out` px left of the box; rules at y_ticks, words below at x_ticks: (value, words) each."""
        rules = [(float(self.place(self.x[0], value)[1]), words) for value, words in y_ticks]
        lines = "".join(f"M{self.left:.1f} {y:.1f}H{self.right:.1f}" for y, _ in rules)
        parts = [
            f'<text x="{self.left - out:.1f}" y="{self.top - 6:.1f}"><tspan class="vi-b">{svg.escape(title)}</tspan>'
            f'<tspan class="vi-2nd" dx="5">{svg.escape(note)}</tspan></text><path class="vi-rule" d="{lines}"/>',
            f'<path class="vi-axis" d="M{self.left:.1f} {self.top:.1f}V{self.bottom:.1f}H{self.right:.1f}"/>',
        ]
        parts += [svg.text(self.left - 5, y + 4, words, "vi-2nd vi-end") for y, words in rules]
        for value, words in x_ticks:
            parts.append(svg.text(self.place(value, self.y[0])[0], self.bottom + 13, words, "vi-2nd vi-mid"))
        return "".join(parts)

    def line(self, x: NDArray, y: NDArray, classes: str) -> str:
        points = self.place(x, y)
        return f'<path class="{classes}" d="{svg.path(points)}"/>' if np.isfinite(points).any() else ""

    def level(self, y: float, classes: str) -> str:
        """A line across."""
        return self.line(np.array(self.x), np.full(2, y), classes)


def figure(settings: Settings | None, inside: str, extra: str = "") -> str:
    """A drawing with the words of what it was made. extra: what else belongs into them."""
    words = _caption(described(settings) + extra) if settings else ""
    return f'<svg class="vi vi-figure" viewBox="0 0 {WIDTH} {HEIGHT}">{words}{inside}</svg>'


def _caption(words: str) -> str:
    """Long ones are condensed, and cut off in the end."""
    words = words if len(words) <= LONGEST else words[: LONGEST - 1] + "…"
    fitted = f' textLength="{WIDTH}" lengthAdjust="spacingAndGlyphs"' if CHARACTER * len(words) > WIDTH else ""
    return f'<text class="vi-2nd" x="0" y="10"{fitted}>{svg.escape(words)}</text>'


def described(settings: Settings) -> str:
    """The conditions under which a result was found, in one line."""
    digits = 1 if len(settings.demonstrator_deg) <= 3 else 0
    posture = ", ".join(svg.number(angle, digits) + "°" for angle in settings.demonstrator_deg)
    scene = settings.scene.replace("\\", "/").rsplit("/", 1)[-1]
    said = f"Demonstrator ({posture}) · {settings.transfer} transfer · {scene}, {settings.points} points"
    disturbed = [words.format(getattr(settings, name)) for name, words in DISTURBANCES if getattr(settings, name)]
    return " · ".join([said, ", ".join(disturbed)] if disturbed else [said])


def sentence(words: Sequence[str], x: float, y: float) -> str:
    """Lines of an empty figure's sentence, centred at px (x, y)."""
    wide, high = CHARACTER * max(map(len, words)), 15 * len(words) + 8
    box = f'x="{x - wide / 2:.1f}" y="{y - high / 2:.1f}" width="{wide:.1f}" height="{high}" rx="4"'
    lines = [svg.text(x, y - high / 2 + 15 + 15 * k, line, "vi-mid") for k, line in enumerate(words)]
    return f'<rect class="vi-x-blank" {box}/>{"".join(lines)}'


def decades(values: NDArray, low: float, high: float) -> tuple[float, float]:
    """Powers of ten around all positive values, and around low … high at least."""
    known = values[np.isfinite(values) & (values > 0)]
    ends = np.array([low, high, *(known.min(initial=high), known.max(initial=low))])
    return float(10 ** np.floor(np.log10(ends.min()) + 1e-9)), float(10 ** np.ceil(np.log10(ends.max()) - 1e-9))


def decade_ticks(low: float, high: float, most: int = 4) -> list[tuple[float, str]]:
    """The powers of ten from low to high, every so many of them."""
    first, last = int(np.ceil(np.log10(low) - 1e-9)), int(np.floor(np.log10(high) + 1e-9))
    every = max(1, -(-(last - first) // most))
    return [(10.0**k, f"{10.0**k:g}" if abs(k) < 5 else f"1e{k}") for k in range(first, last + 1, every)]


def log10(values) -> NDArray:
    """NaN for what has no logarithm."""
    values = np.asarray(values, float)
    return np.log10(np.where(values > LEAST, values, np.nan))


def _share(values, ends: tuple[float, float], even: Callable) -> NDArray:
    low, high = even(np.array(ends, float))
    return (even(np.asarray(values, float)) - low) / (high - low)


def _squares(places: NDArray, size: float) -> str:
    d = f"{2 * size:g}"
    form = f"M%.1f %.1fm-{size:g}-{size:g}h{d}v{d}h-{d}z"
    return form * len(places) % tuple(places.ravel().tolist())
