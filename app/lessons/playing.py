"""Motions that a step shows one by one, once it is revealed."""

LEAST_DELAY, PLAYED = 0.35, 24  # s of a motion that is played; so many motions are, then all


class Playing:
    """played: motions that are shown."""

    def __init__(self) -> None:
        self.played = 0
        self._next: float | None = None

    @property
    def over(self) -> bool:
        """Whether all are shown."""
        return self.played >= PLAYED

    def tick(self, now: float, rate: float, still: bool) -> bool:
        """rate: motions a second; still: all are shown at once, as nothing is to move. → whether more are shown."""
        if still:
            self.played = PLAYED
            return True
        if self._next is not None and now < self._next:
            return False
        self._next = now + max(1 / rate, LEAST_DELAY)
        self.played += 1
        return True
