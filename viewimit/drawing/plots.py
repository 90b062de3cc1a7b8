"""The experiments' figures: their size and caption, and lines told apart by more than their colour."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..loop.settings import Settings
from ..simulation.disturbances import Disturbance
from . import svg
from .labels import CHARACTER

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
