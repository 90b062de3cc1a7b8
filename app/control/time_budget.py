"""How much of the time one page's visitor may have carried out, so that the others' pages keep their pace."""

import time
from collections.abc import Callable

SHARE = 0.2  # of the time: 10 ms of a tick of 50 ms
AT_ONCE = 0.2  # s that may be spent at once after a while without much


class TimeBudget:
    """What one command takes beyond it is made up for by those after it, which wait."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._left, self._last = AT_ONCE, clock()

    @property
    def left(self) -> bool:
        now = self._clock()
        self._left = min(AT_ONCE, self._left + SHARE * (now - self._last))
        self._last = now
        return self._left > 0

    def spend(self, work: Callable[[], None]) -> None:
        """Do it, and count how long it takes."""
        began = self._clock()
        try:
            work()
        finally:
            self._left -= self._clock() - began
