"""What the processes of one server know of each other: a few numbers each, in memory that they share.

A row has one writer, so that nothing needs a lock. A server of one process has a tally of one row.
"""

import multiprocessing
import time

WELL_FOR = 10.0  # s after a sign of life
SEATS, ENDED, SEEN, COLUMNS = 0, 1, 2, 3


class Row:
    """Of one process. seats: its clients; ended: its connections of any kind that there were."""

    def __init__(self, numbers, first: int):
        self._numbers, self._first = numbers, first

    @property
    def seats(self) -> int:
        return int(self._numbers[self._first + SEATS])

    @seats.setter
    def seats(self, count: int) -> None:
        self._numbers[self._first + SEATS] = count

    @property
    def ended(self) -> int:
        return int(self._numbers[self._first + ENDED])

    @ended.setter
    def ended(self, count: int) -> None:
        self._numbers[self._first + ENDED] = count

    @property
    def began(self) -> bool:
        return self._numbers[self._first + SEEN] != 0

    @property
    def well(self) -> bool:
        """Whether it has given a sign of life lately."""
        return self.began and time.monotonic() - self._numbers[self._first + SEEN] < WELL_FOR

    def live(self) -> None:
        """A sign of life."""
        self._numbers[self._first + SEEN] = time.monotonic()

    def clear(self) -> None:
        """As before the process began."""
        self._numbers[self._first : self._first + COLUMNS] = [0.0] * COLUMNS


class Tally:
    """May be handed to a process that is just begun."""

    def __init__(self, processes: int = 1):
        numbers = multiprocessing.get_context("spawn").RawArray("d", COLUMNS * processes)
        self.rows = [Row(numbers, COLUMNS * k) for k in range(processes)]

    @property
    def seats(self) -> int:
        return sum(row.seats for row in self.rows)

    @property
    def well(self) -> bool:
        return all(row.well for row in self.rows)
