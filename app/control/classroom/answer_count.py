"""What a class has answered, counted while the lecturer's page stands at the question."""

from typing import Any

from ...classroom.member import Seen
from ...classroom.messages import Asked, Tally
from ...lessons.course import Course
from .tally import tally_of


class AnswerCount:
    """told: whether the answers are shown before they are revealed."""

    def __init__(self) -> None:
        self.told = False
        self.tally: Tally | None = None
        self._of: tuple[Any, ...] = ()  # what was counted

    def begin(self) -> None:
        """A question is asked, or once more."""
        self.told, self.tally, self._of = False, None, ()

    def count(self, seen: Seen, asked: Asked | None, course: Course | None) -> bool:
        """If there is something new. → whether there is, and the page stands at the question."""
        step = None if course is None else course.step
        if asked is None or course is None or step is None:
            return False
        stage = course.stage
        if stage is None or (course.progress.lesson, step.id) != (asked.round.lesson, asked.round.step):
            return False
        of = seen.answers, seen.earlier, asked.round, asked.revealed, self.told, len(course.made)
        if len(self._of) == len(of) and all(a is b or a == b for a, b in zip(of, self._of)):
            return False
        self._of = of
        self.tally = tally_of(stage, seen.answers, seen.earlier)
        course.show_others(self.tally.places if self.told else ())
        return True
