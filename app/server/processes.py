"""Several processes share one port: Python computes on one core a process, and a class needs two.

They inherit the listening socket, so that all wait in one queue: what comes while a process hangs or is replaced is
answered by another. (Sockets that each bind the port, by SO_REUSEPORT, would have a queue each.)
"""

import asyncio
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
from queue import Empty, SimpleQueue

from ..jobs.child import stand_back
from .limits import ServerOptions
from .seats import ProcessRow, Seats

LOG_FORMAT = "%(asctime)s %(message)s"
SIGN_EVERY = 1.0  # s, while a process begins
SILENT_FOR = 20.0  # s that a process has for each sign of life
SAID_EVERY = 30.0  # s, while processes are still beginning
LOOK_EVERY = 0.25  # s
ENDS_WITHIN = 7.0  # s that processes are given to end
SIGNALS_WITHIN = 1.0  # s, in which a signal to all processes reaches each
MOST_ENDS, OF_LATE = 5, 60.0  # of processes, s: more are no accident
DECLINES_FOR = 0.01  # s until a process that has more seats than another looks at the queue again
NO_FILES_FOR = 1.0  # s until a process that has too many files open does
log = logging.getLogger(__name__)


class Termination:
    """As `threading.Event`, but safe to set in a signal handler: the handler may interrupt a method of the same object,
    and `threading.Event` would then wait for its own lock for ever."""

    def __init__(self):
        self._is_set = False
        self._queue: SimpleQueue[None] = SimpleQueue()  # put is reentrant

    def set(self) -> None:
        self._is_set = True
        self._queue.put(None)

    def is_set(self) -> bool:
        return self._is_set

    def wait(self, seconds: float) -> bool:
        """Whether it is set, after that time at most."""
        with contextlib.suppress(Empty):
            self._queue.put(self._queue.get(timeout=seconds))  # for other threads that wait
        return self._is_set


class FairListener(socket.socket):
    """Stands for a listening socket in asyncio, and accepts from sockets that several processes have inherited.

    A process takes one connection at a time, and none while another that is awake has fewer seats. Without that, one
    process would take most of a class that comes at once.

    Parameters
    ----------
    inherited : the listening sockets, such as one for IPv4 and one for IPv6
    seats : of all processes
    process : number of this one
    """

    def __init__(self, inherited: Sequence[socket.socket], seats: Seats, process: int):
        waits, self._tells = socket.socketpair()
        super().__init__(waits.family, waits.type, fileno=waits.detach())
        self._inherited, self._seats, self._own = inherited, seats, seats.rows[process]
        self._accepted: deque[tuple[socket.socket, tuple]] = deque()

    def getsockname(self) -> tuple:
        return self._inherited[0].getsockname()

    def listen(self, *_) -> None:
        """Begin to accept, in the running loop."""
        for listener in self._inherited:
            listener.setblocking(False)
        self._look()

    def accept(self) -> tuple[socket.socket, tuple]:
        """Return an accepted connection. Raises BlockingIOError without one."""
        self.recv(1)
        return self._accepted.popleft()

    def close(self) -> None:
        loop = asyncio.get_running_loop()
        for listener in self._inherited:
            loop.remove_reader(listener)
            listener.close()
        self._tells.close()
        super().close()

    def _look(self) -> None:
        loop = asyncio.get_running_loop()
        for listener in self._inherited:
            if listener.fileno() >= 0:  # else it was closed meanwhile
                loop.add_reader(listener, self._take, listener)

    def _take(self, listener: socket.socket) -> None:
        if self._seats.fewest_awake() < self._own.seats:
            self._look_away(DECLINES_FOR)
            return
        try:
            self._accepted.append(listener.accept())
        except (BlockingIOError, ConnectionAbortedError):  # another process was faster, or the client is gone
            return
        except OSError as error:  # else the loop would be woken for it again and again
            context = {"message": "a connection could not be accepted", "exception": error}
            asyncio.get_running_loop().call_exception_handler(context)
            self._look_away(NO_FILES_FOR)
            return
        self._tells.send(b"c")

    def _look_away(self, seconds: float) -> None:
        """A socket on which connections wait would wake its loop at once again."""
        loop = asyncio.get_running_loop()
        for listener in self._inherited:
            loop.remove_reader(listener)
        loop.call_later(seconds, self._look)


def serve_as_process(listeners: Sequence[socket.socket], seats: Seats, process: int, options: ServerOptions) -> None:
    """Serve what comes to the listeners until SIGTERM, or until the supervisor is gone."""
    stand_back(0)
    stopped, supervisor = Termination(), multiprocessing.parent_process()
    signal.signal(signal.SIGTERM, lambda *_: stopped.set())
    logging.basicConfig(format=LOG_FORMAT)
    with contextlib.ExitStack() as stack:
        with _giving_signs(seats.rows[process]):
            from .pages import serving  # numpy is loaded here

            stack.enter_context(serving(options, seats, process, FairListener(listeners, seats, process)))
        while not stopped.wait(0.5):  # a signal that the system hands to another thread is seen at the next turn
            if supervisor is not None and not supervisor.is_alive():
                return


@contextlib.contextmanager
def _giving_signs(row: ProcessRow) -> Iterator[None]:
    """Give signs of life inside, where no scheduler does yet."""
    ended = threading.Event()

    def give_signs() -> None:
        while not ended.is_set():
            row.begins = time.monotonic()
            ended.wait(SIGN_EVERY)

    threading.Thread(target=give_signs, name="viewimit-beginning", daemon=True).start()
    try:
        yield
    finally:
        ended.set()


@contextlib.contextmanager
def supervised(options: ServerOptions, listeners: Sequence[socket.socket], stopped: Termination) -> Iterator[None]:
    """Inside, processes serve what comes to the listeners.

    stopped: no more processes are begun; it is set here when they end again and again. Raises RuntimeError, then in the
    end, if processes end again and again.
    """
    supervisor = Supervisor(options, listeners, stopped)
    try:
        supervisor.wait_until_ready()
        yield
        supervisor.require_hope()
    finally:
        supervisor.stop()


class Supervisor:
    """Begins the processes, and replaces one that ends or gives no sign of life."""

    def __init__(self, options: ServerOptions, listeners: Sequence[socket.socket], stopped: Termination):
        self._options, self._listeners, self._stopped = options, listeners, stopped
        self._seats = Seats(options.workers)
        self._ends: deque[float] = deque(maxlen=MOST_ENDS)
        self._hopeless = False
        self._signs = [Signs() for _ in range(options.workers)]
        self._processes = [self._begin(k) for k in range(options.workers)]
        self._thread = threading.Thread(target=self._supervise, name="viewimit-supervisor", daemon=True)
        self._thread.start()

    def wait_until_ready(self) -> None:
        """Return once all serve, however slow the machine is; one that gives no sign of life is begun again."""
        said = time.monotonic()
        while not all(row.began for row in self._seats.rows):
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
        """End all processes, and close the port."""
        self._stopped.set()
        self._thread.join()
        for listener in self._listeners:
            listener.close()
        for process in self._processes:
            process.terminate()
        until = time.monotonic() + ENDS_WITHIN
        for process in self._processes:
            process.join(max(until - time.monotonic(), 0.1))
            if process.is_alive():
                log.warning("a process of the server does not end; what its visitors did last may be lost")
                process.kill()
                process.join()

    def _begin(self, k: int) -> multiprocessing.process.BaseProcess:
        self._seats.rows[k].clear()
        self._signs[k] = Signs()
        process = multiprocessing.get_context("spawn").Process(
            target=serve_as_process, args=(self._listeners, self._seats, k, self._options), name=f"viewimit-worker-{k}"
        )
        process.start()
        return process

    def _supervise(self) -> None:
        while not self._stopped.is_set():
            sentinels = [process.sentinel for process in self._processes]
            ended = multiprocessing.connection.wait(sentinels, LOOK_EVERY)
            for k, sentinel in enumerate(sentinels):
                if sentinel in ended:
                    self._replace(k)
                else:
                    self._end_if_silent(k)

    def _end_if_silent(self, k: int) -> None:
        """Kill a process that gives no sign of life: it would not hear a signal to end."""
        row = self._seats.rows[k]
        sign = row.seen or row.begins
        if sign and self._signs[k].silent_for(sign) > SILENT_FOR:  # how long Python takes to begin, nobody knows
            log.warning("a process of the server has given no sign of life for %g s: it is ended", SILENT_FOR)
            self._processes[k].kill()
            self._signs[k] = Signs()

    def _replace(self, k: int) -> None:
        """Begin a process again that has ended by itself; its visitors' pages come back by themselves."""
        process = self._processes[k]
        process.join()
        terminated = process.exitcode in (0, -signal.SIGTERM)  # a signal to all processes may reach this one next
        if self._stopped.wait(SIGNALS_WITHIN if terminated else 0):
            return
        now = time.monotonic()
        if len(self._ends) == MOST_ENDS and now - self._ends[0] < OF_LATE:
            self._hopeless = True
            self._stopped.set()
            return
        self._ends.append(now)
        log.warning("a process of the server has ended (%s); another takes its place", process.exitcode)
        self._processes[k] = self._begin(k)


class Signs:
    """How long a process has given no sign of life, of the time in which this one was awake itself."""

    def __init__(self):
        self._seen, self._looked, self._silent = 0.0, time.monotonic(), 0.0

    def silent_for(self, seen: float) -> float:
        """Return it in s. seen: when the last sign came; 0 before the first."""
        now = time.monotonic()
        self._silent = self._silent + min(now - self._looked, 2 * LOOK_EVERY) if seen == self._seen else 0.0
        self._seen, self._looked = seen, now
        return self._silent
