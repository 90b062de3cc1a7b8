"""What the processes of one server know of each other: a few numbers each, in memory that they share.

Each process writes its own row alone, so that nothing needs a lock. A server of one process has one row.
"""

import ctypes
import multiprocessing
import time

WELL_FOR = 10.0  # s after a sign of life


class WorkerCounts(ctypes.Structure):
    """Of one process. seats: its clients; ended: its connections of any kind that there were; seen: s, its last sign
    of life, 0 before the first."""

    _fields_ = (("seats", ctypes.c_long), ("ended", ctypes.c_long), ("seen", ctypes.c_double))

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
        self.seats, self.ended, self.seen = 0, 0, 0.0


class SeatCounts:
    """May be handed to a process that is just begun."""

    def __init__(self, processes: int = 1):
        self.rows = multiprocessing.get_context("spawn").RawArray(WorkerCounts, processes)

    @property
    def seats(self) -> int:
        return sum(row.seats for row in self.rows)

    @property
    def well(self) -> bool:
        return all(row.well for row in self.rows)
