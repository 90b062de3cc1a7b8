"""How many connections there may be, whose they are, how much each may send, and how little of it a log says."""

import codecs
import ipaddress
import logging
import time
import traceback
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from viewimit.loop.settings import Settings

from ..lab.lessons.format import Lesson

_escaped = codecs.lookup("unicode_escape").encode  # now: it could not be found later, without a file to open
LINES_A_SECOND, LINES_AT_ONCE = 2.0, 30.0  # of refusals in a log


class TokenBucket:
    """`rate` a second on average, up to `burst` at once."""

    def __init__(self, rate: float, burst: float, clock: Callable[[], float] = time.monotonic):
        self._rate, self._burst, self._clock = rate, burst, clock
        self._tokens, self._last = burst, clock()

    def take(self) -> bool:
        """Take one, if there is one."""
        now = self._clock()
        self._tokens = min(self._burst, self._tokens + (now - self._last) * self._rate)
        self._last = now
        if self._tokens < 1:
            return False
        self._tokens -= 1
        return True


class QuietLog:
    """One line a warning; too many are counted instead, and the count goes with the next line."""

    def __init__(self, logger: logging.Logger, bucket: TokenBucket):
        self._logger, self._bucket, self._left_out = logger, bucket, 0

    def warn(self, text: str) -> None:
        """Write a text of any origin as one line."""
        if not self._bucket.take():
            self._left_out += 1
            return
        more = f" ({self._left_out} more before it were not logged)" if self._left_out else ""
        self._left_out = 0
        self._logger.warning("%s%s", _escaped(text)[0].decode()[:300], more)


FRAMES = 3  # of a traceback, innermost
OF_CLIENTS = "opening handshake failed"  # websockets logs it of clients that ask for nothing, or are refused


def in_a_line(message: str, error: BaseException | None) -> str:
    """Return a fault as one line, with where it was raised: clients could fill a log with tracebacks."""
    if error is None:
        return message
    walked = traceback.walk_tb(error.__traceback__)
    frames = traceback.StackSummary.extract(walked, lookup_lines=False)[-FRAMES:]  # opens no file
    places = " < ".join(f"{Path(frame.filename).name}:{frame.lineno}" for frame in reversed(frames))
    return f"{message}: {error!r} at {places}"


class FaultLines(logging.Handler):
    """Passes faults on as lines. warn(text): writes one, within its own limits."""

    def __init__(self, warn: Callable[[str], None]):
        super().__init__(logging.WARNING)
        self._warn = warn

    def emit(self, record: logging.LogRecord) -> None:
        if record.getMessage() != OF_CLIENTS:
            self._warn(in_a_line(record.getMessage(), record.exc_info[1] if record.exc_info else None))


def logger_of(warn: Callable[[str], None]) -> logging.Logger:
    """Return a logger for websockets."""
    made = logging.Logger("viewimit.websockets", logging.WARNING)
    made.addHandler(FaultLines(warn))
    return made


UNKNOWN = 1  # the address of a client that is gone already


def network_of(peer: tuple | None) -> int:
    """Return the address that limits count by, of a socket's peer: 64 bits, not 0.

    A machine may take any of the 2^64 addresses of an IPv6 network. So the first half counts; of link-local addresses,
    which all begin alike, the second.
    """
    if not peer:
        return UNKNOWN
    address = ipaddress.ip_address(peer[0])
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        address = address.ipv4_mapped
    if isinstance(address, ipaddress.IPv4Address):
        return 0xFFFF << 32 | int(address)
    first, second = divmod(int(address), 1 << 64)
    return (second if address.is_link_local else first) or UNKNOWN


class PendingConnections:
    """Connections that have no seat yet. Of too many the oldest is closed: it is likeliest to send nothing.

    most: at a time; most_of_one: from one address, as `network_of` returns it.
    """

    def __init__(self, most: int, most_of_one: int):
        self._most, self._most_of_one = most, most_of_one
        self._waiting: dict[Hashable, tuple[int, Callable[[], None]]] = {}  # oldest first

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, connection: Hashable, address: int, end: Callable[[], None]) -> None:
        """Add one. end(): closes it, when it has to make room."""
        same = [other for other, (its, _) in self._waiting.items() if its == address]
        if len(same) >= self._most_of_one:
            self._end(same[0])
        elif len(self._waiting) >= self._most:
            self._end(next(iter(self._waiting)))
        self._waiting[connection] = address, end

    def discard(self, connection: Hashable) -> None:
        """It has a seat, or it has ended."""
        self._waiting.pop(connection, None)

    def _end(self, connection: Hashable) -> None:
        _, end = self._waiting.pop(connection)
        end()


class Unsent:
    """How long a client has read nothing of what waits in its connection's write buffer; sizes in bytes."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._waiting, self._taken = 0, clock()

    def written(self, before: int, after: int) -> None:
        """Note that data was appended to the buffer."""
        self._look(before)
        self._waiting = after

    def stalled(self, waiting: int) -> float:
        """Return the s for which nothing was read, 0 while nothing waits."""
        self._look(waiting)
        return self._clock() - self._taken

    def _look(self, waiting: int) -> None:
        if waiting < self._waiting or waiting == 0:
            self._taken = self._clock()
        self._waiting = waiting


@dataclass(frozen=True)
class Limits:
    """The limits of each process.

    seats: tabs of all processes together; seats_of_one: of those, from one address; pending: connections of one process
    without a seat, such as page loads; pending_of_one: of those, from one address.

    Times in s. head_within: from the connection to the end of its request's head; page_within: from a handshake to the
    first view; stalled_within: for a client to read some of its data; written_within: for a ping to be sent;
    closed_within: for a closing handshake.
    """

    seats: int = 40
    seats_of_one: int = 36
    pending: int = 200
    pending_of_one: int = 180
    head_within: float = 9.0  # less than websockets waits, which then closes without a word
    page_within: float = 30.0
    stalled_within: float = 30.0
    ping_every: float = 15.0
    pong_within: float = 15.0
    written_within: float = 120.0
    closed_within: float = 2.0


PENDING = 200  # connections of a process without a seat, such as page loads
PAGE_CONNECTIONS = 12  # that a browser or two open at once


@dataclass(frozen=True)
class ServerOptions:
    """The options of a server, for each of its processes.

    settings: of each new session; max_clients: tabs at a time; origins: of pages elsewhere that may
    connect; workers: processes that share the visitors; max_per_address: tabs of one address at a time, None: as many
    as there are; lessons: of a lecturer's own, by name, before those that are shipped; host: on which it listens.
    """

    settings: Settings = Settings.paper()
    max_clients: int = 40
    origins: tuple[str, ...] = ()
    workers: int = 1
    max_per_address: int | None = None
    lessons: Mapping[str, Lesson] = field(default_factory=dict)
    host: str = "127.0.0.1"

    @property
    def seats_of_one(self) -> int:
        """How many of the tabs one address has at most."""
        return self.max_per_address or self.max_clients

    @property
    def limits(self) -> Limits:
        """Limits of each process. One address has the same share of pending connections as of seats, and at least one
        page's."""
        pending_of_one = min(PENDING, max(PAGE_CONNECTIONS, PENDING * self.seats_of_one // self.max_clients))
        return Limits(self.max_clients, self.seats_of_one, PENDING, pending_of_one)
