"""What a class has answered as a table: a line for each answer, nobody's name in it."""

import csv
import io
import secrets
from collections.abc import Mapping

from ...classroom.member import Rounds
from ...classroom.messages import Answer
from ...lessons.format import Choice, Lesson, Number, Place, Pose

HEADER = ("lesson", "step", "question", "asked", "person", "answer", "number", "x", "y")


def as_csv(rounds: Rounds, lessons: Mapping[str, Lesson]) -> bytes:
    """asked: how often the same step had been, counted from 1; person: a number within one step, by chance, so that
    who moved from one answer to another can be counted; answer: a choice's words; x, y: of a place or posture."""
    text = io.StringIO()
    table = csv.writer(text)
    table.writerow(HEADER)
    times: dict[tuple[str, str], int] = {}
    persons: dict[tuple[str, str], dict[str, int]] = {}
    for asked, answers in rounds:
        of = asked.lesson, asked.step
        times[of] = times.get(of, 0) + 1
        numbers = persons.setdefault(of, {})
        new = [one for one in answers if one not in numbers]
        secrets.SystemRandom().shuffle(new)
        numbers |= {one: len(numbers) + k + 1 for k, one in enumerate(new)}
        for student, answer in sorted(answers.items(), key=lambda item: numbers[item[0]]):
            told = _told(answer, *of, lessons)
            if told is not None:
                question, rest = told
                table.writerow((*of, question, times[of], numbers[student], *rest))
    return text.getvalue().encode()


def _told(answer: Answer, lesson: str, step: str, lessons: Mapping[str, Lesson]) -> tuple[str, tuple] | None:
    """The question, and the columns of an answer to it; None for what is no answer to it."""
    found = next((one for one in lessons[lesson].step if one.id == step), None) if lesson in lessons else None
    ask = None if found is None else found.ask
    if isinstance(ask, Choice) and answer.choice is not None and answer.choice < len(ask.answers):
        return ask.question, (ask.answers[answer.choice].text, answer.choice + 1, "", "")
    if isinstance(ask, Number) and answer.number is not None:
        return ask.question, ("", answer.number, "", "")
    if isinstance(ask, Place | Pose) and answer.place is not None:
        return ask.question, ("", "", *answer.place)
    return None
