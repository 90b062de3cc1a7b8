"""Eyes turned inwards: the landscape and the rows of matches, as seen and rectified."""

from collections.abc import Collection, Mapping

import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.landscape import Landscape
from viewimit.drawing.lessons import mended, rows
from viewimit.drawing.lessons.mended import Case, draw_mended
from viewimit.drawing.lessons.rows import draw_rows

from ..measures.rectification import mendings, off_deg
from ..stage import Stage
from ..works.rectification import Mending
from .figure_kind import FigureKind

TITLES = {"as seen": "As the eyes see", "rectified": "Rectified by matches alone"}


def _mended(stage: Stage, layers: Collection[str], small: bool) -> str:
    made = mendings(stage)
    cases = [Case(name, title, *_found(made.get(name)), off_deg(stage, name)) for name, title in TITLES.items()]
    return draw_mended(stage.session.scene, stage.moment.theta_demo, cases, layers, stage.narrow)


def _found(mending: Mending | None) -> tuple[Landscape | None, NDArray | None]:
    return (None, None) if mending is None else (mending.landscape, np.degrees(mending.least))


def _rows(stage: Stage, layers: Collection[str], small: bool) -> str:
    made = mendings(stage)
    by = made["rectified"].rectification if made else None
    return draw_rows(stage.moment.views.demo[stage.moment.usable], by, layers)


FIGURES: Mapping[str, FigureKind] = {
    "mended": FigureKind(_mended, mended.LAYERS, works=("mendings",)),
    "rows": FigureKind(_rows, rows.LAYERS, works=("mendings",)),
}
