"""Several processes behind one port: Python computes on one core a process, and a class needs two."""

import contextlib
import logging
import multiprocessing
import multiprocessing.connection
import signal
import socket
import threading
import time
from collections import deque
from collections.abc import Iterator, Sequence

from .dispatcher import Placing, dispatching
from .options import ServerOptions
from .seat_counts import SeatCounts
from .termination import Termination
from .worker import work

SILENT_FOR = 20.0  # s that a worker has for each sign of life
SAID_EVERY = 30.0  # s, while processes are still beginning
LOOK_EVERY = 0.25  # s
ENDED_WITHIN = 7.0  # s that workers are given to end
TOLD_TOO = 1.0  # s between signals to a worker and to this process that were sent as one
MOST_ENDS, ENDS_WITHIN = 5, 60.0  # of workers, s: more are no accident
log = logging.getLogger(__name__)


@contextlib.contextmanager
def working(options: ServerOptions, listeners: Sequence[socket.socket], stopped: Termination) -> Iterator[None]:
    """Inside, workers serve what comes to the listeners; in the end they have ended.

    stopped: no process is begun any more; set here when it is of no use to go on. Raises RuntimeError, then in the
    end, if workers end again and again.
    """
    workers = Workers(options, listeners, stopped)
    try:
        workers.wait_until_ready()
        yield
        workers.require_hope()
    finally:
        workers.stop()


class Workers:
    """Processes that share the visitors, in the order of the rows of the counts; one that ends, or gives no sign of
    life, is replaced.

    The sockets through which connections are handed over outlive them: who comes meanwhile waits for the next one.
    """

    def __init__(self, options: ServerOptions, listeners: Sequence[socket.socket], stopped: Termination):
        self._options, self._listeners, self._stopped = options, listeners, stopped
        self._port = listeners[0].getsockname()[1]
        self._counts = SeatCounts(options.workers)
        self._placing = Placing(options, self._counts)
        self._pairs = [socket.socketpair() for _ in range(options.workers)]
        self._ends: deque[float] = deque(maxlen=MOST_ENDS)
        self._hopeless = False
        self._signs = [Signs() for _ in range(options.workers)]
        self._processes = [self._begin(k) for k in range(options.workers)]
        self._dispatching = contextlib.ExitStack()
        self._dispatching.enter_context(dispatching(self._placing, listeners, [ours for ours, _ in self._pairs]))
        self._thread = threading.Thread(target=self._supervise, name="viewimit-supervisor", daemon=True)
        self._thread.start()

    def wait_until_ready(self) -> None:
        """Return once all serve, however slow the machine is; one that gives no sign of life is begun again."""
        said = time.monotonic()
        while not all(row.began for row in self._counts.rows):
            self.require_hope()
            if self._stopped.wait(0.02):
                return
            if time.monotonic() - said > SAID_EVERY:
                said = time.monotonic()
                log.warning("the server's processes are still beginning: this machine is slow, or busy")

    def require_hope(self) -> None:
        if self._hopeless:
            raise RuntimeError("the server's processes end again and again; what they said stands above")

    def stop(self) -> None:
        """Each ends."""
        self._stopped.set()
        self._dispatching.close()
        self._thread.join()
        for process in self._processes:
            process.terminate()
        until = time.monotonic() + ENDED_WITHIN
        for process in self._processes:
            process.join(max(until - time.monotonic(), 0.1))
            if process.is_alive():
                log.warning("a process of the server does not end by itself, and is killed")
                process.kill()
                process.join()
        for one in (*self._listeners, *(end for pair in self._pairs for end in pair)):
            one.close()

    def _begin(self, worker: int) -> multiprocessing.process.BaseProcess:
        row = self._counts.rows[worker]
        row.clear()
        self._signs[worker] = Signs()
        self._placing.handed[worker] = 0
        process = multiprocessing.get_context("spawn").Process(
            target=work,
            args=(self._pairs[worker][1], self._port, self._counts, worker, self._options),
            name=f"viewimit-worker-{worker}",
        )
        process.start()
        return process

    def _supervise(self) -> None:
        while not self._stopped.is_set():
            sentinels = [process.sentinel for process in self._processes]
            ended = multiprocessing.connection.wait(sentinels, LOOK_EVERY)
            for worker, sentinel in enumerate(sentinels):
                if sentinel in ended:
                    self._replace(worker)
                else:
                    self._end_if_silent(worker)

    def _end_if_silent(self, worker: int) -> None:
        """It can be asked nothing any more: neither to keep its sessions nor to end."""
        row = self._counts.rows[worker]
        sign = row.seen or row.begins
        if sign and self._signs[worker].silent_for(sign) > SILENT_FOR:  # how long Python takes to begin, nobody knows
            log.warning("a process of the server has given no sign of life for %g s: it is ended", SILENT_FOR)
            self._processes[worker].kill()
            self._signs[worker] = Signs()

    def _replace(self, worker: int) -> None:
        """Begin a process again that has ended by itself; its visitors' pages come back by themselves."""
        process = self._processes[worker]
        process.join()
        told = process.exitcode in (0, -signal.SIGTERM)  # perhaps with this one, by whoever stops all
        if self._stopped.wait(TOLD_TOO if told else 0):
            return
        now = time.monotonic()
        if len(self._ends) == MOST_ENDS and now - self._ends[0] < ENDS_WITHIN:
            self._hopeless = True
            self._stopped.set()
            return
        self._ends.append(now)
        log.warning("a process of the server has ended (%s); another takes its place", process.exitcode)
        self._processes[worker] = self._begin(worker)


class Signs:
    """How long a process has given none, of the time in which this one was awake itself."""

    def __init__(self):
        self._seen, self._looked, self._silent = 0.0, time.monotonic(), 0.0

    def silent_for(self, seen: float) -> float:
        """s. seen: when the last sign came; 0 before the first."""
        now = time.monotonic()
        self._silent = self._silent + min(now - self._looked, 2 * LOOK_EVERY) if seen == self._seen else 0.0
        self._seen, self._looked = seen, now
        return self._silent
