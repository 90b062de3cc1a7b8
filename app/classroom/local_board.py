"""The board of a server that is one process and shares nothing."""

import threading
import time
from collections.abc import Callable, Mapping

from .board import GONE_S, MOST_REPLIES, Posted


class LocalBoard:
    """See Board."""

    look_every = 0.25

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock, self._lock = clock, threading.Lock()
        self._orders, self._seen = (0, b""), clock()
        self._rosters: dict[str, tuple[float, bytes]] = {}
        self._replies: dict[str, dict[str, bytes]] = {}

    def orders(self) -> Posted:
        with self._lock:
            return Posted(*self._orders, self._clock() - self._seen)

    def order(self, number: int, data: bytes) -> bool:
        with self._lock:
            if self._orders[0] != number:
                return False
            self._orders, self._seen = (number + 1, data), self._clock()
            return True

    def live(self, number: int) -> None:
        with self._lock:
            if self._orders[0] == number:
                self._seen = self._clock()

    def publish(self, process: str, data: bytes | None) -> None:
        with self._lock:
            _, before = self._rosters.get(process, (0.0, b""))
            self._rosters[process] = self._clock(), before if data is None else data

    def leave(self, process: str) -> None:
        with self._lock:
            self._rosters.pop(process, None)

    def rosters(self) -> list[bytes]:
        with self._lock:
            return [data for seen, data in self._rosters.values() if data and self._clock() - seen < GONE_S]

    def reply(self, call: str, replies: Mapping[str, bytes]) -> None:
        with self._lock:
            kept = self._replies.setdefault(call, {})
            for student, data in replies.items():
                if student in kept or len(kept) < MOST_REPLIES:
                    kept[student] = data

    def replies(self, call: str) -> dict[str, bytes]:
        with self._lock:
            return dict(self._replies.get(call, {}))

    def watch(self, changed: Callable[[], None]) -> None:
        pass

    def close(self) -> None:
        pass
