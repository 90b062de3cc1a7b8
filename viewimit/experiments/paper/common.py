"""What the paper's figures share: claims, tolerances and their reasons, grids of postures, marks and legends."""

import operator
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...analysis.landscape import Landscape
from ...drawing import relief, svg
from ...drawing.labels import Labels
from ...drawing.posture_plane import PosturePlane
from ...drawing.theme import OBSERVED
from ...estimation.equations import with_minus
from ...loop.settings import Settings, disturbances
from ...simulation.disturbances import SightDisturbance
from ...wording import listed, plural

PAPER = Settings.paper()  # the scene and transfer that the paper's own figures stand beside
PAPER_DEMONSTRATOR_DEG = (45.0, -90.0)


@dataclass(frozen=True)
class Claim:
    """One line of the table, in words."""

    name: str
    paper: str
    here: str
    tolerance: str
    holds: bool | None  # None if nothing is claimed, or the tolerance says why it is not judged
    subject: str  # of the verdict, if it does not hold


@dataclass(frozen=True)
class Tolerance:
    """A bound on a result."""

    value: float  # in the paper's scene
    reason: str  # of the value, with its unit
    elsewhere: float | None  # in any other scene, None if the paper claims nothing there
    least: bool = False  # whether it is a lower bound


TOLERANCES = {
    "minimum": Tolerance(4.0, "degrees a joint: the paper's own minimum is that far off", elsewhere=4.0),
    "minimum on pictures": Tolerance(
        10.0,
        "degrees a joint: one step of the grid; the affine camera's offset is smaller, detection adds to it",
        elsewhere=10.0,
    ),
    "minima": Tolerance(1, "the paper shows one", elsewhere=1),
    "basin": Tolerance(0.99, "share of starts that run downhill to it: 'almost convex'", elsewhere=0.99, least=True),
    "near": Tolerance(3.0, "degrees: the bias of E's minimum is up to 3° over the range", elsewhere=4.0),
    "E at rest": Tolerance(
        0.05, "px² above E in the demonstrator's posture, which the affine camera keeps from 0", elsewhere=0.05
    ),
    "starts": Tolerance(0.8, "share of starts: 'converges', but some lean on a limit", elsewhere=0.8, least=True),
    "image": Tolerance(1.0, "px: the width of a drawn line in images of 640 x 240", elsewhere=1.0),
    "joints": Tolerance(1.0, "degrees: the bias of E's minimum in this scene", elsewhere=None),
    "hand": Tolerance(10.0, "mm: what 1° makes of an arm's 0.6 m from shoulder to hand", elsewhere=None),
    "before": Tolerance(
        10.0,
        "times farther off: a transfer fitted in another posture carries its conflict along",
        elsewhere=1.0,
        least=True,
    ),
}


class Claims(list[Claim]):
    """Claims about a run with these settings, judged by the tolerances of its scene.

    unjudged: the reason why nothing is judged, if so.
    """

    def __init__(self, settings: Settings, unjudged: str = ""):
        super().__init__()
        self._unjudged = unjudged
        self._papers = settings.demonstrator_deg in (None, PAPER_DEMONSTRATOR_DEG) and all(
            getattr(settings, name) == getattr(PAPER, name)
            for name in ("scene", "robot", "points", "transfer", *disturbances(SightDisturbance))
        )

    def limit(self, what: str) -> float | None:
        """Return the bound in TOLERANCES for these settings."""
        return TOLERANCES[what].value if self._papers else TOLERANCES[what].elsewhere

    def add(
        self, name: str, paper: str, here: str, tolerance: str = "–", condition: bool | None = None, subject: str = ""
    ) -> None:
        """Add a claim. condition: whether it holds, None if nothing is claimed."""
        if condition is not None and self._unjudged:
            tolerance, condition = f"not judged: {self._unjudged}", None
        holds = None if condition is None else bool(condition)
        self.append(
            Claim(name, with_minus(paper), with_minus(here), tolerance, holds, subject or name.split(": ", 1)[-1])
        )

    def judge(
        self, name: str, paper: str, here: str, what: str, found: float, form: str = "≤ {:g}", subject: str = ""
    ) -> None:
        """Add a claim that is judged by a bound in TOLERANCES. form: of the bound's text."""
        limit = self.limit(what)
        if limit is None:
            words = form.format(TOLERANCES[what].value)
            self.add(name, paper, here, f"not judged: {words} is about the paper's scene")
        else:
            within = operator.ge if TOLERANCES[what].least else operator.le
            self.add(name, paper, here, form.format(limit), within(found, limit), subject)


def verdict(claims: Sequence[Claim]) -> str:
    """Say how many of the judged claims hold, and which do not; "" without judged claims."""
    judged = [claim for claim in claims if claim.holds is not None]
    missed = list(dict.fromkeys(claim.subject for claim in judged if not claim.holds))
    if not judged:
        return ""
    held = sum(claim.holds is True for claim in judged)
    text = f"{held} of {len(judged)} {plural('holds', 'hold', held)}"
    return f"{text}; {listed(missed)} {plural('does', 'do', len(missed))} not" if missed else text


def in_degrees(theta_deg: Iterable[float]) -> str:
    """Write a posture, such as (45.0°, −90.0°)."""
    return "(" + ", ".join(f"{angle:.1f}°" for angle in theta_deg).replace("-", "−") + ")"


def table(claims: list[Claim]) -> str:
    """Lay out the claims for people."""
    marks = {True: "pass", False: "MISS", None: "–"}
    rows = [("", "paper", "here", "tolerance", "")]
    rows += [(claim.name, claim.paper, claim.here, claim.tolerance, marks[claim.holds]) for claim in claims]
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in rows)


Progress = Callable[[float, Any], None]  # receives the share done, and the result so far or None


def no_progress(share: float, partial: Any) -> None:
    """Show nothing."""


def grid_rows(*axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the points of a grid, (K, m), the last axis changing fastest."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(axes))


def demonstrator_mark(place: NDArray[np.float64]) -> str:
    """Draw the diamond of the demonstrator's posture at (x, y) px."""
    return f'<path class="vi-seen" d="{svg.diamonds(place[None], OBSERVED + 1)}"/>'


def draw_surface(
    plane: PosturePlane, surface: Landscape, labels: Labels, points: NDArray[np.float64], lowest: NDArray[np.float64]
) -> str:
    """Draw E with its level lines. labels: of these lines, which leave the points (k, 2) px and the lowest one free."""
    grid, E = plane.grid(surface.axes), surface.E
    labels.take_points(points, 9)
    levels = relief.level_labels(grid, E, labels.bounds, lowest)
    return relief.shading(grid, E, plane.box) + relief.contours(grid, E) + labels.draw(levels)


def legend_marks(cross: float) -> list[tuple[str, str]]:
    """Return the marks on a map of E, each with its words. cross: size of the mark of the minimum, px."""
    here = np.array([8, 0])
    return [
        (demonstrator_mark(here), "demonstrator"),
        (svg.cross(here, cross), "smallest E"),
        (svg.saltire(here), "the paper's"),
    ]


def legend_entry(x: float, y: float, mark: str, words: str, gap: float = 25) -> str:
    """Draw a legend's entry at (x, y) px; gap: px from the mark to the words."""
    return f'<g transform="translate({x:.1f} {y})">{mark}{svg.text(gap, 4, words, "vi-2nd")}</g>'
