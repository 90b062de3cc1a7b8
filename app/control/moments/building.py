"""How far the construction of the chosen point is built up, while it is shown step by step."""

STEP, STAYS = 0.5, 3.0  # s a step; s that the last one stays


class BuildingUp:
    """It ends by itself."""

    def __init__(self) -> None:
        self._began: float | None = None

    def begin(self, now: float) -> None:
        self._began = now

    def end(self) -> None:
        self._began = None

    @property
    def goes_on(self) -> bool:
        return self._began is not None

    def stage(self, now: float, last: int) -> int | None:
        """From 0 to the last one; None before and afterwards: all is shown."""
        if self._began is None:
            return None
        if now - self._began >= (last + 1) * STEP + STAYS:
            self._began = None
            return None
        return min(max(int((now - self._began) / STEP), 0), last)
