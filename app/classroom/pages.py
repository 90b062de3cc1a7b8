"""The pages of a class: its lessons with what a lecturer and students need, and the lab."""

from collections.abc import Callable, Sequence

from ..lab.page import lab_page
from .server import Page


def class_pages(lessons: Sequence[str], embed: Sequence[str]) -> dict[str, Callable[[], Page]]:
    """Return what makes each page, by path.

    Parameters
    ----------
    lessons
        Names of shipped lessons or paths of files; none for all shipped ones.
    embed
        Origins whose pages may show a page in a frame.

    Raises
    ------
    ValueError
        For a lesson that is none, with its file, line and field.
    """
    return {"/": lambda: Page(lab_page(), embed), "/lab": lambda: Page(lab_page(), embed)}
