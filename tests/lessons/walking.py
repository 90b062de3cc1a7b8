"""A walk through a shipped lesson without a page: works are made at once; and what stands on it."""

import re
from collections.abc import Callable

from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.course import Course
from viewimit.app.lessons.progress import Progress
from viewimit.app.lessons.source import shipped


def at_once(kind: str, make: Callable[[], object], take: Callable[[object], None]) -> None:
    take(make())


def course_at(step: str) -> Course:
    """A course that has just come to a step, by its id."""
    name, lesson = next((name, one) for name, one in shipped().items() if step in {each.id for each in one.step})
    course = Course(lesson, Progress(lesson=name), at_once)
    assert course.go(next(k for k, screen in enumerate(course.screens) if screen.id == step))
    return course


def words(course: Course) -> str:
    """Of the page, without its markup; those of drawings too."""
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", draw_lesson(course, "/x")))
