"""How much may come: token buckets, and a log that a flood cannot flood."""

import codecs
import logging
import time
from collections.abc import Callable

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
