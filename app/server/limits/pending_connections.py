"""Connections that have no seat yet: so many, so many of one address, and the oldest goes when there are more.

A request comes within moments of its connection; who has waited longest is likeliest to send none.
"""

from collections.abc import Callable, Hashable


class PendingConnections:
    """most: at a time; most_of_one: from one address, as `network_of` has it."""

    def __init__(self, most: int, most_of_one: int):
        self._most, self._most_of_one = most, most_of_one
        self._waiting: dict[Hashable, tuple[int, Callable[[], None]]] = {}  # oldest first

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, connection: Hashable, address: int, end: Callable[[], None]) -> None:
        """end(): closes it; called if it has to make room."""
        same = [other for other, (its, _) in self._waiting.items() if its == address]
        if len(same) >= self._most_of_one:
            self._end(same[0])
        elif len(self._waiting) >= self._most:
            self._end(next(iter(self._waiting)))
        self._waiting[connection] = address, end

    def discard(self, connection: Hashable) -> None:
        """It has a seat, or it has ended."""
        self._waiting.pop(connection, None)

    def _end(self, connection: Hashable) -> None:
        _, end = self._waiting.pop(connection)
        end()
