"""How long a client has taken nothing of what waits for it."""

import time
from collections.abc import Callable


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
