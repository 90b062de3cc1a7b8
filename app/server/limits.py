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

_escaped = codecs.lookup("unicode_escape").encode  # now: without a file to open, none is found later
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
        """text: of any origin; it stays on one line."""
        if not self._bucket.take():
            self._left_out += 1
            return
        more = f" ({self._left_out} more before it were not logged)" if self._left_out else ""
        self._left_out = 0
        self._logger.warning("%s%s", _escaped(text)[0].decode()[:300], more)


# What goes wrong in a server's own machinery, told in a line: whoever can bring it about could fill a log.

FRAMES = 3  # innermost
OF_CLIENTS = "opening handshake failed"  # says websockets of who connects and asks for nothing, or for what is refused


def in_a_line(message: str, error: BaseException | None) -> str:
    """With where it was raised."""
    if error is None:
        return message
    walked = traceback.walk_tb(error.__traceback__)
    frames = traceback.StackSummary.extract(walked, lookup_lines=False)[-FRAMES:]  # opens no file
    places = " < ".join(f"{Path(frame.filename).name}:{frame.lineno}" for frame in reversed(frames))
    return f"{message}: {error!r} at {places}"


class FaultLines(logging.Handler):
    """warn(text): writes it, if it may."""

    def __init__(self, warn: Callable[[str], None]):
        super().__init__(logging.WARNING)
        self._warn = warn

    def emit(self, record: logging.LogRecord) -> None:
        if record.getMessage() != OF_CLIENTS:
            self._warn(in_a_line(record.getMessage(), record.exc_info[1] if record.exc_info else None))


def logger_of(warn: Callable[[str], None]) -> logging.Logger:
    """For websockets."""
    made = logging.Logger("viewimit.websockets", logging.WARNING)
    made.addHandler(FaultLines(warn))
    return made


# Who a client is for limits: one machine, or the network that one household or school has.

UNKNOWN = 1  # what is gone already


def network_of(peer: tuple | None) -> int:
    """Of a socket's peer → 64 bits, not 0. An IPv6 network has 2^64 addresses, any of which one machine may take: its
    first half counts, but of link-local addresses, which all begin alike, the second."""
    if not peer:
        return UNKNOWN
    address = ipaddress.ip_address(peer[0])
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        address = address.ipv4_mapped
    if isinstance(address, ipaddress.IPv4Address):
        return 0xFFFF << 32 | int(address)
    first, second = divmod(int(address), 1 << 64)
    return (second if address.is_link_local else first) or UNKNOWN


# Connections that have no seat yet: so many, so many of one address, and the oldest goes when there are more.
# A request comes within moments of its connection; who has waited longest is likeliest to send none.


class PendingConnections:
    """most: at a time; most_of_one: from one address, as `network_of` has it."""

    def __init__(self, most: int, most_of_one: int):
        self._most, self._most_of_one = most, most_of_one
        self._waiting: dict[Hashable, tuple[int, Callable[[], None]]] = {}  # oldest first

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, connection: Hashable, address: int, end: Callable[[], None]) -> None:
        """end(): closes it; called if it has to make room."""
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


# How long a client has taken nothing of what waits for it.


class Unsent:
    """Of one connection; sizes are those of its write buffer, bytes."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._waiting, self._taken = 0, clock()

    def written(self, before: int, after: int) -> None:
        """Something was put behind what waited."""
        self._look(before)
        self._waiting = after

    def stalled(self, waiting: int) -> float:
        """s for which nothing was taken, 0 while nothing waits."""
        self._look(waiting)
        return self._clock() - self._taken

    def _look(self, waiting: int) -> None:
        if waiting < self._waiting or waiting == 0:
            self._taken = self._clock()
        self._waiting = waiting


# How many connections a process takes, of whom, and how long each may take for what it does.


@dataclass(frozen=True)
class Limits:
    """seats: tabs of all processes together; seats_of_one: of those, from one address; pending: connections of this
    process that are no seats yet, such as page loads; pending_of_one: of those, from one address.

    Times in s. head_within: from the connection to the end of its request's head; page_within: from a handshake to the
    first view; stalled_within: in which a client takes something of what waits for it; written_within: in which a ping
    is on its way behind what waits; closed_within: in which a client that is closed says goodbye.
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


# What a server is started with, as each of its processes gets it.

PENDING = 200  # connections of a process without a seat, such as page loads
PAGE_CONNECTIONS = 12  # that a browser or two open at once


@dataclass(frozen=True)
class ServerOptions:
    """settings: what each session begins with; max_clients: tabs at a time; origins: of pages elsewhere that may
    connect; workers: processes that share the visitors; max_per_address: tabs of one address at a time, None: as many
    as there are; lessons: of a lecturer's own, by name, before those that are shipped; host: on which it listens."""

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
        """Of each process. Of connections without a seat one address has the same share as of seats, and a page's own
        few."""
        pending_of_one = min(PENDING, max(PAGE_CONNECTIONS, PENDING * self.seats_of_one // self.max_clients))
        return Limits(self.max_clients, self.seats_of_one, PENDING, pending_of_one)
