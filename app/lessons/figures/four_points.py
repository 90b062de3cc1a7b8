"""Of the step about too few points: landscapes of E beside each other."""

from collections.abc import Collection, Mapping

import numpy as np

from viewimit.drawing.lessons import matches as drawing
from viewimit.drawing.lessons.matches import Shape, draw_matches

from ..measures.four_points import is_flat, matches
from ..stage import Stage
from ..works.four_points import FEWEST, STEP_DEG
from .figure_kind import FigureKind


def _matches(stage: Stage, layers: Collection[str], small: bool) -> str:
    made, moment = matches(stage), stage.moment
    count = round(stage.slider("matches")) if stage.revealed else FEWEST
    total = int(moment.usable.sum())
    few = None if made is None else made.by_count.get(count)
    flat = made is not None and few is not None and is_flat(few, made.by_count[total])
    shapes = {
        "all": Shape(f"All {total} matches", None if made is None else made.by_count[total]),
        "few": Shape(f"{count} matches", few, flat, hidden=not stage.revealed),
        "plane": Shape(f"{total} matches, nearly in a plane", None if made is None else made.plane),
    }
    matched = np.zeros(len(moment.usable), bool)
    if made is not None:
        matched[made.order[:count]] = True
    points, bones = moment.views.demo[:, :2], stage.bodies.demo.origins[0]
    return draw_matches(stage.session.scene, shapes, layers, moment.theta_demo, points, matched, bones, STEP_DEG)


FIGURES: Mapping[str, FigureKind] = {"matches": FigureKind(_matches, drawing.LAYERS, works=("matches",))}
