"""One task that steps and draws every page, in viser's own event loop.

A thread beside it would wait for it at every message, and it for the thread; a thread a session would starve it.
"""

import asyncio
import concurrent.futures
import threading
import time
import traceback

from ..server.seat_counts import WorkerCounts
from .shedding import Load

TICK = 0.05  # s: poses are drawn at 20 Hz


class Scheduler:
    """Pages are added when they are built and removed when their tab is gone. row: gets a sign of life every tick."""

    def __init__(self, row: WorkerCounts):
        self._row = row
        self._lock, self._turn = threading.Lock(), threading.RLock()  # of the list; held while a page ticks
        self._pages: list = []
        self.load = Load(TICK)
        self._running = False
        self._task: concurrent.futures.Future | None = None

    def start(self, loop: asyncio.AbstractEventLoop) -> None:
        """From any thread."""
        self._running = True
        self._task = asyncio.run_coroutine_threadsafe(self._run(), loop)

    def stop(self) -> None:
        """Not from the loop's own thread."""
        self._running = False
        concurrent.futures.wait([self._task], 2.0)
        self._row.clear()

    def add(self, page) -> None:
        with self._lock:
            self._pages.append(page)

    def remove(self, page) -> None:
        """Afterwards it is ticked no more, nor is it just being ticked."""
        with self._turn, self._lock:
            if page in self._pages:
                self._pages.remove(page)

    def _tell(self, page, error: Exception) -> None:
        """Let a page say its own fault; one that cannot even do that is ticked no more."""
        try:
            page.fail(error)
        except Exception:
            traceback.print_exc()
            self.remove(page)

    def _tick(self, page) -> None:
        if page not in self._pages:  # it has just been removed
            return
        try:
            page.tick(time.monotonic())
        except Exception as error:  # one session's fault must not stop the others; its own page says so
            traceback.print_exc()
            self._tell(page, error)

    async def _run(self) -> None:
        next_tick = time.monotonic()
        while self._running:
            began = time.monotonic()
            self._row.live()
            with self._lock:
                pages = list(self._pages)
            for page in pages:
                with self._turn:
                    self._tick(page)
                await asyncio.sleep(0)  # what was drawn is sent
            self.load.ticked(time.monotonic() - began)
            # one long tick is made up for by the next short one; further behind, ticks are skipped, not chased
            next_tick = max(next_tick + TICK, time.monotonic() - TICK)
            await asyncio.sleep(max(next_tick - time.monotonic(), 0))
