"""How far apart postures lie in which E was least under noise, with one image each time and with several averaged."""

from collections.abc import Callable, Mapping

import numpy as np

from ..stage import Stage
from ..works.noise import FRAMES, RUNS
from .measure import Measure


def shrinks(stage: Stage) -> float:
    """By what factor, over both joints; NaN while it is computed."""
    clouds = stage.made.get("clouds")
    if clouds is None:
        return np.nan
    one, averaged = (clouds[frames].var(0).sum() for frames in FRAMES)
    return float(np.sqrt(one / averaged))


def _scatter(frames: int, joint: int) -> Callable[[Stage], float]:
    def of(stage: Stage) -> float:
        clouds = stage.made.get("clouds")
        return np.nan if clouds is None else float(np.degrees(clouds[frames].std(0)[joint]))

    return of


MEASURES: Mapping[str, Measure] = {
    "times the cloud shrinks": Measure(shrinks, "", 1),
    "scatter of the first joint": Measure(_scatter(1, 0), "°", 1),
    "scatter of the second joint": Measure(_scatter(1, 1), "°", 1),
    "averaged scatter of the first joint": Measure(_scatter(FRAMES[1], 0), "°", 1),
    "noise": Measure(lambda stage: stage.session.settings.noise_px, " px", 1),
    "runs": Measure(lambda stage: float(RUNS), "", 0),
}
