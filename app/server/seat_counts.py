"""What the processes of one server know of each other: a few numbers each, in memory that they share.

Each process writes its own row alone, so that nothing needs a lock. A server of one process has one row.
"""

import ctypes
import multiprocessing
import time

import numpy as np

WELL_FOR = 10.0  # s after a sign of life
MOST_SEATS = 10_000  # of a process


class WorkerCounts(ctypes.Structure):
    """Of one process. seats: its clients; ended: its connections of any kind that there were; seen: s, its last sign
    of life while it serves, 0 before the first; begins: s, the last one while it was beginning; addresses: of its
    clients, as `network_of` has them, 0 where there is none."""

    _fields_ = (
        ("seats", ctypes.c_long),
        ("ended", ctypes.c_long),
        ("seen", ctypes.c_double),
        ("begins", ctypes.c_double),
        ("addresses", ctypes.c_uint64 * MOST_SEATS),
    )

    def take(self, address: int) -> None:
        """A client from there has a seat."""
        self.addresses[self._first(0)] = address
        self.seats += 1

    def leave(self, address: int) -> None:
        """It has it no more."""
        self.addresses[self._first(address)] = 0
        self.seats -= 1

    def seats_of(self, address: int) -> int:
        return int(np.count_nonzero(np.frombuffer(self.addresses, np.uint64) == address))

    def _first(self, address: int) -> int:
        return int(np.argmax(np.frombuffer(self.addresses, np.uint64) == address))

    @property
    def began(self) -> bool:
        return self.seen != 0

    @property
    def well(self) -> bool:
        """Whether it has given a sign of life lately."""
        return self.began and time.monotonic() - self.seen < WELL_FOR

    def live(self) -> None:
        """A sign of life."""
        self.seen = time.monotonic()

    def clear(self) -> None:
        """As before the process began."""
        ctypes.memset(ctypes.addressof(self), 0, ctypes.sizeof(self))


class SeatCounts:
    """May be handed to a process that is just begun."""

    def __init__(self, processes: int = 1):
        self.rows = multiprocessing.get_context("spawn").RawArray(WorkerCounts, processes)

    @property
    def seats(self) -> int:
        return sum(row.seats for row in self.rows)

    def seats_of(self, address: int) -> int:
        """Of all processes."""
        return sum(row.seats_of(address) for row in self.rows)

    @property
    def well(self) -> bool:
        return all(row.well for row in self.rows)
