"""Where sessions are kept while nobody looks: an SQLite file of this user's, or a Redis that several servers share.

A session is a few parts, bytes by name, under a key that only its browser knows. It has one writer, the page that
claimed it last: an older page of the same browser, which may not know yet that it is gone, cannot write over it.
"""

from collections.abc import Iterable
from typing import Protocol

KEPT_S = 30 * 60  # after the last sign of life
MOST_BYTES = 256 << 20  # of all sessions; beyond, those whose sign of life is oldest are removed


class Store(Protocol):
    """Methods may be called from any thread."""

    def claim(self, key: str, writer: str) -> dict[str, bytes]:
        """Its parts, none if there is no such session; from now on `writer` alone may write them."""
        ...

    def read(self, key: str) -> dict[str, bytes]:
        """Its parts, also where nothing can be written. As `claim`, raises ValueError for what is no session's."""
        ...

    def names(self, key: str) -> set[str]:
        """Of its parts that are there: it may have been removed, or its database deleted."""
        ...

    def set_aside(self, key: str) -> None:
        """Keep what is there under another key, for as long as a session: nobody goes on with it."""

    def save(self, key: str, writer: str, parts: dict[str, bytes], gone: Iterable[str] = ()) -> bool:
        """Write parts and remove others, all or nothing. False if somebody else has claimed the session."""
        ...

    def touch(self, keys: Iterable[str]) -> None:
        """A sign of life of these sessions; those without one for KEPT_S are removed."""

    def close(self) -> None: ...
