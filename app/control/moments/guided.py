"""Which lesson a page is in, if any, and what was answered in all of them."""

from collections.abc import Callable, Mapping
from functools import partial

from ...jobs.landscapes import LandscapeWorker
from ...lessons.course import Course
from ...lessons.format import Lesson
from ...lessons.progress import Progress
from ..commands.command import Arrival
from ..queue import CommandQueue


class Guided:
    """lessons: by name, in order. course: the one that goes on, None on the page itself; offered: whether the first
    lesson is, to somebody who has not been here before."""

    def __init__(self, page_id: int, lessons: Mapping[str, Lesson], worker: LandscapeWorker, queue: CommandQueue):
        self.lessons = lessons
        self._page_id, self._worker, self._queue = page_id, worker, queue
        self._kept: dict[str, Progress] = {}
        self.course: Course | None = None
        self.offered = bool(lessons)

    def begin(self, name: str) -> None:
        """Where it was left. Raises ValueError for a name that is none."""
        if name not in self.lessons:
            raise ValueError(f"no lesson {name!r}; there are {', '.join(self.lessons)}")
        self.leave()
        progress = self._kept.get(name, Progress(lesson=name))
        self.course = Course(self.lessons[name], progress, self._work)

    def leave(self) -> None:
        """The page is as it was; what was answered is kept, and a lesson that is over begins anew next time."""
        self.offered = False
        if self.course is not None:
            done = self.course.progress.at == len(self.course.screens) - 1
            name = self.course.progress.lesson
            self._kept[name] = Progress(lesson=name) if done else self.course.progress
            self.course = None

    @property
    def kept(self) -> tuple[Progress, ...]:
        """To be resumed, that of the course as well."""
        now = {} if self.course is None else {self.course.progress.lesson: self.course.progress}
        return tuple({**self._kept, **now}.values())

    def resume(self, kept: tuple[Progress, ...], name: str | None, offered: bool) -> None:
        """What was kept; name: of the lesson that goes on. One that is there no more is forgotten."""
        self._kept = {progress.lesson: progress for progress in kept if progress.lesson in self.lessons}
        self.offered = offered and bool(self.lessons)
        if name is not None and name in self.lessons:
            self.begin(name)

    def _work(self, kind: str, make: Callable[[], object], take: Callable[[object], None]) -> None:
        done = partial(self._take_later, kind, self.course, take)
        self._worker.ask(self._page_id, make, done, kind=f"lesson {kind}")

    def _take_later(self, kind: str, course: Course | None, take: Callable[[object], None], made: object) -> None:
        self._queue.put(Arrival(("lesson", kind), take, made))
