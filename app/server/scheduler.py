"""One task that moves and draws all pages, in viser's own event loop."""

import asyncio
import concurrent.futures
import logging
import time
from collections.abc import Callable

from ..page.page import Page
from .limits import TokenBucket, in_a_line

TICK = 0.05  # s: poses are drawn at 20 Hz
SPARE = 0.01  # s of a tick in which nothing more is drawn: poses go first
# In a round that is late, a page that waited for PATIENCE s is drawn as long as such drawings take < LATE_DRAWINGS s.
PATIENCE, LATE_DRAWINGS = 0.5, TICK
FAST = 0.4  # of a tick: for sessions that run as fast as they compute
LEAST_FAST = 0.001  # s: one motion of each, in a round that is late
BEAT = 1.0  # s
log = logging.getLogger(__name__)


class Scheduler:
    """Pages are added when they are built and removed when their tab is gone, both in the loop's own thread.
    heartbeat(): called once a second."""

    def __init__(self, heartbeat: Callable[[], None] = lambda: None):
        self._heartbeat = heartbeat
        self._drawn_at: dict[Page, float] = {}  # s
        self._late_s = 0.0  # s, what drawings have taken of a round that is late
        self._faults = TokenBucket(1, 1)  # in the log
        self._task: concurrent.futures.Future | None = None
        self._running = False

    def start(self, loop: asyncio.AbstractEventLoop) -> None:
        """From any thread."""
        self._running = True
        self._task = asyncio.run_coroutine_threadsafe(self._run(), loop)

    def stop(self) -> None:
        """Not from the loop's own thread."""
        self._running = False
        if self._task is not None:
            concurrent.futures.wait([self._task], 2.0)

    def add(self, page: Page) -> None:
        self._drawn_at[page] = 0.0

    def remove(self, page: Page) -> None:
        """Afterwards it is ticked no more."""
        self._drawn_at.pop(page, None)

    async def _run(self) -> None:
        due, beats_at = time.monotonic(), 0.0
        while self._running:
            if time.monotonic() >= beats_at:
                self._heartbeat()
                beats_at = time.monotonic() + BEAT
            self._late_s = 0.0
            for page in sorted(self._drawn_at, key=self._drawn_at.__getitem__):  # who waits longest comes first
                if page in self._drawn_at:
                    self._pass(page, due)
                    await asyncio.sleep(0)  # what it drew is sent, and what comes in is read
            due = max(due + TICK, time.monotonic() - TICK)  # one long round is made up for, more are skipped
            await asyncio.sleep(max(due - time.monotonic(), 0))

    def _pass(self, page: Page, due: float) -> None:
        """Move a page and pose its arms, and draw all else unless the round is late."""
        now = time.monotonic()
        try:
            with page.held():
                page.tick(now, max(due + FAST * TICK - now, LEAST_FAST))
                in_time = now - due < TICK - SPARE
                if in_time or (now - self._drawn_at[page] > PATIENCE and self._late_s < LATE_DRAWINGS):
                    self._drawn_at[page] = begins = time.monotonic()
                    page.draw()
                    self._late_s += 0.0 if in_time else time.monotonic() - begins
        except Exception as error:  # one session's fault must not stop the others; its own page says so
            self._tell(page, error)

    def _tell(self, page: Page, error: Exception) -> None:
        """Let a page say its own fault; one that cannot even do that is ticked no more."""
        if self._faults.take():
            log.error(in_a_line("a session met an error", error))
        try:
            page.fail(error)
        except Exception as worse:
            log.error(in_a_line("a session cannot say its error and is left", worse))
            self.remove(page)
