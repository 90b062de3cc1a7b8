"""How many connections there may be, whose they are, and how much each may send."""

import ipaddress
import time
import traceback
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from viewimit.loop.settings import Settings

from ..lab.lessons.format import Lesson


class TokenBucket:
    """`rate` a second on average, up to `burst` at once."""

    def __init__(self, rate: float, burst: float):
        self._rate, self._burst = rate, burst
        self._tokens, self._last = burst, time.monotonic()

    def take(self) -> bool:
        """Take one, if there is one."""
        now = time.monotonic()
        self._tokens = min(self._burst, self._tokens + (now - self._last) * self._rate)
        self._last = now
        if self._tokens < 1:
            return False
        self._tokens -= 1
        return True


FRAMES = 3  # of a traceback, innermost


def in_a_line(message: str, error: BaseException | None) -> str:
    """Return a fault as one line, with where it was raised: clients could fill a log with tracebacks."""
    if error is None:
        return message
    walked = traceback.walk_tb(error.__traceback__)
    frames = traceback.StackSummary.extract(walked, lookup_lines=False)[-FRAMES:]  # opens no file
    places = " < ".join(f"{Path(frame.filename).name}:{frame.lineno}" for frame in reversed(frames))
    return f"{message}: {error!r} at {places}"


UNKNOWN = 1  # the address of a client that is gone already, or is none


def network_of(peer: tuple | None) -> int:
    """Return the address that limits count by, of a socket's peer: 64 bits, not 0. A machine may take any of 2^64 of
    an IPv6 network: so the first half counts; of link-local addresses, which begin alike, the second."""
    try:
        address = ipaddress.ip_address(peer[0] if peer else "")
    except ValueError:  # as proxies may name a client
        return UNKNOWN
    if isinstance(address, ipaddress.IPv6Address) and address.ipv4_mapped is not None:
        address = address.ipv4_mapped
    if isinstance(address, ipaddress.IPv4Address):
        return 0xFFFF << 32 | int(address)
    first, second = divmod(int(address), 1 << 64)
    return (second if address.is_link_local else first) or UNKNOWN


class PendingConnections:
    """Connections that have no seat yet. Of too many the oldest is closed: it is likeliest to send nothing. most: at a
    time; most_of_one: from one address, as `network_of` returns it."""

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


PENDING = 200  # connections without a seat, such as page loads
PAGE_CONNECTIONS = 12  # that a browser or two open at once


@dataclass(frozen=True)
class Limits:
    """The limits of a server. seats: tabs at a time; seats_of_one: of those, from one address. Times in s. head_within:
    from the connection to its answer; page_within: from a handshake to the first view; pong_within: for a ping to be
    sent and answered; closed_within: for a closing handshake."""

    seats: int = 40
    seats_of_one: int = 36
    head_within: float = 10.0
    page_within: float = 30.0
    ping_every: float = 15.0
    pong_within: float = 15.0
    closed_within: float = 2.0

    @property
    def pending_of_one(self) -> int:
        """How many of the pending connections one address has: the same share as of seats, and at least one page's."""
        return min(PENDING, max(PAGE_CONNECTIONS, PENDING * self.seats_of_one // self.seats))


@dataclass(frozen=True)
class ServerOptions:
    """The options of a server. settings: of each new session; origins: of pages elsewhere that may connect; lessons: of
    a lecturer's own, by name, before those that are shipped; host: on which it listens."""

    settings: Settings = Settings.paper()
    limits: Limits = Limits()
    origins: tuple[str, ...] = ()
    lessons: Mapping[str, Lesson] = field(default_factory=dict)
    host: str = "127.0.0.1"
