"""Of a posture that the visitor gives a see-through arm: what it should be, and how far off it is, joint by joint."""

from collections.abc import Callable, Mapping

import numpy as np

from ..stage import Stage
from .measure import Measure


def _joint_off(k: int) -> Callable[[Stage], float]:
    """Degrees from the see-through arm's joint to the demonstrator's."""

    def of(stage: Stage) -> float:
        guess, truth = stage.guess, np.degrees(stage.moment.theta_demo)
        return np.nan if guess is None or k >= len(truth) else float(abs(guess[k] - truth[k]))

    return of


def _E(stage: Stage) -> float:
    return np.nan if stage.guessed is None else stage.guessed.E


MEASURES: Mapping[str, Measure] = {
    "the demonstrator's posture": Measure(lambda stage: np.degrees(stage.moment.theta_demo)),
    "E of your posture": Measure(_E, " px²"),
    "your first joint is off": Measure(_joint_off(0), "°", 0),
    "your second joint is off": Measure(_joint_off(1), "°", 0),
}
