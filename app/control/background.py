"""What takes long for one page goes on in a thread of its own while the page is ticked, one turn after the other."""

import threading
from collections.abc import Callable


class Background:
    """busy: from a turn's beginning until `end` has told that it has ended; alone: meanwhile the session must not be
    drawn either, without it, reading is safe."""

    def __init__(self):
        self._thread: threading.Thread | None = None
        self._fault: BaseException | None = None
        self.alone = False

    @property
    def busy(self) -> bool:
        return self._thread is not None

    def begin(self, turn: Callable[[], None], alone: bool) -> None:
        self.alone = alone
        self._thread = threading.Thread(target=self._carry_out, args=(turn,), name="viewimit-turn", daemon=True)
        self._thread.start()

    def end(self) -> bool:
        """Whether a turn has ended since it was asked last. Raises what the turn raised."""
        if self._thread is None or self._thread.is_alive():
            return False
        self._thread, self.alone = None, False
        fault, self._fault = self._fault, None
        if fault is not None:
            raise fault
        return True

    def wait(self, seconds: float | None = None) -> bool:
        """Whether no turn goes on any more, after that time at most."""
        if self._thread is not None:
            self._thread.join(seconds)
        return self._thread is None or not self._thread.is_alive()

    def _carry_out(self, turn: Callable[[], None]) -> None:
        try:
            turn()
        except BaseException as fault:  # raised where the turn ends, in the thread that draws the page
            self._fault = fault
