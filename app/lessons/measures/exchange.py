"""Points of the demonstrator that bear each other's names: which they are, which the learner names, and E with them."""

from collections.abc import Mapping

import numpy as np

from viewimit.estimation.views import Pairs

from ..stage import Stage
from .measure import Measure
from .rest import last

NEAR_ZERO, NEAR_DEG = 1.0, 5.0  # px², of an E that explains itself; degrees


def named(stage: Stage) -> Pairs:
    """What the learner that was run takes to be exchanged; none while it is run."""
    moment = last(stage)
    return () if moment is None else moment.exchanged


def true_pairs(stage: Stage) -> Pairs:
    """Which points are exchanged in what is seen: each lies where another one should."""
    moment = stage.moments[0]
    true, _ = stage.session.world.demo_images(moment.theta_demo)
    order = np.linalg.norm(moment.views.demo[:, None] - true, axis=-1).argmin(1).tolist()
    return tuple((i, j) for i, j in enumerate(order) if i < j and order[j] == i)


def least_as_seen(stage: Stage) -> float:
    """px², of all that the learner has seen before it exchanged points; NaN while it is run."""
    if not stage.races:
        return np.nan
    return float(min(moment.E for moment in stage.races[0].moments if not moment.exchanged))


def off_deg(stage: Stage) -> float:
    """From the smallest E of the landscape to the demonstrator, its joint that is farthest."""
    if stage.landscape is None:
        return np.nan
    return float(np.degrees(np.abs(stage.landscape.minimum - stage.moment.theta_demo).max()))


def _fits(stage: Stage) -> float:
    """Of the answers: near 0, above it at the demonstrator's posture, above it elsewhere; 0 while it is computed."""
    if stage.landscape is None:
        return 0.0
    if np.nanmin(stage.landscape.E) < NEAR_ZERO:
        return 1.0
    return 2.0 if off_deg(stage) < NEAR_DEG else 3.0


MEASURES: Mapping[str, Measure] = {
    "how E is with swapped points": Measure(_fits),
    "smallest E is off": Measure(off_deg, "°", 0),
    "least E as seen": Measure(least_as_seen, " px²"),
}
