"""Which lesson a page is in, if any, and what was answered in all of them."""

from collections.abc import Callable, Mapping

import msgspec

from ...jobs.landscapes import LandscapeWorker
from ...lessons.course import Course
from ...lessons.format import Lesson
from ...lessons.progress import Progress
from ..queue import CommandQueue


class Guided:
    """lessons: by name, in order. course: the one that goes on, None on the page itself; offered: whether the first
    lesson is, to somebody who has not been here before."""

    def __init__(self, page_id: int, lessons: Mapping[str, Lesson], worker: LandscapeWorker, queue: CommandQueue):
        self.lessons = lessons
        self._page_id, self._worker, self._queue = page_id, worker, queue
        self._kept: dict[str, Progress] = {}
        self.course: Course | None = None
        self.asked = False  # the course is a question's that a class is asked; before: the lesson that it interrupts
        self._before: str | None = None
        self.offered = bool(lessons)

    def begin(self, name: str, at: int | None = None) -> None:
        """Where it was left, or at a screen, from 0; the last one where there are fewer. Raises ValueError for a name
        that is none."""
        if name not in self.lessons:
            raise ValueError(f"no lesson {name!r}; there are {', '.join(self.lessons)}")
        self.leave()
        progress = self._kept.get(name, Progress(lesson=name))
        if at is not None:
            progress = msgspec.structs.replace(progress, at=at)
        self.course = Course(self.lessons[name], progress, self._work)

    @property
    def place(self) -> tuple[str, int] | None:
        """The lesson that goes on, and its screen."""
        return None if self.course is None else (self.course.progress.lesson, self.course.progress.at)

    def require(self, place: tuple[str, int] | None) -> None:
        """Raises ValueError for that of a lesson that is not here."""
        if place is not None and place[0] not in self.lessons:
            raise ValueError(f"the link opens a lesson that is not here, {place[0][:80]!r}")

    def leave(self) -> None:
        """The page is as it was; what was answered is kept, and a lesson that is over begins anew next time."""
        self.offered = False
        if self.asked:
            self.course, self.asked = None, False
        if self.course is not None:
            done = self.course.progress.at == len(self.course.screens) - 1
            name = self.course.progress.lesson
            self._kept[name] = Progress(lesson=name) if done else self.course.progress
            self.course = None

    @property
    def kept(self) -> tuple[Progress, ...]:
        """To be resumed, that of the course as well."""
        now = {} if self.course is None or self.asked else {self.course.progress.lesson: self.course.progress}
        return tuple({**self._kept, **now}.values())

    @property
    def going_on(self) -> str | None:
        """The lesson that is to be gone on with when the page comes back."""
        return self._before if self.asked else None if self.course is None else self.course.progress.lesson

    def go_to(self, name: str, at: int) -> None:
        """A screen of a lesson, counted from 0. Raises ValueError for what is none."""
        if self.course is None or self.asked or self.course.progress.lesson != name:
            self.begin(name)
        assert self.course is not None
        if not 0 <= at < len(self.course.screens):
            raise ValueError(f"no screen {at + 1} in the lesson {name!r}")
        if at != self.course.progress.at:
            self.course.go(at - self.course.progress.at)

    def go_to_step(self, name: str, step: str) -> None:
        """By its id. Raises ValueError for what is none."""
        self.go_to(name, self._screen_of(name, step))

    def ask(self, name: str, step: str) -> None:
        """A step's question apart from all that was answered before, which is gone on with afterwards. Raises
        ValueError for what is none."""
        at = self._screen_of(name, step)
        before = self.going_on
        self.leave()
        self._before = before
        self.course = Course(self.lessons[name], Progress(lesson=name, at=at), self._work)
        self.asked = True

    def end_question(self) -> None:
        """The page goes on where it was."""
        if self.asked:
            self.leave()
            if self._before is not None:
                self.begin(self._before)

    def _screen_of(self, name: str, step: str) -> int:
        if name not in self.lessons:
            raise ValueError(f"no lesson {name!r}; there are {', '.join(self.lessons)}")
        lesson = self.lessons[name]
        found = next((k for k, one in enumerate(lesson.step) if one.id == step), None)
        if found is None:
            raise ValueError(f"no step {step!r} in the lesson {name!r}")
        return len(lesson.question) + found

    def resume(self, kept: tuple[Progress, ...], name: str | None, offered: bool) -> None:
        """What was kept; name: of the lesson that goes on. One that is there no more is forgotten."""
        self._kept = {progress.lesson: progress for progress in kept if progress.lesson in self.lessons}
        self.offered = offered and bool(self.lessons)
        if name is not None and name in self.lessons:
            self.begin(name)

    def _work(self, kind: str, make: Callable[[], object], take: Callable[[object], None]) -> None:
        self._worker.ask(self._page_id, make, self._queue.taker(("lesson", kind), take), kind=f"lesson {kind}")
