"""The pages of a class: its lessons in one page, with what a lecturer and students need, and the lab."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

from ..lab.lessons.format import Lesson
from ..lab.lessons.page import HERE, lesson_page
from ..lab.lessons.source import find, shipped
from ..lab.page import lab_page
from .server import Page

ENTRY = "lessons/class.js"


def class_pages(given: Sequence[str], embed: Sequence[str]) -> dict[str, Callable[[], Page]]:
    """Return what makes each page, by path. A lecturer's own lessons take seconds, as they are computed.

    Parameters
    ----------
    given
        Names of shipped lessons or paths of files; none for all shipped ones.
    embed
        Origins whose pages may show a page in a frame.

    Raises
    ------
    ValueError
        For a lesson that is none, with its file, line and field.
    OSError
        For a file that cannot be read.
    """
    lessons = dict(map(find, given)) if given else shipped()
    make = lambda page: Page(page(), embed)
    return {"/": partial(make, partial(_lessons_page, lessons)), "/lab": partial(make, lab_page)}


def _lessons_page(lessons: Mapping[str, Lesson]) -> str:
    return lesson_page(lessons, ENTRY, HERE.joinpath("class.css").read_text("utf-8"))
