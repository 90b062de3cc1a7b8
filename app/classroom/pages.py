"""The pages of a class: its lessons in one page, with what a lecturer and students need, and the lab."""

import multiprocessing
import os
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from ..lab.lessons.format import Lesson
from ..lab.lessons.page import HERE, lesson_page
from ..lab.lessons.source import find, shipped
from ..lab.page import lab_page
from .server import Page

ENTRY = "lessons/class.js"


def class_pages(given: Sequence[str], embed: Sequence[str]) -> dict[str, Callable[[], Page]]:
    """Return what makes each page, by path. Another process computes it: up to a minute, if nothing is cached.

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
    make = lambda page: Page(_in_another_process(page), embed)
    return {"/": partial(make, partial(_lessons_page, lessons)), "/lab": partial(make, lab_page)}


def _lessons_page(lessons: Mapping[str, Lesson]) -> str:
    return lesson_page(lessons, ENTRY, HERE.joinpath("class.css").read_text("utf-8"))


def _in_another_process(page: Callable[[], str]) -> str:
    """The server goes on meanwhile."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn"), _begin) as pool:
        return pool.submit(page).result()


def _begin() -> None:
    """Leave the processor to the server, and end with it, even if it is killed. Windows has no niceness."""
    if sys.platform != "win32":
        os.nice(5)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
