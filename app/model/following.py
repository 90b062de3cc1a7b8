"""A link, or what a tab has kept: its scripts are played beside the page, which then becomes what they lead to."""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

from viewimit.loop.session import Session

from ..jobs.camera_images import CameraProcess, eyes_beside
from .link import Linked
from .player import DENSE
from .queue import CommandQueue, Queued
from .services import Services

TURN_S = 0.02  # of one page's scripts, before those of the next have their turn
MAX_S = 30.0  # that scripts may take


@dataclass(eq=False)
class Played:
    """What a link holds, and its sessions as far as they are played.

    is_own: it is what the page's own tab has kept; camera: renders the pictures; error: why they are not played.
    """

    page: Linked
    is_own: bool
    camera: CameraProcess
    sessions: list[Session] = field(default_factory=list)
    error: Exception | None = None
    spent_s: float = 0.0

    def passes(self) -> Iterator[None]:
        """Play it, and yield after each pass of the loop."""
        for script in self.page.scripts:
            session = Session(script.settings, open_eyes=eyes_beside(self.camera), dense=DENSE)
            yield from session.passes(script)
            session.scrub(min(self.page.at, len(session.history) - 1))
            self.sessions.append(session)

    def turn(self, passes: Iterator[None]) -> bool:
        """Play on for a turn, and rest as long, which leaves the pages time. Return whether it is whole."""
        clock = time.monotonic if self.page.uses_pictures else time.thread_time
        began, computed = clock(), time.thread_time()
        while clock() - began < TURN_S:
            if next(passes, passes) is passes:
                return True
            if self.spent_s + clock() - began > MAX_S:
                raise ValueError(f"it takes more than {MAX_S:g} s to compute")
        self.spent_s += clock() - began
        time.sleep(time.thread_time() - computed)
        return False


class Following:
    """The saved page that a page becomes, if any."""

    def __init__(self, page_id: int, services: Services, queue: CommandQueue):
        self._page_id, self._services, self._queue = page_id, services, queue
        self._played: Played | None = None
        self.goes_on = False  # whether a script is still played
        self.restores = False  # whether it is what the page's own tab has kept, before which nothing else counts

    def begin(self, page: Linked, arrival: Callable[[Played], Queued], is_own: bool = False) -> None:
        """Play a saved page instead of the one that is played now. arrival: the entry that then takes it."""
        self.let_go()
        played = self._played = Played(page, is_own, self._services.camera)
        self.goes_on, self.restores = True, is_own
        worker = self._services.picture_scripts if page.uses_pictures else self._services.scripts
        turn = partial(played.turn, played.passes())

        def go_on(whole: bool | Exception) -> None:
            if played is not self._played:  # it was cancelled
                return
            if whole is False:
                return worker.ask(self._page_id, turn, go_on)
            played.error = whole if isinstance(whole, Exception) else None
            self._queue.put(arrival(played))

        go_on(False)

    def let_go(self) -> bool:
        """Follow it no more. Return whether there was one."""
        played, self._played = self._played, None
        self.goes_on = self.restores = False
        return played is not None

    def finish(self, played: Played) -> bool:
        """Return whether this page is the one to be played: else it was cancelled just when it was complete."""
        return played is self._played and self.let_go()
