"""Walk to a step of a shipped lesson by its id, and read what stands on the page."""

import re

from viewimit.app.lessons.card import draw_lesson
from viewimit.app.lessons.course import Course
from viewimit.app.lessons.progress import Progress
from viewimit.app.lessons.source import shipped


def course_at(step: str) -> Course:
    """At the beginning of the step, works made at once."""
    name, lesson = next((name, one) for name, one in shipped().items() if step in {each.id for each in one.step})
    at = len(lesson.question) + [each.id for each in lesson.step].index(step)
    return Course(lesson, Progress(lesson=name, at=at), lambda kind, make, take: take(make()))


def words(course: Course) -> str:
    """Of the page, without its markup; those of drawings too."""
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", draw_lesson(course, "/x")))
