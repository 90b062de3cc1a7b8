"""Sessions are kept beside the scheduler: it hands over what a page is, one thread writes what of it is new.

A store may hang, refuse or hold anything: nobody waits for it longer than ANSWERS_WITHIN, or STOPS_WITHIN at the end.
"""

import logging
import secrets
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import TimeoutError as NotYet
from dataclasses import dataclass, field
from typing import TypeVar

import msgspec

from viewimit.settings import Settings
from viewimit.snapshot import Snapshot

from . import codec
from .saved import CHUNK, HEAD, MOST_BYTES, SavedPage, SavedSession, chunks, decoded
from .store import Store

TOUCH_EVERY = 60.0  # s
ANSWERS_WITHIN = 2.0  # s that a visitor waits for the store
STOPS_WITHIN = 6.0  # s for what is left to be written
log = logging.getLogger(__name__)

__all__ = ["CHUNK", "HEAD", "Autosave", "SavedPage", "SavedSession"]
T = TypeVar("T")


@dataclass(eq=False)
class _Written:
    """What the store has of a session. sizes: bytes of its parts; claimed: this writer's is what is kept; unread:
    nobody knows what it has; lost: why what was kept is not gone on with."""

    writer: str
    head: SavedPage | None = None
    history: tuple[Snapshot, ...] = ()
    sizes: dict[str, int] = field(default_factory=dict)
    claimed: bool = False
    unread: bool = False
    lost: str | None = None

    def forget(self) -> None:
        """All of it has to be written."""
        self.head, self.history, self.sizes = None, (), {}


class Autosave:
    """`keep` and `forget` return at once; `claim` and `flush` wait for what was handed over before, at most `within` s.

    `problem` says why a session is not kept, to be told to its visitor; None while it is.
    """

    def __init__(self, store: Store, within: float = ANSWERS_WITHIN, most_bytes: int = MOST_BYTES):
        self._store, self._within, self._most_bytes = store, within, most_bytes
        self._changed = threading.Condition()
        self._waiting: dict[str, SavedSession] = {}
        self._busy: str | None = None  # key that is being written
        self._written: dict[str, _Written] = {}
        self._leaving: set[str] = set()  # keys whose page is gone, and that are still to be written
        self._problems: dict[str, str] = {}
        self._stopped = False
        self._thread = threading.Thread(target=self._run, name="viewimit-autosave", daemon=True)
        self._thread.start()

    def claim(self, key: str, begun: Settings) -> SavedSession | None:
        """The session of this key, if it was begun with these settings; whoever had it before writes no more.

        What cannot be read is set aside, and `lost` says why.
        """
        until = time.monotonic() + self._within
        self.flush(key)
        written = _Written(secrets.token_hex(8))
        with self._changed:
            memory = self._waiting.pop(key, None)  # the store has not taken it in time: what it has is older
        if memory is None or memory.head.begun != begun:
            memory = self._read(key, written, begun, until)
        with self._changed:
            self._written[key] = written
            self._leaving.discard(key)
        return memory

    def lost(self, key: str) -> str | None:
        """Why its visitor does not go on with what was kept, to be told; None if they do, or nothing was."""
        with self._changed:
            written = self._written.get(key)
            return None if written is None else written.lost

    def set_aside(self, key: str, why: str) -> None:
        """What was claimed is of no use: it is kept apart, and the key begins anew."""
        log.warning("a session cannot be resumed: %s", why)
        with self._changed:
            written = self._written[key]
        self._set_aside(key, written, why, time.monotonic() + self._within)

    def keep(self, key: str, memory: SavedSession) -> str | None:
        """Write what is new in it, soon; nothing is taken any more once it is stopped. → `problem`, up to now."""
        with self._changed:
            if not self._stopped:
                self._waiting[key] = memory
                self._changed.notify_all()
            return self._problems.get(key)

    def problem(self, key: str) -> str | None:
        """Why what was handed over last is not in the store, None if it is, or is still to be written."""
        with self._changed:
            return self._problems.get(key)

    def forget(self, key: str) -> None:
        """The page is gone: once what was handed over is written, nothing is known of it here. What was kept stays for
        half an hour."""
        with self._changed:
            self._leaving.add(key)
            self._leave()

    def flush(self, key: str) -> bool:
        """Wait until what was handed over is written. False if the store does not take it in time."""
        with self._changed:
            return self._changed.wait_for(lambda: key not in self._waiting and self._busy != key, self._within)

    def stop(self, within: float = STOPS_WITHIN) -> None:
        """Write all, as far as that goes within so many s, and close the store."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()
        self._thread.join(within)
        if not self._thread.is_alive():
            self._store.close()
            return
        with self._changed:
            left = len(self._waiting) + (self._busy is not None)
            self._waiting.clear()
        log.warning("the store does not answer: what %d visitors did last is not kept", left)

    def _read(self, key: str, written: _Written, begun: Settings, until: float) -> SavedSession | None:
        """What the store has, and that it is known here; None if there is nothing to go on with."""
        try:
            parts = _answer(lambda: self._claimed(key, written), until)
            memory = decoded(parts, begun)
        except (OSError, NotYet) as error:
            why = str(error) or f"no answer within {self._within:g} s"
            log.warning("a session cannot be resumed: %s", why)
            written.unread = True
            written.lost = f"What you left cannot be read now: {why}. Reload the page to try again."
            return None
        except ValueError as error:
            log.warning("a session cannot be resumed: %s", error)
            self._set_aside(key, written, str(error), until)
            return None
        if memory is not None:
            written.head, written.history = memory.head, memory.history
            written.sizes = {name: len(data) for name, data in parts.items()}
        return memory

    def _claimed(self, key: str, written: _Written) -> dict[str, bytes]:
        """What is there can be gone on with even if it cannot be written."""
        try:
            parts = self._store.claim(key, written.writer)
        except OSError as error:
            parts = self._store.read(key)
            log.warning("a session is resumed, but not kept: %s", error)
            return parts
        written.claimed = True
        return parts

    def _set_aside(self, key: str, written: _Written, why: str, until: float) -> None:
        written.forget()
        written.lost = f"What you left cannot be gone on with, so this begins anew: {why}."
        try:
            _answer(lambda: self._store.set_aside(key), until)
        except (OSError, NotYet) as error:
            log.warning("a session that cannot be resumed is not set aside: %s", error or "no answer")

    def _run(self) -> None:
        touched = time.monotonic()
        while True:
            with self._changed:
                self._busy = None
                self._leave()
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._waiting or self._stopped, TOUCH_EVERY)
                if not self._waiting and self._stopped:
                    return
                if self._waiting:
                    self._busy = next(iter(self._waiting))
                    memory, written = self._waiting.pop(self._busy), self._written.get(self._busy)
                keys = list(self._written)
            if self._busy is not None and written is not None:
                self._try_to_write(self._busy, memory, written)
            if time.monotonic() - touched > TOUCH_EVERY:
                touched = time.monotonic()
                try:
                    self._store.touch(keys)
                except Exception as error:  # as below
                    log.warning("sessions are not kept alive: %s", error)

    def _leave(self) -> None:
        """Know nothing any more of pages that are gone and written."""
        for key in [key for key in self._leaving if key not in self._waiting and key != self._busy]:
            self._leaving.discard(key)
            self._written.pop(key, None)
            self._problems.pop(key, None)

    def _try_to_write(self, key: str, memory: SavedSession, written: _Written) -> None:
        """What fails is said, and tried again with what is handed over next."""
        problem = None
        try:
            self._write(key, memory, written)
        # a full disk, a Redis that is down; a state that nobody said how to store
        except (OSError, TypeError) as error:
            problem = str(error)
            log.warning("a session is not kept: %s", error)
        except Exception as error:  # this thread writes for everybody: what it did not foresee must not end it
            problem = f"{type(error).__name__}: {error}"
            log.exception("a session is not kept")
        with self._changed:
            if problem is None:
                self._problems.pop(key, None)
            else:
                self._problems[key] = problem

    def _write(self, key: str, memory: SavedSession, written: _Written) -> None:
        there = self._store.names(key)
        if written.unread:
            if there:
                raise OSError("what you left before is kept in its place; reload the page to go on with that")
            written.unread = False
        if not written.claimed:
            self._store.claim(key, written.writer)
            written.claimed = True
        if not there >= written.sizes.keys():  # removed to make room, or with its whole database
            written.forget()
        parts = {}
        history, before = memory.history, written.history
        for first in range(0, len(history), CHUNK):
            chunk, known = history[first : first + CHUNK], before[first : first + CHUNK]
            if len(chunk) != len(known) or not all(map(_same, chunk, known)):
                parts[str(first // CHUNK)] = codec.encode(chunk)
        if memory.head != written.head:
            parts[HEAD] = msgspec.msgpack.encode(memory.head)
        gone = there - {HEAD, *(str(k) for k in range(chunks(len(history))))}
        if not parts and not gone:
            return
        sizes = {**written.sizes, **{name: len(data) for name, data in parts.items()}}
        sizes = {name: size for name, size in sizes.items() if name not in gone}
        if sum(sizes.values()) > self._most_bytes:
            raise OSError(f"it takes more than {self._most_bytes / 2**20:g} MB")
        if self._store.save(key, written.writer, parts, gone):
            written.head, written.history, written.sizes = memory.head, history, sizes


def _answer(ask: Callable[[], T], until: float) -> T:
    """What it returns or raises, or NotYet if that takes until then; it is not waited for any more, even at the end."""
    answer: Future[T] = Future()

    def run() -> None:
        try:
            answer.set_result(ask())
        except BaseException as error:
            answer.set_exception(error)

    threading.Thread(target=run, name="viewimit-store", daemon=True).start()
    return answer.result(max(until - time.monotonic(), 0.0))


def _same(one: Snapshot, other: Snapshot) -> bool:
    return one is other or one.keeps_the_same(other)
