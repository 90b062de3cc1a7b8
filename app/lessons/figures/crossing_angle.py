"""Of the step about lines that are nearly parallel: their crossing, enlarged."""

from collections.abc import Collection, Mapping

from viewimit.drawing.lessons import crossing
from viewimit.drawing.lessons.crossing import Crossing, draw_crossing

from ..measures import MEASURES
from ..measures import crossing_angle as geometry
from ..stage import Stage
from .figure_kind import FigureKind


def _crossing(stage: Stage, layers: Collection[str], small: bool) -> str:
    two, point = geometry.lines(stage), geometry.construction(stage)
    found = None
    if two is not None and point is not None:
        aside = geometry.moved(two)
        at, moved_at = geometry.crossing(two), geometry.crossing(aside)
        found = Crossing(two, at, aside[1], moved_at, point.half_axes[0], float(point.direction[0]))
    angle, shift = (MEASURES[name].told(stage) for name in ("crossing angle", "crossing moves"))
    return draw_crossing(found, layers, "L", angle, shift, stage.narrow)


FIGURES: Mapping[str, FigureKind] = {"crossing": FigureKind(_crossing, crossing.LAYERS)}
