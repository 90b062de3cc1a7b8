"""One session in a store, as one page has claimed it: what the store has of it, and what of it is new."""

import logging
from collections.abc import Callable
from dataclasses import dataclass, field

import msgspec

from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot

from . import codec
from .saved import CHUNK, HEAD, SavedPage, SavedSession, chunks, decoded
from .store import Store
from .within import NotYet, answer_until

log = logging.getLogger(__name__)


class Held(Exception):
    """The session is leased to another page."""


@dataclass(eq=False)
class StoredSession:
    """What the store has, and by whose lease. there(): whether its page still is; renewed: whether the lease is kept
    up; taken: another has it; sizes: bytes of its parts; claimed: this writer's is what is kept; unread: nobody knows
    what it has; lost: why what was kept is not gone on with."""

    store: Store
    key: str
    writer: str
    there: Callable[[], bool] = lambda: True
    claimed: bool = False
    head: SavedPage | None = field(default=None, init=False)
    history: tuple[Snapshot, ...] = field(default=(), init=False)
    renewed: bool = field(default=True, init=False)
    taken: bool = field(default=False, init=False)
    sizes: dict[str, int] = field(default_factory=dict, init=False)
    unread: bool = field(default=False, init=False)
    lost: str | None = field(default=None, init=False)

    @property
    def memory(self) -> SavedSession | None:
        """What the store has; None if that is nothing."""
        return None if self.head is None else SavedSession(self.head, self.history)

    @property
    def leased(self) -> bool:
        """To this page, which keeps it up."""
        return self.renewed and self.claimed

    def read(self, begun: Settings, until: float, within: float) -> SavedSession | None:
        """Claim it → what the store has, that is known from now on; None if there is nothing to go on with. until: when
        the store must have answered, within so many s. Raises Held."""
        try:
            parts = answer_until(self._claim, until)
            memory = decoded(parts, begun)
        except (OSError, NotYet) as error:
            why = str(error) or f"no answer within {within:g} s"
            log.warning("a session cannot be resumed: %s", why)
            self.unread = True
            self.lost = f"What you left cannot be read now: {why}. Reload the page to try again."
            return None
        except ValueError as error:
            self.set_aside(str(error), until)
            return None
        if memory is not None:
            self.head, self.history = memory.head, memory.history
            self.sizes = {name: len(data) for name, data in parts.items()}
        return memory

    def set_aside(self, why: str, until: float) -> None:
        """It is of no use: it is kept apart, and its key begins anew."""
        log.warning("a session cannot be resumed: %s", why)
        self._forget()
        self.lost = f"What you left cannot be gone on with, so this begins anew: {why}."
        try:
            answer_until(lambda: self.store.set_aside(self.key), until)
        except (OSError, NotYet) as error:
            log.warning("a session that cannot be resumed is not set aside: %s", error or "no answer")

    def write(self, memory: SavedSession, most_bytes: int) -> bool:
        """What is new in it. False if the session is another's."""
        there = self.store.names(self.key)
        if self.unread:
            if there:
                raise OSError("what you left before is kept in its place; reload the page to go on with that")
            self.unread = False
        if not self.claimed:
            if self.store.claim(self.key, self.writer) is None:
                return False
            self.claimed = True
        if not there >= self.sizes.keys():  # removed to make room, or with its whole database
            self._forget()
        parts = self._new_parts(memory)
        gone = there - {HEAD, *(str(k) for k in range(chunks(len(memory.history))))}
        if not parts and not gone:
            return True
        sizes = {**self.sizes, **{name: len(data) for name, data in parts.items()}}
        sizes = {name: size for name, size in sizes.items() if name not in gone}
        if sum(sizes.values()) > most_bytes:
            raise OSError(f"it takes more than {most_bytes / 2**20:g} MB")
        if not self.store.save(self.key, self.writer, parts, gone):
            return False
        self.head, self.history, self.sizes = memory.head, memory.history, sizes
        return True

    def release(self) -> None:
        """Give the lease back."""
        if self.claimed:
            self.store.release(self.key, self.writer)

    def _claim(self) -> dict[str, bytes]:
        """What is there can be gone on with even if it cannot be written."""
        if self.claimed:
            return self.store.read(self.key)
        try:
            parts = self.store.claim(self.key, self.writer)
        except OSError as error:
            log.warning("a session is resumed, but not kept: %s", error)
            return self.store.read(self.key)
        if parts is None:
            raise Held
        self.claimed = True
        return parts

    def _new_parts(self, memory: SavedSession) -> dict[str, bytes]:
        """Those that the store has otherwise, or not at all."""
        parts, history, before = {}, memory.history, self.history
        for first in range(0, len(history), CHUNK):
            chunk, known = history[first : first + CHUNK], before[first : first + CHUNK]
            if len(chunk) != len(known) or not all(map(_same, chunk, known)):
                parts[str(first // CHUNK)] = codec.encode(chunk)
        if memory.head != self.head:
            parts[HEAD] = msgspec.msgpack.encode(memory.head)
        return parts

    def _forget(self) -> None:
        """All of it has to be written."""
        self.head, self.history, self.sizes = None, (), {}


def _same(one: Snapshot, other: Snapshot) -> bool:
    return one is other or one.keeps_the_same(other)
