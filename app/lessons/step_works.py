"""The works of a step: which of them are due when, and what has come of them."""

import dataclasses
from collections.abc import Callable
from functools import partial

from .figures import FIGURES
from .works import WORKS
from .works.work import Task

Work = Callable[[str, Callable[[], object], Callable[[object], None]], None]


class StepWorks:
    """work(kind, make, take): make() beside the page, then take(what came of it, or the exception) in the page's own
    time; arrived(): something of this step has come; keep(numbers): an outcome. made: by name; failed: what could not
    be computed, and why."""

    def __init__(self, work: Work, arrived: Callable[[], None], keep: Callable[[tuple[float, ...]], None]):
        self._work, self._arrived, self._keep = work, arrived, keep
        self._visits = 0
        self.begin()

    def begin(self) -> None:
        """The step is another, or from another start: what is made for the one before is of no use."""
        self._visits += 1
        self.made: dict[str, object] = {}
        self.failed: tuple[str, ...] = ()

    @property
    def plays(self) -> bool:
        """Whether something has come that has motions."""
        return any(WORKS[name].played for name in self.made)

    def ask(self, task: Task, *when: str) -> None:
        """For those of the step's figures, and its own, that are due then."""
        step = task.step
        shown = [name for figure in (*step.main, *step.side) for name in FIGURES[figure.figure].works]
        for name in dict.fromkeys((*shown, *step.works)):
            if WORKS[name].when in when:
                self._make(name, task)

    def _make(self, name: str, task: Task) -> None:
        self._work(name, partial(WORKS[name].make, task), partial(self._take, task, self._visits, name))

    def _take(self, task: Task, visit: int, name: str, made: object) -> None:
        """made: or what was raised; visit: of the screen and the start that it was made for."""
        if visit != self._visits:
            return
        self._arrived()
        if isinstance(made, Exception):
            self.failed = (*self.failed, f"{name}: {made}")
            return
        self.made = {**self.made, name: made}
        work = WORKS[name]
        if work.goes_on(made):
            self._make(name, dataclasses.replace(task, made=made))
        elif work.outcome is not None:
            self._keep(work.outcome(made))
