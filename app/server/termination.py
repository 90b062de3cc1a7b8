"""Whether a process of the server is to end."""

from contextlib import suppress
from queue import Empty, SimpleQueue


class Termination:
    """As `threading.Event`, and a signal may set it in the midst of anything that its thread does with it: that one's
    lock, which is held then, would be waited for for ever."""

    def __init__(self):
        self._is_set = False
        self._told: SimpleQueue[None] = SimpleQueue()  # whose put may come in the midst of another, or of a get

    def set(self) -> None:
        self._is_set = True
        self._told.put(None)

    def is_set(self) -> bool:
        return self._is_set

    def wait(self, seconds: float) -> bool:
        """Whether it is set, after that time at most."""
        with suppress(Empty):
            self._told.put(self._told.get(timeout=seconds))  # whoever else waits is told too
        return self._is_set
