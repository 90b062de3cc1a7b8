"""Connections are accepted here and handed to one of several workers: always to the same one for a browser.

Only the head of a request is looked at, and left for the worker to read: nothing passes through here afterwards.

Workers that accept from one inherited socket, each while no other has fewer seats, take 100 lines less, as much
processor time, and spread a class as evenly; but none knows whose a connection is before it has accepted it. A tab that
comes again a second after its network fell silent is then at a worker that cannot ask whether its old connection still
answers: of 21 none had its session, here all within 4 s; and of 30 tabs whose first worker was killed the other one
kept 20, here 15 (`tests/server/measure_balance.py`).
"""

import asyncio
import contextlib
import io
import logging
import socket
import threading
from collections import OrderedDict
from collections.abc import Iterator, Sequence
from functools import partial
from http import HTTPStatus
from http.client import HTTPException, parse_headers

from .cookie import token_of
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
KNOWN = 10_000  # browsers
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
    """Which worker a browser's connections go to."""

    def __init__(self, options: ServerOptions, counts: SeatCounts):
        self.options, self._counts = options, counts
        self._of: OrderedDict[str, int] = OrderedDict()
        self.handed = [0] * options.workers

    def place(self, token: str | None) -> int:
        """The browser's own worker while it has a seat, else the one with fewest connections. token: None if new."""
        worker = None if token is None else self._of.get(token)
        if worker is None or self._is_full(worker):
            open_at = [handed - row.ended for handed, row in zip(self.handed, self._counts.rows)]
            rows = self._counts.rows  # one that is only beginning would let who is new wait
            worker = min(range(len(open_at)), key=lambda k: (self._is_full(k), not rows[k].began, open_at[k]))
        if token is not None:
            self._of[token] = worker
            self._of.move_to_end(token)
            if len(self._of) > KNOWN:
                self._of.popitem(last=False)
        return worker

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
                self._hand(connection, self.worker_for(head))

    def worker_for(self, head: bytes) -> int:
        """Where its browser goes."""
        return self._placing.place(_token(head))

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


def _token(head: bytes) -> str | None:
    """The browser's token in the head of a request, None without a good one."""
    try:
        return token_of(parse_headers(io.BytesIO(head.partition(b"\r\n")[2])))
    except HTTPException:
        return None
