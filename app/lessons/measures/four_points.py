"""Of the step about too few points: how high the landscapes are, and how surely lines cross."""

from collections.abc import Callable, Mapping

import numpy as np

from viewimit.analysis.landscape import Landscape

from ..stage import Stage
from ..works.four_points import FEWEST, Matches
from .measure import Measure

FLAT = 1e-9  # of the largest E with all matches: below, a landscape is rounding errors


def matches(stage: Stage) -> Matches | None:
    return stage.made.get("matches")


def is_flat(found: Landscape, like: Landscape) -> bool:
    """Whether E is zero everywhere, to rounding errors of the one that it is compared with."""
    return bool(np.nanmax(found.E) < FLAT * np.nanmax(like.E))


def _of(count: int | None, what: Callable[[Landscape], float]) -> Callable[[Stage], float]:
    """count: of matches; None for points in a plane, 0 for all."""

    def of(stage: Stage) -> float:
        made = matches(stage)
        if made is None:
            return np.nan
        return what(made.plane if count is None else made.by_count[count or len(made.order)])

    return of


def _largest(found: Landscape) -> float:
    return float(np.nanmax(found.E))


def _median_condition(found: Landscape) -> float:
    """cond(A), over the postures."""
    return np.nan if found.condition is None else float(np.nanmedian(found.condition))


def _zero_if_flat(stage: Stage) -> float:
    """px²: the largest E with four matches; rounding errors are zero."""
    made = matches(stage)
    if made is None:
        return np.nan
    four, all_of_them = made.by_count[FEWEST], made.by_count[len(made.order)]
    return 0.0 if is_flat(four, all_of_them) else _largest(four)


MEASURES: Mapping[str, Measure] = {
    "largest E of all matches": Measure(_of(0, _largest), " px²"),
    "largest E of four matches": Measure(_zero_if_flat, " px²", 0),
    "cond A of all matches": Measure(_of(0, _median_condition), "", 0),
    "cond A in a plane": Measure(_of(None, _median_condition), "", 0),
}
