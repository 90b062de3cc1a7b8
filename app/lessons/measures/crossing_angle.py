"""Of the step about nearly parallel lines: at which angle they cross, and how far a pixel moves the crossing."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.construction import Construction, construct
from viewimit.drawing.lessons.view import line_of

from ..stage import Stage
from .measure import Measure


def construction(stage: Stage) -> Construction | None:
    """Of the step's point."""
    return None if stage.step.chosen is None else construct(stage.moment, stage.step.chosen)


def lines(stage: Stage) -> NDArray | None:
    """(2, 3) px: in L, from l and from r, of the step's point; None if there are none."""
    found = [line_of("L", stage.moment, stage.step.chosen or 0, eye) for eye in (0, 1)]
    return None if found[0] is None or found[1] is None else np.array(found)


def crossing(two: NDArray) -> NDArray:
    """(2,) px, where lines (2, 3) cross."""
    x, y, w = np.cross(*two)
    return np.array([x, y]) / w


def moved(two: NDArray, px: float = 1.0) -> NDArray:
    """(2, 3): the same lines, the second of them that far aside."""
    aside = np.array([0.0, 0.0, px * np.hypot(*two[1, :2])])
    return np.array([two[0], two[1] + aside])


def _shift(stage: Stage) -> float:
    """px that the crossing goes in L if the line from r moves by 1 px."""
    two = lines(stage)
    return np.nan if two is None else float(np.linalg.norm(crossing(moved(two)) - crossing(two)))


def _angle(stage: Stage) -> float:
    """Degrees, between both lines in L."""
    found = construction(stage)
    return np.nan if found is None or found.angle is None else float(np.degrees(found.angle[0]))


def _half_axis(stage: Stage) -> float:
    """px in L: half the longer axis of the recovered point's ellipse."""
    found = construction(stage)
    return np.nan if found is None else float(found.half_axes[0, 0])


def _condition(stage: Stage) -> float:
    """cond(A) of the session's transfer."""
    return np.nan if stage.moment.transfer is None else float(stage.moment.transfer.condition)


MEASURES: Mapping[str, Measure] = {
    "crossing angle": Measure(_angle, "°", 1),
    "crossing moves": Measure(_shift, " px", 1),
    "uncertain by": Measure(_half_axis, " px", 0),
    "cond A": Measure(_condition, "", 0),
    "baseline": Measure(lambda stage: 100 * stage.session.scene.head.baseline, " cm", 0),
}
