"""Which answers a step takes: what is given by each, or ValueError where it is not asked for."""

import numpy as np
from numpy.typing import NDArray

from .figures import FIGURES
from .format import Choice, Do, Number, Place, Pose, Select, Step
from .progress import Given, Outcome
from .stage import Stage

FARTHEST = 1e4  # units of a drawing: no figure is as large
MOST_OUTCOMES = 50  # that are kept of a step
Ask = Choice | Do | Number | Place | Pose | Select | None


def choices(step: Step | None) -> int:
    """How many answers there are to choose from."""
    return len(step.ask.answers) if step is not None and isinstance(step.ask, Choice) else 0


def chosen(given: Given, k: int, count: int) -> int:
    """One of so many, counted from 0."""
    if not 0 <= k < count or given.revealed:
        raise ValueError(f"no answer {k + 1} here")
    return k


def placed(stage: Stage | None, at: NDArray) -> tuple[float, float]:
    """In the unit of the step's figure. at: (2,) units of its drawing."""
    ask = None if stage is None else stage.step.ask
    if stage is None or not isinstance(ask, Place) or stage.revealed or np.abs(at).max() > FARTHEST:
        raise ValueError("nothing is to be marked here")
    unplace = FIGURES[ask.figure].unplace
    assert unplace is not None
    x, y = unplace(stage, at).tolist()
    return round(x, 3), round(y, 3)


def guessed(given: Given, ask: Ask, number: float) -> float:
    if not isinstance(ask, Number) or given.revealed:
        raise ValueError("no number is asked for here")
    return float(np.clip(number, ask.low, ask.high))


def selected(given: Given, ask: Ask, k: int, value: int) -> tuple[int, ...]:
    """With one of the values of a field of settings, both counted from 0."""
    if not isinstance(ask, Select) or given.revealed:
        raise ValueError("nothing is to be selected here")
    if not (0 <= k < len(ask.fields) and 0 <= value < len(ask.fields[k].values)):
        raise ValueError(f"no value {value + 1} of field {k + 1} here")
    found = [*(given.selected or (-1,) * len(ask.fields))]
    found[k] = value
    return tuple(found)


def settings_selected(given: Given, ask: Ask) -> dict[str, object]:
    """Fields of settings, by name."""
    if not isinstance(ask, Select):
        return {}
    return {field.name: field.values[k].value for field, k in zip(ask.fields, given.selected) if k >= 0}


def is_answered(given: Given, ask: Ask) -> bool:
    """Whether it may be shown what is true."""
    if isinstance(ask, Choice):
        return given.choice is not None
    if isinstance(ask, Place | Pose):
        return given.place is not None
    if isinstance(ask, Number):
        return given.number is not None
    if isinstance(ask, Select):
        return len(given.selected) == len(ask.fields) and min(given.selected) >= 0
    return given.done if isinstance(ask, Do) else True


def with_outcome(given: Given, numbers: tuple[float, ...]) -> tuple[Outcome, ...]:
    """All that a step has come to, in place of what the same came to before."""
    now = Outcome(seed=given.seed, selected=given.selected, numbers=numbers)
    others = [old for old in given.outcomes if (old.seed, old.selected) != (now.seed, now.selected)]
    return *others[1 - MOST_OUTCOMES :], now
