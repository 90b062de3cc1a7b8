"""Of the tour: E, the crossing, the bowl, and who needed how many motions."""

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from viewimit.drawing.lessons.view import line_of
from viewimit.loop.snapshot import Snapshot

from ..stage import Race, Stage
from .measure import Measure


def error_deg(moment: Snapshot) -> float:
    """Of the joint that is farthest from the demonstrator's: the truth."""
    return float(np.degrees(np.abs(moment.theta - moment.theta_demo).max()))


def reached(E: list[float], goal: float) -> float:
    """Motions after which E was below the goal first; NaN if it never was."""
    below = [k for k, value in enumerate(E) if value < goal]
    return float(below[0]) if below else np.nan


def _recovered(stage: Stage) -> NDArray:
    """px in L, of the chosen point."""
    return stage.moment.recovered[stage.step.chosen or 0, :2]


def _from_line(stage: Stage) -> float:
    """px from the visitor's mark in L to the line from l."""
    line = line_of("L", stage.moment, stage.step.chosen or 0, 0)
    if stage.guess is None or line is None:
        return np.nan
    return float(abs(stage.guess @ line[:2] + line[2]) / np.hypot(*line[:2]))


def _height(stage: Stage) -> float:
    """px of the learner's arm in L."""
    return float(np.ptp(stage.bodies.own.hulls[0][..., 1]))


def _moved(stage: Stage) -> float:
    """Degrees that the demonstrator has turned by since the step began, its joint that turned most."""
    return float(np.degrees(np.abs(stage.moment.theta_demo - stage.moments[0].theta_demo).max()))


def _smallest(stage: Stage) -> NDArray:
    """Degrees, of the landscape."""
    return np.full(2, np.nan) if stage.landscape is None else np.degrees(stage.landscape.minimum)


def _E_on_landscape(stage: Stage, degrees: NDArray | None) -> float:
    """px², at the grid's posture that is nearest."""
    if stage.landscape is None or degrees is None or not np.isfinite(degrees).all():
        return np.nan
    first, second = (np.degrees(axis) for axis in stage.landscape.axes)
    return float(stage.landscape.E[np.abs(first - degrees[0]).argmin(), np.abs(second - degrees[1]).argmin()])


def _race(stage: Stage, servo: str) -> Race | None:
    return next((race for race in stage.races if race.servo == servo), None)


def _race_reached(servo: str) -> Callable[[Stage], float]:
    def of(stage: Stage) -> float:
        race = _race(stage, servo)
        if race is None or stage.goal is None:
            return np.nan
        return reached([moment.E for moment in race.moments], stage.goal)

    return of


def _own_motions(stage: Stage) -> float:
    return float(max(len(stage.trail.path) - 1, 0))


def _own_reached(stage: Stage) -> float:
    return np.nan if stage.goal is None else reached(list(stage.trail.E), stage.goal)


def _own_error(stage: Stage) -> float:
    """Degrees by which the visitor's last posture is off: the truth."""
    if not stage.trail.path:
        return np.nan
    return float(np.abs(np.array(stage.trail.path[-1]) - np.degrees(stage.moment.theta_demo)).max())


MEASURES: Mapping[str, Measure] = {
    "E": Measure(lambda stage: stage.moment.E, " px²"),
    "start E": Measure(lambda stage: stage.moments[0].E, " px²"),
    "smallest E": Measure(lambda stage: _E_on_landscape(stage, _smallest(stage)), " px²"),
    "E at your mark": Measure(lambda stage: _E_on_landscape(stage, stage.guess), " px²"),
    "off": Measure(lambda stage: error_deg(stage.moment), "°", 1),
    "moved": Measure(_moved, "°", 0),
    "arm height": Measure(_height, " px", 0),
    "recovered in L": Measure(_recovered),
    "place of the smallest E": Measure(_smallest),
    "px from the first line": Measure(_from_line, " px", 1),
    "motions": Measure(lambda stage: float(len(stage.moments) - 1), "", 0),
    "your motions": Measure(_own_motions, "", 0),
    "your motions to the goal": Measure(_own_reached, "", 0, "never"),
    "your error": Measure(_own_error, "°", 1),
    "motions of the trust region": Measure(_race_reached("trust-region"), "", 0, "never"),
    "motions of Broyden": Measure(_race_reached("broyden"), "", 0, "never"),
    "motions of the paper's law": Measure(_race_reached("gradient"), "", 0, "never"),
    "points": Measure(lambda stage: float(stage.moment.usable.sum()), "", 0),
    "longest arrow": Measure(lambda stage: float(np.nanmax(np.hypot(*stage.moment.e.reshape(-1, 2).T))), " px", 1),
}
