"""Where sessions are kept while nobody looks: an SQLite file of this user's, or a Redis that several servers share.

A session is a few parts, bytes by name, under a key that only its browser knows. It belongs to one writer at a time, a
page, by a lease that the writer takes, renews and gives back. One that has ended without a word loses it after LEASE_S;
one that only fell silent may go on with it unless another has taken it meanwhile, and is told so then.
"""

from collections.abc import Iterable, Mapping
from typing import Protocol

KEPT_S = 30 * 60  # after the last sign of life
MOST_BYTES = 256 << 20  # of all sessions; beyond, those whose sign of life is oldest are removed
LEASE_S, RENEW_EVERY = 5.0, 1.0  # s, by the clock of the store


class Store(Protocol):
    """Methods may be called from any thread, and raise OSError if the store does not do what they ask; `claim` and
    `read` raise ValueError for what is no session's."""

    def claim(self, key: str, writer: str) -> dict[str, bytes] | None:
        """Lease a session to `writer`, who alone may write it from now on → its parts, none of a new one; None: it is
        leased already."""
        ...

    def held(self, keys: Iterable[str]) -> dict[str, float]:
        """Those that are leased, and for how many s yet: more than at the look before only if renewed between."""
        ...

    def renew(self, leases: Mapping[str, str]) -> set[str]:
        """A sign of life of sessions, each with its writer → those that are another's now. Sessions without one for
        KEPT_S are removed."""
        ...

    def read(self, key: str) -> dict[str, bytes]:
        """Its parts, also where nothing can be written."""
        ...

    def names(self, key: str) -> set[str]:
        """Of its parts that are there: it may have been removed, or its database deleted."""
        ...

    def set_aside(self, key: str) -> None:
        """Keep what is there under another key, for as long as a session: nobody goes on with it."""

    def save(self, key: str, writer: str, parts: dict[str, bytes], gone: Iterable[str] = ()) -> bool:
        """Write parts and remove others, all or nothing. False if the session is not this writer's."""
        ...

    def release(self, key: str, writer: str) -> None:
        """Give the lease back, if it is still this writer's: anybody may claim the session at once."""

    def close(self) -> None: ...
