"""Several processes behind one port: Python computes on one core a process, and a class needs two."""

import asyncio
import contextlib
import logging
import multiprocessing
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence

from .dispatcher import Dispatcher, Placing
from .options import ServerOptions
from .seat_counts import SeatCounts
from .worker import work

READY_WITHIN = 60.0  # s
SAVED_WITHIN = 20.0  # s that a worker is given to keep its sessions
MOST_ENDS, ENDS_WITHIN = 5, 60.0  # of workers, s: more are no accident
log = logging.getLogger(__name__)


@contextlib.contextmanager
def working(options: ServerOptions, listeners: Sequence[socket.socket], failed: Callable[[], None]) -> Iterator[None]:
    """Inside, workers serve what comes to the listeners; in the end they have kept all sessions.

    failed(): it is of no use to go on. Raises RuntimeError, then in the end, if workers end again and again.
    """
    workers = Workers(options, listeners, failed)
    try:
        workers.wait_until_ready()
        yield
        workers.require_hope()
    finally:
        workers.stop()


class Workers:
    """Processes that share the visitors, in the order of the rows of the counts; one that ends is begun again.

    The sockets through which connections are handed over outlive them: who comes meanwhile waits for the next one.
    """

    def __init__(self, options: ServerOptions, listeners: Sequence[socket.socket], failed: Callable[[], None]):
        self._options, self._listeners, self._failed = options, listeners, failed
        self._port = listeners[0].getsockname()[1]
        self._counts = SeatCounts(options.workers)
        self._placing = Placing(options, self._counts)
        self._pairs = [socket.socketpair() for _ in range(options.workers)]
        self._ends: deque[float] = deque(maxlen=MOST_ENDS)
        self._stopping = self._hopeless = False
        self._processes = [self._begin(k) for k in range(options.workers)]
        self._dispatching, self._stop_dispatching = threading.Event(), asyncio.Event()
        run = lambda: asyncio.run(self._dispatch())
        self._thread = threading.Thread(target=run, name="viewimit-dispatcher", daemon=True)
        self._thread.start()
        self._dispatching.wait()

    def wait_until_ready(self) -> None:
        until = time.monotonic() + READY_WITHIN
        while not all(row.began for row in self._counts.rows):
            self.require_hope()
            if time.monotonic() > until:
                raise RuntimeError(f"the server's processes take more than {READY_WITHIN:g} s to begin")
            time.sleep(0.02)

    def require_hope(self) -> None:
        if self._hopeless:
            raise RuntimeError("the server's processes end again and again; what they said stands above")

    def stop(self) -> None:
        """Each keeps its sessions and ends."""
        self._stopping = True
        self._loop.call_soon_threadsafe(self._stop_dispatching.set)
        self._thread.join()
        for process in self._processes:
            process.terminate()
        until = time.monotonic() + SAVED_WITHIN
        for process in self._processes:
            process.join(max(until - time.monotonic(), 0.1))
            if process.is_alive():
                log.warning("a process of the server does not end; what its visitors did last may be lost")
                process.kill()
                process.join()
        for one in (*self._listeners, *(end for pair in self._pairs for end in pair)):
            one.close()

    def _begin(self, worker: int) -> multiprocessing.process.BaseProcess:
        row = self._counts.rows[worker]
        row.clear()
        self._placing.handed[worker] = 0
        process = multiprocessing.get_context("spawn").Process(
            target=work,
            args=(self._pairs[worker][1], self._port, self._counts, worker, self._options),
            name=f"viewimit-worker-{worker}",
        )
        process.start()
        return process

    async def _dispatch(self) -> None:
        self._loop = asyncio.get_running_loop()
        dispatcher = Dispatcher(self._placing, [ours for ours, _ in self._pairs])
        accepting = [self._loop.create_task(dispatcher.accept(listener)) for listener in self._listeners]
        for worker in range(len(self._processes)):
            self._watch(worker)
        self._dispatching.set()
        await self._stop_dispatching.wait()
        for task in accepting:
            task.cancel()

    def _watch(self, worker: int) -> None:
        self._loop.add_reader(self._processes[worker].sentinel, self._ended, worker)

    def _ended(self, worker: int) -> None:
        """Begin a process again that has ended by itself; its visitors' pages come back by themselves."""
        process = self._processes[worker]
        self._loop.remove_reader(process.sentinel)
        process.join()
        if self._stopping:
            return
        now = time.monotonic()
        if self._hopeless or (len(self._ends) == MOST_ENDS and now - self._ends[0] < ENDS_WITHIN):
            self._hopeless = True
            self._failed()
            return
        self._ends.append(now)
        log.warning("a process of the server has ended (%s); another takes its place", process.exitcode)
        self._processes[worker] = self._begin(worker)
        self._watch(worker)
