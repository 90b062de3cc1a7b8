"""One task that steps and draws every page, in viser's own event loop.

A thread beside it would wait for it at every message, and it for the thread; a thread a session would starve it.
"""

from __future__ import annotations

import asyncio
import concurrent.futures
import contextlib
import logging
import threading
import time
import traceback
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from functools import partial
from pathlib import Path
from typing import Protocol, TypeVar

from ..model.services import LoadShedding, ToDraw

TICK = 0.05  # s: poses are drawn at 20 Hz
TOGETHER = 16  # pages that are drawn kind by kind
FEW = 3  # that are so while there is too much to draw
AT_ONCE = 0.002  # s that may pass before what comes in is read
FAULTS_EVERY = 1.0  # s between two faults that are logged, of all pages: each is one line
FRAMES = 4  # of a fault, innermost
log = logging.getLogger(__name__)
T = TypeVar("T")


class Ticked(Protocol):
    """A page. held(): nothing of it is sent inside; tick(now): up to its poses, s of a monotonic clock; drawings(): all
    else that is to be drawn then, each independent of the others; fail(error): what these raised, for it to say."""

    def held(self) -> AbstractContextManager: ...

    def tick(self, now: float) -> None: ...

    def drawings(self) -> Iterable[ToDraw]: ...

    def fail(self, error: Exception) -> None: ...


class Scheduler:
    """Pages are added when they are built and removed when their tab is gone. heartbeat(): called every tick;
    on_stop(): when there will be no more."""

    def __init__(self, heartbeat: Callable[[], None] = lambda: None, on_stop: Callable[[], None] = lambda: None):
        self._heartbeat, self._on_stop = heartbeat, on_stop
        self._lock, self._turn = threading.Lock(), threading.RLock()  # of the list; held while a page ticks
        self._pages: list[Ticked] = []
        self._logged_at = -FAULTS_EVERY  # when a fault was, s
        self._unlogged = 0  # faults since
        self.shedding = LoadShedding(TICK)
        self._gave_way = 0.0  # s
        self._left_out: Sequence[Ticked] = ()  # of the last round's drawings, in their turn
        self._running = False
        self._task: concurrent.futures.Future | None = None

    def start(self, loop: asyncio.AbstractEventLoop) -> None:
        """From any thread."""
        self._running = True
        self._task = asyncio.run_coroutine_threadsafe(self._run(), loop)

    def stop(self) -> None:
        """Not from the loop's own thread."""
        self._running = False
        if self._task is not None:
            concurrent.futures.wait([self._task], 2.0)
        self._on_stop()

    def add(self, page: Ticked) -> None:
        with self._lock:
            self._pages.append(page)

    def remove(self, page: Ticked) -> None:
        """Afterwards it is ticked no more, nor is it just being ticked."""
        with self._turn, self._lock:
            if page in self._pages:
                self._pages.remove(page)

    def _tell(self, page: Ticked, error: Exception) -> None:
        """Let a page say its own fault; one that cannot even do that is ticked no more."""
        try:
            page.fail(error)
        except Exception as worse:
            self._log(worse, anyway=True)
            self.remove(page)

    async def round(self, pages: Sequence[Ticked], until: float) -> float:
        """Each page's poses, and what else is to be drawn, by a time. → s that it took, and that there are too few."""
        began, lacking = time.monotonic(), 0.0
        waiting, self._left_out = self._left_out, ()
        if self.shedding.strain:
            lacking = await self._within(pages, until, waiting)
        else:
            for alike in _parts(pages, TOGETHER):
                with _holding(alike) as held:
                    for page in alike:
                        self._let(page, partial(page.tick, time.monotonic()))
                        await self._give_way()
                    await self._draw(held)
                await asyncio.sleep(0)  # the drawings are sent
        return time.monotonic() - began + lacking

    async def _within(self, pages: Sequence[Ticked], until: float, waiting: Sequence[Ticked]) -> float:
        """Poses do not wait for drawings, of which there are too many: pages that the time is not enough for come first
        in the next round. waiting: those of the last one. → s for pages left out twice: those left out once are
        drawn in the next round, which takes its time."""
        for page in pages:
            with page.held():
                self._let(page, partial(page.tick, time.monotonic()))
            await self._give_way()
        began, drawn = time.monotonic(), 0
        at = next((pages.index(page) for page in waiting if page in pages), 0)
        in_turn = [*pages[at:], *pages[:at]]
        for few in _parts(in_turn, FEW):
            if drawn and time.monotonic() >= until:
                break
            with _holding(few) as held:
                await self._draw(held)
            await asyncio.sleep(0)
            drawn += len(few)
        self._left_out = in_turn[drawn:]
        twice = len(set(waiting).intersection(self._left_out))
        return twice * (time.monotonic() - began) / max(drawn, 1)

    async def _draw(self, held: Mapping[Ticked, ExitStack]) -> None:
        """Kind by kind: code that has just run for one page is still near at hand for the next. What comes in is read
        meanwhile; a page's drawings are sent together, with the last one."""
        drawings: dict[Hashable, list[tuple[Ticked, Callable[[], None]]]] = {}
        left: dict[Ticked, int] = {}  # drawings of a page
        for page in held:
            for kind, draw in self._let(page, page.drawings) or ():
                drawings.setdefault(kind, []).append((page, draw))
                left[page] = left.get(page, 0) + 1
            if page not in left:
                held[page].close()
        for alike in drawings.values():
            for page, draw in alike:
                self._let(page, draw)
                left[page] -= 1
                if not left[page]:
                    held[page].close()
                await self._give_way()

    async def _give_way(self) -> None:
        """To all else that the loop has to do, now and then."""
        if time.monotonic() - self._gave_way >= AT_ONCE:
            await asyncio.sleep(0)
            self._gave_way = time.monotonic()

    def _let(self, page: Ticked, do: Callable[[], T]) -> T | None:
        """What it does for a page; None if that has just been removed, or if it fails."""
        with self._turn:
            if page not in self._pages:
                return None
            try:
                return do()
            except Exception as error:  # one session's fault must not stop the others; its own page says so
                self._log(error)
                self._tell(page, error)
                return None

    def _log(self, error: Exception, anyway: bool = False) -> None:
        """In a line, unless one has just been written. anyway: it is the last that is heard of its page."""
        now = time.monotonic()
        if not anyway and now - self._logged_at < FAULTS_EVERY:
            self._unlogged += 1
            return
        more = f", and {self._unlogged} more since the line before" if self._unlogged else ""
        self._logged_at, self._unlogged = now, 0
        frames = traceback.extract_tb(error.__traceback__)[-FRAMES:]
        places = " < ".join(f"{Path(frame.filename).name}:{frame.lineno}" for frame in reversed(frames))
        log.error("a session met an error, %r at %s%s", error, places, more)

    async def _run(self) -> None:
        next_tick = time.monotonic()
        while self._running:
            self._heartbeat()
            with self._lock:
                pages = list(self._pages)
            self.shedding.ticked(await self.round(pages, next_tick + TICK))
            # one long tick is made up for by the next short one; further behind, ticks are skipped, not chased
            next_tick = max(next_tick + TICK, time.monotonic() - TICK)
            await asyncio.sleep(max(next_tick - time.monotonic(), 0))


@contextlib.contextmanager
def _holding(pages: Iterable[Ticked]) -> Iterator[dict[Ticked, ExitStack]]:
    """Nothing of a page is sent before its stack is closed, as all are in the end."""
    with ExitStack() as all_held:
        held = {page: all_held.enter_context(ExitStack()) for page in pages}
        for page, sent in held.items():
            sent.enter_context(page.held())
        yield held


def _parts(pages: Sequence[Ticked], size: int) -> Iterator[Sequence[Ticked]]:
    return (pages[first : first + size] for first in range(0, len(pages), size))
