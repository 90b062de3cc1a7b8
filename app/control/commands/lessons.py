"""Commands to a lesson: begin and leave it, answer, go on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ...lessons.course import Course
from ..checks import number
from ..page_model import PageModel
from .command import Command


@dataclass(frozen=True)
class InLesson(Command):
    """verb: what is done; numbers: with what."""

    verb: str
    numbers: tuple[float, ...] = ()
    in_lesson: ClassVar[bool] = True

    @property
    def when_locked(self) -> bool:  # type: ignore[override]  # of one instance
        return self.verb in ANSWERS

    def apply(self, model: PageModel, now: float) -> None:
        course = model.guided.course
        if course is None:
            raise ValueError("the lesson is over")
        VERBS[self.verb][1](course, *self.numbers)


@dataclass(frozen=True)
class BeginLesson(Command):
    name: str
    in_lesson: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.guided.begin(self.name)


class LeaveLesson(Command):
    in_lesson: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.guided.leave()


ANSWERS = {"choose", "select", "guess", "place", "turn"}
VERBS: Mapping[str, tuple[int, Callable[..., object]]] = {  # how many numbers, and what follows
    "next": (0, lambda course: course.go(1)),
    "back": (0, lambda course: course.go(-1)),
    "show": (0, Course.show),
    "present": (0, Course.present),
    "again": (0, Course.again),
    "seed": (1, lambda course, seed: course.again(round(seed))),
    "choose": (1, lambda course, k: course.choose(round(k))),
    "select": (2, lambda course, k, value: course.select(round(k), round(value))),
    "guess": (1, Course.guess),
    "place": (2, lambda course, x, y: course.place(np.array([x, y]))),
    "turn": (2, lambda course, k, value: course.turn(round(k), value)),
}


def touched(value: str) -> Command:
    """What a link of a lesson asks for: a verb and its numbers, separated by commas."""
    verb, *words = value.split(",")
    if verb == "begin" and len(words) == 1:
        return BeginLesson(words[0])
    if verb == "leave" and not words:
        return LeaveLesson()
    if verb not in VERBS or len(words) != VERBS[verb][0]:
        raise ValueError(f"nothing in a lesson is {value!r}")
    return InLesson(verb, tuple(map(number, words)))
