"""The pages of a class: its lessons in one page, with what a lecturer and students need, and the lab."""

from collections.abc import Mapping, Sequence

from ..lab.lessons.format import Lesson
from ..lab.lessons.page import HERE, lesson_page
from ..lab.lessons.source import find, shipped
from ..lab.page import lab_page
from ..ways import Ways
from .server import Page

ENTRY = "lessons/class.js"
WAYS = Ways(play="lab", learn="./")
STYLES = "class.css", "../challenge/challenge.css"


def lessons_of(given: Sequence[str]) -> dict[str, Lesson]:
    """Return lessons by name, of names or files; without any, all that are shipped.

    Raises ValueError for a lesson that does not exist, or a file that is no lesson; OSError.
    """
    return dict(map(find, given)) if given else shipped()


def class_pages(lessons: Mapping[str, Lesson], embed: Sequence[str]) -> dict[str, Page]:
    """Return the pages by path. A lecturer's own lessons take seconds, as they are computed.

    embed: origins whose pages may show a page in a frame.
    """
    styles = "\n".join((HERE / name).read_text("utf-8") for name in STYLES)
    return {
        "/": Page(lesson_page(lessons, ENTRY, styles, ways=WAYS), embed),
        "/lab": Page(lab_page(ways=WAYS), embed),
    }
