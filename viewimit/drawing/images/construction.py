"""How the chosen point is recovered, in the four images: all at once, or built up stage by stage.

Where a transfer crosses epipolar lines: the point in l, its line, the point in r, the second line, the crossing, the
way to the own point. Else steps from the middle of the points to this one, and the same steps carried over.
"""

import numpy as np
from numpy.typing import NDArray

from ...analysis.construction import Construction
from .. import svg
from ..theme import RECOVERED
from .planes import Window, placed

CROSSED = (
    ("l", "Point {} in l …"),
    ("left", "… lies on this line in L and in R."),
    ("r", "The same point in r …"),
    ("right", "… gives a second line."),
    ("recovered", "Where they cross it is recovered."),
    ("own", "The arrow leads on to the own point."),
)
CARRIED = (
    ("l", "Point {} in l and r, …"),
    ("steps", "… by three steps from the middle of all."),
    ("carried", "The same steps in L and R, …"),
    ("recovered", "… and it is recovered."),
    ("own", "The arrow leads on to the own point."),
)
WITH = {"r": "l"}  # what stands in no stage of its own comes with another
FARTHEST = 400.0  # px: a longer half axis looks the same


def last_stage(crossed: bool) -> int:
    return len(CROSSED if crossed else CARRIED) - 1


def stands(stage: int | None, crossed: bool, what: str) -> bool:
    """Whether a part is there at a stage."""
    names = [name for name, _ in (CROSSED if crossed else CARRIED)]
    return stage is None or names.index(what if what in names else WITH[what]) <= stage


def describe(construction: Construction | None, point: int, stage: int | None, crossed: bool) -> str:
    """HTML: the words of a stage, or what all of it says."""
    name = f"<b>{point}</b>"
    if stage is not None:
        words = (CROSSED if crossed else CARRIED)[stage][1]
        return f"<i>{stage + 1}/{last_stage(crossed) + 1}</i> {words.format(name)}"
    if construction is None:
        return f"Point {name} is not seen in all four images."
    if construction.angle is None:
        found = f"Point {name}: carried over by steps."
    else:
        left, right = (f"{svg.number(angle, 0)}°" for angle in np.degrees(construction.angle))
        found = f"Point {name}: lines cross at {left}" + (f", {right}." if left != right else ".")
    return f"{found} With 1 px of noise 95 % fall in the ellipse."


def draw(
    construction: Construction, windows: dict[str, Window], stage: int | None, own: NDArray, gain: float
) -> dict[str, str]:
    """By view. own: (2, 2) px in L, R, the learner's own point; gain: of its arrow, which stages show once more as all
    else is faint then."""
    crossed, drawn = construction.steps is None, dict.fromkeys("lrLR", "")
    if construction.steps is not None:
        path = placed(construction.steps, windows, "lrLR")
        for k, view in enumerate("lrLR"):
            if stands(stage, crossed, "steps" if view in "lr" else "carried"):
                drawn[view] += f'<path class="vi-steps" d="{svg.path(path[k])}"/>'
                drawn[view] += f'<path class="vi-stop" d="{svg.dots(path[k, :-1])}"/>'
    if not stands(stage, crossed, "recovered"):
        return drawn
    centres = placed(construction.recovered[:, None], windows, "LR")[:, 0]
    for k, view in enumerate("LR"):
        drawn[view] += _ellipse(centres[k], construction.half_axes[k], construction.direction[k], windows[view].scale)
        if stage is not None:
            drawn[view] += f'<path class="vi-found" d="{svg.diamonds(centres[k : k + 1], RECOVERED)}"/>'
    if stage is not None and stands(stage, crossed, "own"):
        tips = centres + gain * (placed(own[:, None], windows, "LR")[:, 0] - centres)
        for k, view in enumerate("LR"):
            drawn[view] += f'<path class="vi-e" d="{svg.segments(centres[k : k + 1], tips[k : k + 1])}"/>'
    return drawn


def _ellipse(centre: NDArray, half_axes: NDArray, direction: float, scale: float) -> str:
    """centre: (2,) px of the drawing; half_axes: (2,) px of the image; direction: rad"""
    turn = f"translate({centre[0]:.1f} {centre[1]:.1f})rotate({np.degrees(direction):.1f})"
    long, short = np.minimum(scale * half_axes, FARTHEST).tolist()
    return f'<ellipse class="vi-spread" rx="{long:.1f}" ry="{short:.1f}" transform="{turn}"/>'
