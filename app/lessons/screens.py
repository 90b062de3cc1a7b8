"""The screens of a lesson in their order: questions before, steps, the same questions after, and the end."""

from collections.abc import Mapping
from dataclasses import dataclass

from .format import Choice, Lesson, Step
from .progress import Given


@dataclass(frozen=True)
class Screen:
    """What is shown at once: a step, a question before or after all, or the end. id: by which its answer is kept."""

    kind: str
    id: str
    number: int


def screens_of(lesson: Lesson) -> tuple[Screen, ...]:
    def asked(kind: str) -> list[Screen]:
        return [Screen(kind, f"{kind} {k}", k) for k in range(len(lesson.question))]

    steps = [Screen("step", step.id, k) for k, step in enumerate(lesson.step)]
    end = [Screen("end", "end", 0)] if lesson.question else []
    return (*asked("before"), *steps, *asked("after"), *end)


def asked_on(lesson: Lesson, screen: Screen) -> tuple[str, tuple[str, ...]]:
    """Words and answers of a question before or after all, in the order in which they are shown."""
    asked, before = lesson.question[screen.number], screen.kind == "before"
    answers = asked.answers if before else asked.answers_after
    turned = _order(screen.number, len(answers), before)
    return (asked.before if before else asked.after), tuple(answers[k] for k in turned)


def right_among(lesson: Lesson, kind: str, given: Mapping[str, Given]) -> int:
    """How many of the questions of that kind were answered rightly. given: by the screens' ids."""
    count = 0
    for k, asked in enumerate(lesson.question):
        choice = given.get(f"{kind} {k}", Given()).choice
        count += choice is not None and _order(k, len(asked.answers), kind == "before")[choice] == 0
    return count


def answers_by_id(lesson: Lesson) -> dict[str, tuple[Step | None, int]]:
    """Each screen's step, and among how many answers it is chosen there, by its id."""
    answers: dict[str, tuple[Step | None, int]] = {"end": (None, 0)}
    for step in lesson.step:
        answers[step.id] = step, len(step.ask.answers) if isinstance(step.ask, Choice) else 0
    for k, asked in enumerate(lesson.question):
        answers |= {f"{kind} {k}": (None, len(asked.answers)) for kind in ("before", "after")}
    return answers


def _order(number: int, count: int, before: bool) -> list[int]:
    """Of a question's answers, the first of which is right: turned by so many that it stands elsewhere each time."""
    by = (number + (1 if before else 2)) % count
    return [(k + by) % count for k in range(count)]
