"""Where sessions are kept while nobody looks: an SQLite file of this user's, or a Redis that several servers share.

A session is a few parts, bytes by name, under a key that only its browser knows. It has one writer, the page that
claimed it last: an older page of the same browser, which may not know yet that it is gone, cannot write over it.
"""

from collections.abc import Iterable
from typing import Protocol

KEPT_S = 30 * 60  # after the last sign of life


class Store(Protocol):
    """Methods may be called from any thread."""

    def claim(self, key: str, writer: str) -> dict[str, bytes]:
        """Its parts, none if there is no such session; from now on `writer` alone may write them."""
        ...

    def save(self, key: str, writer: str, parts: dict[str, bytes], gone: Iterable[str] = ()) -> bool:
        """Write parts and remove others, all or nothing. False if somebody else has claimed the session."""
        ...

    def touch(self, keys: Iterable[str]) -> None:
        """A sign of life of these sessions; those without one for KEPT_S are removed."""

    def close(self) -> None: ...
