"""Which answers fit the questions of a class, and which of them are right. What browsers think of that is not asked."""

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from ..lab.lessons.format import Ask, Bet, Choice, Do, Lesson, Number, Place, Pose, Predict
from ..lab.lessons.source import questions
from .protocol import Given

QUESTIONS = "questions"  # the form of the eight questions
Asks: TypeAlias = Mapping[tuple[str, str], Ask]  # by lesson and step
FIELD = {
    Choice: "choice", Place: "place", Pose: "posture", Number: "number", Do: "number", Predict: "values", Bet: "values",
}  # fmt: skip


def asks_of(lessons: Mapping[str, Lesson]) -> Asks:
    """Return all that lessons ask, the eight questions included where a lesson has them."""
    asks = {(name, step.id): step.ask for name, lesson in lessons.items() for step in lesson.step}
    if any(lesson.questions for lesson in lessons.values()):
        asks |= {(QUESTIONS, item.id): Choice(question=item.text, answers=item.answers) for item in questions().item}
    return asks


def fits(ask: Ask, given: Given) -> bool:
    """Return whether an answer is of the kind that is asked for."""
    if getattr(given, FIELD[type(ask)]) is None:
        return False
    return not isinstance(ask, Choice) or given.choice is None or given.choice < len(ask.answers)


def is_right(ask: Ask, given: Given, truth: Sequence[Sequence[float]] = (), near: float | None = None) -> bool | None:
    """Return whether an answer, which fits what is asked, is right; None where nothing is, or it is not known. truth:
    what the lecturer's page has computed where the lesson's file does not say it: the number of the right answer from
    1, a number, a posture, a place, or the corners of a line; near: how far a place may be from it, None for
    `ask.near`."""
    if isinstance(ask, Choice) and ask.right is None:
        return ask.answers[given.choice or 0].right
    if not truth or not isinstance(ask, Choice | Number | Pose | Place):
        return None
    first = truth[0]
    if isinstance(ask, Choice):
        return given.choice == round(first[0]) - 1
    if isinstance(ask, Number):
        value, true = given.number or 0.0, first[0]
        if ask.factor:
            return true > 0 and true / ask.factor <= value <= true * ask.factor
        return abs(value - true) <= (ask.within or 0)
    if isinstance(ask, Pose):
        return bool(np.abs(np.subtract(given.posture or (), first)).max() <= ask.near)
    return _distance(given.place or (), truth) <= (ask.near if near is None else near)


def _distance(place: Sequence[float], corners: Sequence[Sequence[float]]) -> float:
    """From a place to the nearest one of a line, or to its only corner."""
    at, line = np.asarray(place), np.asarray(corners)
    begins, ways = line[: max(1, len(line) - 1)], np.diff(line, axis=0) if len(line) > 1 else np.zeros((1, 2))
    length = np.maximum((ways**2).sum(1), np.finfo(float).tiny)
    shares = np.clip(((at - begins) * ways).sum(1) / length, 0, 1)
    return float(np.linalg.norm(begins + shares[:, None] * ways - at, axis=1).min())
