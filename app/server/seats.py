"""The seats of all processes of one server: a few numbers each, in memory that they share.

Each process writes its own row alone, so that nothing needs a lock. A server of one process has one row.
"""

import ctypes
import multiprocessing
import time

import numpy as np

WELL_FOR = 10.0  # s after a sign of life
AWAKE_FOR = 2.0  # s after a sign of life, in which a process is expected to accept connections
MOST_SEATS = 10_000  # of a process


class ProcessRow(ctypes.Structure):
    """Of one process. seats: its clients; seen: s, its last sign of life while it serves, 0 before the first; begins:
    s, the last one while it was beginning; addresses: of its clients, as `network_of` has them, 0 where there is
    none."""

    _fields_ = (
        ("seats", ctypes.c_long),
        ("seen", ctypes.c_double),
        ("begins", ctypes.c_double),
        ("addresses", ctypes.c_uint64 * MOST_SEATS),
    )

    def take(self, address: int) -> None:
        """Give a seat to a client from there."""
        self.addresses[self._first(0)] = address
        self.seats += 1

    def leave(self, address: int) -> None:
        """Take it back."""
        self.addresses[self._first(address)] = 0
        self.seats -= 1

    def seats_of(self, address: int) -> int:
        return int(np.count_nonzero(np.frombuffer(self.addresses, np.uint64) == address))

    def _first(self, address: int) -> int:
        return int(np.argmax(np.frombuffer(self.addresses, np.uint64) == address))

    @property
    def began(self) -> bool:
        return self.seen != 0

    def seen_within(self, seconds: float) -> bool:
        """Whether it has given a sign of life lately."""
        return self.began and time.monotonic() - self.seen < seconds

    def live(self) -> None:
        """Give a sign of life."""
        self.seen = time.monotonic()

    def clear(self) -> None:
        """Set all back to what it was before the process began."""
        ctypes.memset(ctypes.addressof(self), 0, ctypes.sizeof(self))


class Seats:
    """Rows of all processes. It may be handed to a process that is just begun."""

    def __init__(self, processes: int = 1):
        self.rows = multiprocessing.get_context("spawn").RawArray(ProcessRow, processes)

    @property
    def taken(self) -> int:
        return sum(row.seats for row in self.rows)

    def taken_from(self, address: int) -> int:
        """Return how many clients of one address have seats, of all processes."""
        return sum(row.seats_of(address) for row in self.rows)

    def fewest_awake(self) -> int:
        """Return the fewest seats that a process has of those that would accept a connection now."""
        return min((row.seats for row in self.rows if row.seen_within(AWAKE_FOR)), default=0)

    @property
    def well(self) -> bool:
        return all(row.seen_within(WELL_FOR) for row in self.rows)
