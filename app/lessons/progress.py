"""What was answered, and how far a lesson is: plain data that is kept with the session."""

import math

import msgspec

from .format import Field, Select, Step


class Outcome(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Of a work that keeps one. seed: of what was dealt; selected: as `Given` has it; numbers: what it came to."""

    seed: int
    selected: tuple[int, ...]
    numbers: tuple[float, ...]


class Given(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """To one step. choice: counted from 0; place: in the unit of its figure; path: postures, degrees, the start first;
    E: px², at each of them; sliders: where they stand; seed: of what is dealt at random; done: what was to be reached
    has been; revealed: what is true was shown; selected: which value of each field, counted from 0, -1 for none yet;
    outcomes: of all seeds up to now, the newest last."""

    choice: int | None = None
    place: tuple[float, float] | None = None
    number: float | None = None
    path: tuple[tuple[float, ...], ...] = ()
    E: tuple[float, ...] = ()
    sliders: tuple[float, ...] = ()
    seed: int = 1
    done: bool = False
    revealed: bool = False
    selected: tuple[int, ...] = ()
    outcomes: tuple[Outcome, ...] = ()


class Progress(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """at: the screen that is shown; given: by the steps' ids."""

    lesson: str
    at: int = 0
    given: dict[str, Given] = {}


def fitting(given: Given, step: Step | None, answers: int) -> bool:
    """Whether it can have been given there: what is kept may be of another lesson of that name. step: None at a
    question; answers: that can be chosen."""
    places = given.place or (), (() if given.number is None else (given.number,)), given.sliders, given.E, *given.path
    numbers = *places, *(outcome.numbers for outcome in given.outcomes)
    finite = all(math.isfinite(number) for found in numbers for number in found)
    joints = {len(posture) for posture in given.path}
    turned = len(given.sliders) in (0, len(step.sliders) if step else 0)
    chosen = given.choice is None or 0 <= given.choice < answers
    path = len(joints) <= 1 and len(given.path) == len(given.E)
    fields = step.ask.fields if step is not None and isinstance(step.ask, Select) else ()
    selections = given.selected, *(outcome.selected for outcome in given.outcomes)
    selected = all(_selects(fields, selection) for selection in selections)
    return finite and turned and chosen and path and selected


def _selects(fields: tuple[Field, ...], selected: tuple[int, ...]) -> bool:
    whole = len(selected) in (0, len(fields))
    return whole and all(-1 <= k < len(field.values) for field, k in zip(fields, selected))
