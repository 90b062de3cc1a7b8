"""Connections are accepted here and handed to the worker that has fewest.

Only the head of a request is waited for, and left for the worker to read: nothing passes through here afterwards.
"""

import asyncio
import contextlib
import logging
import socket
import threading
from collections.abc import Iterator, Sequence
from functools import partial
from http import HTTPStatus

from .limits.client_address import network_of
from .limits.pending_connections import PendingConnections
from .options import ServerOptions
from .rate_limits import LINES_A_SECOND, LINES_AT_ONCE, QuietLog, TokenBucket
from .request_head import MOST_HEAD, is_whole
from .responses import plain_response
from .seat_counts import SeatCounts

HEAD_WITHIN = 10.0  # s
LOOK_AGAIN, LOOK_AT_LEAST = 0.02, 0.5  # s: at once, and where no more comes
UNPLACED = 200  # connections at a time whose head has not come
log = logging.getLogger(__name__)


@contextlib.contextmanager
def dispatching(placing: "Placing", listeners: Sequence[socket.socket], to: Sequence[socket.socket]) -> Iterator[None]:
    """Inside, a thread hands over what comes to the listeners."""
    loop, stop, begun = asyncio.new_event_loop(), asyncio.Event(), threading.Event()

    async def dispatch() -> None:
        dispatcher = Dispatcher(placing, to)
        accepting = [loop.create_task(dispatcher.accept(listener)) for listener in listeners]
        begun.set()
        await stop.wait()
        for task in accepting:
            task.cancel()

    def run() -> None:
        with contextlib.closing(loop):
            loop.run_until_complete(dispatch())

    thread = threading.Thread(target=run, name="viewimit-dispatcher", daemon=True)
    thread.start()
    begun.wait()
    try:
        yield
    finally:
        loop.call_soon_threadsafe(stop.set)
        thread.join()


class Placing:
    """Which worker a connection goes to."""

    def __init__(self, options: ServerOptions, counts: SeatCounts):
        self.options, self._counts = options, counts
        self.handed = [0] * options.workers

    def place(self) -> int:
        """The one with fewest connections that has a seat."""
        rows = self._counts.rows  # one that is only beginning would let who is new wait
        open_at = [handed - row.ended for handed, row in zip(self.handed, rows)]
        return min(range(len(open_at)), key=lambda k: (self._is_full(k), not rows[k].began, open_at[k]))

    def _is_full(self, worker: int) -> bool:
        return self._counts.rows[worker].seats >= self.options.clients_of(worker)


class Dispatcher:
    """to: a Unix socket to each worker, which takes the file descriptors of connections."""

    def __init__(self, placing: Placing, to: Sequence[socket.socket]):
        self._placing, self._to = placing, to
        self._unplaced = PendingConnections(UNPLACED, placing.options.share_of_one(UNPLACED))
        self._log = QuietLog(log, TokenBucket(LINES_A_SECOND, LINES_AT_ONCE))
        for other in to:
            other.setblocking(False)

    async def accept(self, listener: socket.socket) -> None:
        """For ever."""
        loop = asyncio.get_running_loop()
        listener.setblocking(False)
        while True:
            try:
                connection, peer = await loop.sock_accept(listener)
            except OSError:  # too many files are open, or it was gone at once
                await asyncio.sleep(LOOK_AGAIN)
                continue
            task = loop.create_task(self._place(connection))
            task.add_done_callback(partial(self._placed, connection))
            self._unplaced.add(task, network_of(peer), partial(_cancel, task))

    def _placed(self, connection: socket.socket, task: asyncio.Task) -> None:
        self._unplaced.discard(task)
        connection.close()  # of a task that was cancelled before it began

    async def _place(self, connection: socket.socket) -> None:
        with connection:  # the worker gets a descriptor of its own
            try:
                head = await asyncio.wait_for(_head(connection), HEAD_WITHIN)
            except asyncio.TimeoutError:
                _refuse_late(connection)
                return
            except OSError:
                return
            if head:
                self._hand(connection, self._placing.place())

    def _hand(self, connection: socket.socket, worker: int) -> None:
        try:
            socket.send_fds(self._to[worker], [b"c"], [connection.fileno()])
        except OSError as error:  # the worker takes none: who comes is closed, and tries again
            self._log.warn(f"a connection could not be handed over: {error}")
            return
        self._placing.handed[worker] += 1


def _refuse_late(connection: socket.socket) -> None:
    """Who has begun a request and not said all of its head is told so; who has said nothing is left as it is."""
    with contextlib.suppress(OSError):
        if connection.recv(MOST_HEAD):  # read, or what is unread would undo the answer
            said = f"a head that was not whole after {HEAD_WITHIN:g} s\n"
            connection.send(plain_response(HTTPStatus.REQUEST_TIMEOUT, said).serialize())
            connection.shutdown(socket.SHUT_WR)


def _cancel(task: asyncio.Task) -> None:
    task.cancel()


async def _head(connection: socket.socket) -> bytes:
    """What a client has sent, once that is all of a request's head, or all that it will send. It stays unread."""
    looked_at, pause = 0, LOOK_AGAIN
    while True:
        await _readable(connection)
        head = connection.recv(MOST_HEAD, socket.MSG_PEEK)
        if not head or len(head) == MOST_HEAD or (len(head) > looked_at and is_whole(head)):
            return head
        pause = LOOK_AGAIN if len(head) > looked_at else min(2 * pause, LOOK_AT_LEAST)
        looked_at = len(head)
        await asyncio.sleep(pause)  # it is readable already, so that nothing tells when more has come


async def _readable(connection: socket.socket) -> None:
    loop = asyncio.get_running_loop()
    ready = loop.create_future()

    def tell() -> None:
        if not ready.done():
            ready.set_result(None)

    loop.add_reader(connection, tell)
    try:
        await ready
    finally:
        loop.remove_reader(connection)
