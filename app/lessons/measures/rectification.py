"""How far the smallest E is off with eyes turned inwards: as they see, rectified, and with more points."""

from collections.abc import Callable, Mapping

import numpy as np

from ..stage import Stage
from ..works.rectification import Mending
from .measure import Measure

MENDED_DEG = 5.0  # off, up to which it has been put right


def mendings(stage: Stage) -> Mapping[str, Mending]:
    """By name; none while they are computed."""
    return stage.made.get("mendings", {})


def off_deg(stage: Stage, name: str) -> float:
    """Of the joint that is farthest; NaN while it is computed."""
    found = mendings(stage).get(name)
    if found is None:
        return np.nan
    return float(np.degrees(np.abs(found.least - stage.moment.theta_demo).max()))


def _mends(stage: Stage) -> float:
    """Of the answers: more points, level rows, nothing; 0 while it is computed."""
    if not mendings(stage):
        return 0.0
    off = [off_deg(stage, name) for name in ("more points", "rectified")]
    return float(np.argmin(off) + 1 if min(off) < MENDED_DEG else 3)


def _off(name: str) -> Callable[[Stage], float]:
    return lambda stage: off_deg(stage, name)


MEASURES: Mapping[str, Measure] = {
    "what puts it right": Measure(_mends),
    "off as seen": Measure(_off("as seen"), "°", 1),
    "off rectified": Measure(_off("rectified"), "°", 1),
    "off with more points": Measure(_off("more points"), "°", 1),
    "matches": Measure(lambda stage: 2.0 * float(stage.moments[0].usable.sum()), "", 0),
}
