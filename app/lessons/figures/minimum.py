"""Of the step in which the eyes move back: how far the smallest E is from the demonstrator over the distance."""

from collections.abc import Collection, Mapping

from viewimit.drawing.lessons import biases
from viewimit.drawing.lessons.biases import draw_biases

from ..measures.minimum import TIMES_ASKED
from ..stage import Stage
from ..works.minimum import TIMES
from .figure_kind import FigureKind


def _biases(stage: Stage, layers: Collection[str], small: bool) -> str:
    found = stage.made.get("biases")
    degrees = None if found is None else found.degrees
    here, transfer = stage.slider("distance"), stage.session.settings.transfer
    return draw_biases(TIMES, degrees, layers, here, TIMES_ASKED, stage.given.number, transfer, stage.narrow)


FIGURES: Mapping[str, FigureKind] = {"biases": FigureKind(_biases, biases.LAYERS, works=("biases", "minimum"))}
