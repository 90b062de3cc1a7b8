"""Where the pages of a class meet: in this process, in an SQLite file that processes share, or in a Redis.

On it stand the lecturer's orders, of which the newest counts, the students of each process, and what they reply to a
call. Everything is bytes: who reads it checks it.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple, Protocol

GONE_S = 6.0  # without a sign of life: a process and its students
LED_S = 15.0  # without one of the lecturer, whose page comes back in this time from a process that was killed
KEPT_S = 6 * 3600  # s that orders and replies stay without a sign of life of a lecturer
MOST_REPLIES = 1_000  # to a call


class Posted(NamedTuple):
    """number: one more with every order, 0 before the first; age: s since the lecturer's last sign of life."""

    number: int
    data: bytes
    age: float


class Board(Protocol):
    """Of one class. Methods may be called from any thread, and raise OSError if the store does not do what they ask.

    look_every: s between two looks at the orders, with which changes are seen in time."""

    look_every: float

    def orders(self) -> Posted: ...

    def order(self, number: int, data: bytes) -> bool:
        """In place of the orders of that number. False if others stand there meanwhile."""
        ...

    def live(self, number: int) -> None:
        """A sign of life of who gave the orders of that number."""
        ...

    def publish(self, process: str, data: bytes | None) -> None:
        """The students of a process. None: as before, a sign of life."""
        ...

    def leave(self, process: str) -> None:
        """Its students are gone."""
        ...

    def rosters(self) -> list[bytes]:
        """Of processes that have given a sign of life lately."""
        ...

    def reply(self, call: str, replies: Mapping[str, bytes]) -> None:
        """By student, each in place of what that one replied before. More than MOST_REPLIES are not kept."""
        ...

    def replies(self, call: str) -> dict[str, bytes]: ...

    def watch(self, changed: Callable[[], None]) -> None:
        """Call this, from any thread, when the orders may have changed, where the store tells of that."""
        ...

    def close(self) -> None: ...
