"""The construction of the chosen point in the four images: complete, or stage by stage.

If the transfer intersects epipolar lines, the stages are: the point in l, its line, the point in r, the second line,
the intersection, and the arrow to the own point. Other transfers repeat the steps from the points' centroid.
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
REPEATED = (
    ("l", "Point {} in l and r, …"),
    ("steps", "… by three steps from the middle of all."),
    ("repeated", "The same steps in L and R, …"),
    ("recovered", "… and it is recovered."),
    ("own", "The arrow leads on to the own point."),
)
WITH = {"r": "l"}  # a part without a stage of its own → the stage it appears in
MAX_HALF_AXIS = 400.0  # px: a longer one looks the same


def last_stage(crossed: bool) -> int:
    """Return the index of the last stage. crossed: whether the transfer intersects epipolar lines."""
    return len(CROSSED if crossed else REPEATED) - 1


def is_shown(stage: int | None, crossed: bool, what: str) -> bool:
    """Say whether a part is shown at a stage; None for the complete construction."""
    names = [name for name, _ in (CROSSED if crossed else REPEATED)]
    return stage is None or names.index(what if what in names else WITH[what]) <= stage


def describe(construction: Construction | None, point: int, stage: int | None, crossed: bool) -> str:
    """Write the words of a stage, or of the complete construction, as HTML."""
    name = f"<b>{point}</b>"
    if stage is not None:
        words = (CROSSED if crossed else REPEATED)[stage][1]
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
    construction: Construction, windows: dict[str, Window], stage: int | None, own: NDArray[np.float64], gain: float
) -> dict[str, str]:
    """Draw the construction by view.

    Parameters
    ----------
    construction
        Of the chosen point.
    windows
        The shown part of each image.
    stage
        The last stage to draw; None for all. Stages repeat the recovered point and its arrow, as other marks are faint.
    own
        The learner's own point in L and R, (2, 2) px.
    gain
        How many times longer than the residual its arrow is.
    """
    crossed, drawn = construction.steps is None, dict.fromkeys("lrLR", "")
    if construction.steps is not None:
        path = placed(construction.steps, windows, "lrLR")
        for k, view in enumerate("lrLR"):
            if is_shown(stage, crossed, "steps" if view in "lr" else "repeated"):
                drawn[view] += f'<path class="vi-steps" d="{svg.path(path[k])}"/>'
                drawn[view] += f'<path class="vi-stop" d="{svg.dots(path[k, :-1])}"/>'
    if not is_shown(stage, crossed, "recovered"):
        return drawn
    centres = placed(construction.recovered[:, None], windows, "LR")[:, 0]
    for k, view in enumerate("LR"):
        drawn[view] += _ellipse(centres[k], construction.half_axes[k], construction.direction[k], windows[view].scale)
        if stage is not None:
            drawn[view] += f'<path class="vi-found" d="{svg.diamonds(centres[k : k + 1], RECOVERED)}"/>'
    if stage is not None and is_shown(stage, crossed, "own"):
        tips = centres + gain * (placed(own[:, None], windows, "LR")[:, 0] - centres)
        for k, view in enumerate("LR"):
            drawn[view] += f'<path class="vi-e" d="{svg.segments(centres[k : k + 1], tips[k : k + 1])}"/>'
    return drawn


def _ellipse(centre: NDArray[np.float64], half_axes: NDArray[np.float64], direction: float, scale: float) -> str:
    """Draw an ellipse. centre: (2,) px of the drawing; half_axes: (2,) px of the image; direction: rad."""
    turn = f"translate({centre[0]:.1f} {centre[1]:.1f})rotate({np.degrees(direction):.1f})"
    long, short = np.minimum(scale * half_axes, MAX_HALF_AXIS).tolist()
    return f'<ellipse class="vi-spread" rx="{long:.1f}" ry="{short:.1f}" transform="{turn}"/>'
