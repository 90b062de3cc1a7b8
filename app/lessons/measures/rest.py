"""Where the learner that was run from the step's start has come to rest, and how it got there."""

from collections.abc import Callable, Mapping

import numpy as np

from viewimit.loop.snapshot import Snapshot

from ..stage import Stage
from .measure import Measure
from .tour import error_deg


def last(stage: Stage) -> Snapshot | None:
    """None while it is run."""
    return stage.races[0].moments[-1] if stage.races else None


def _at_rest(of: Callable[[Snapshot], float]) -> Callable[[Stage], float]:
    def measured(stage: Stage) -> float:
        moment = last(stage)
        return np.nan if moment is None else of(moment)

    return measured


MEASURES: Mapping[str, Measure] = {
    "E at rest": Measure(_at_rest(lambda moment: moment.E), " px²"),
    "off at rest": Measure(_at_rest(error_deg), "°", 1),
    "motions to rest": Measure(_at_rest(lambda moment: float(moment.motion)), "", 0),
}
