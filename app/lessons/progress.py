"""What was answered, and how far a lesson is: plain data that is kept with the session."""

import math

import msgspec

from .format import Step


class Given(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """To one step. choice: counted from 0; place: in the unit of its figure; path: postures, degrees, the start first;
    E: px², at each of them; sliders: where they stand; seed: of what is dealt at random; done: what was to be reached
    has been; revealed: what is true was shown."""

    choice: int | None = None
    place: tuple[float, float] | None = None
    number: float | None = None
    path: tuple[tuple[float, ...], ...] = ()
    E: tuple[float, ...] = ()
    sliders: tuple[float, ...] = ()
    seed: int = 1
    done: bool = False
    revealed: bool = False


class Progress(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """at: the screen that is shown; given: by the steps' ids."""

    lesson: str
    at: int = 0
    given: dict[str, Given] = {}


def fitting(given: Given, step: Step | None, answers: int) -> bool:
    """Whether it can have been given there: what is kept may be of another lesson of that name. step: None at a
    question; answers: that can be chosen."""
    places = given.place or (), (() if given.number is None else (given.number,)), given.sliders, given.E, *given.path
    finite = all(math.isfinite(number) for numbers in places for number in numbers)
    joints = {len(posture) for posture in given.path}
    turned = len(given.sliders) in (0, len(step.sliders) if step else 0)
    chosen = given.choice is None or 0 <= given.choice < answers
    return finite and turned and chosen and len(joints) <= 1 and len(given.path) == len(given.E)
