"""Whether an answer to a step is right, or near enough to be called so."""

import numpy as np
from numpy.typing import NDArray

from .answers import right_answer
from .format import Choice, Number, Place, Pose
from .measures import MEASURES
from .stage import Stage


def is_right(
    stage: Stage, choice: int | None = None, number: float | None = None, place: NDArray | tuple | None = None
) -> bool | None:
    """place: (2,) in the unit of the figure. None for no answer, and while what is true is computed."""
    ask = stage.step.ask
    if isinstance(ask, Choice) and choice is not None:
        right = right_answer(stage, ask)
        return None if right is None else choice == right
    if isinstance(ask, Place | Pose) and place is not None:
        off = float(np.linalg.norm(np.array(place) - MEASURES[ask.truth].of(stage)))
        return None if np.isnan(off) else off <= ask.near
    if isinstance(ask, Number) and number is not None:
        truth = float(MEASURES[ask.truth].of(stage))
        return None if np.isnan(truth) else is_near(ask, number, truth)
    return None


def is_near(ask: Number, number: float, truth: float) -> bool:
    if ask.factor is not None:
        return truth > 0 and 1 / ask.factor <= number / truth <= ask.factor
    return abs(number - truth) <= (ask.within or 0.0)
