"""Sessions are kept beside the scheduler: it hands over what a page is, one thread writes what of it is new."""

import logging
import secrets
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import msgspec

from viewimit import __version__
from viewimit.settings import Settings
from viewimit.snapshot import Snapshot

from . import codec
from .store import RENEW_EVERY, Store

CHUNK = 32  # motions a part
HEAD = "head"
TAKEN = "another tab has taken this session"
log = logging.getLogger(__name__)


class SavedPage(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A page but for its history. begun: what the server was started with; motion: a recorded one, as a file has it."""

    version: str = __version__
    begun: Settings
    cursor: int
    length: int
    preset: str
    speed: float
    chosen: int | None
    show: dict[str, bool]
    dark: bool | None
    motion: bytes | None


@dataclass(frozen=True, eq=False)
class SavedSession:
    """All that is kept of a page, at one moment."""

    head: SavedPage
    history: tuple[Snapshot, ...]


@dataclass(eq=False)
class _Written:
    """What the store has of a session, and by whose lease. there(): whether its page still is; renewed: whether the
    lease is kept up; lost: another has it."""

    writer: str
    there: Callable[[], bool]
    head: SavedPage | None = None
    history: tuple[Snapshot, ...] = ()
    renewed: bool = True
    lost: bool = False


class Held(Exception):
    """The session is leased to another page."""


class Autosave:
    """`keep` returns at once; `claim` and `flush` wait for what was handed over before. Leases are renewed from `claim`
    to `forget`.

    `problem` says why a session is not kept, to be told to its visitor; None while it is.
    """

    def __init__(self, store: Store):
        self._store = store
        self._changed = threading.Condition()
        self._waiting: dict[str, SavedSession] = {}
        self._busy: str | None = None  # key that is being written
        self._written: dict[str, _Written] = {}
        self._problems: dict[str, str] = {}
        self._stopped = self._unrenewed = False
        self._thread = threading.Thread(target=self._run, name="viewimit-autosave", daemon=True)
        self._thread.start()

    def held(self, keys: Iterable[str]) -> dict[str, float]:
        """Which sessions are leased, by whomever, and for how many s yet. Raises OSError."""
        return self._store.held(keys)

    def claim(self, key: str, begun: Settings, there: Callable[[], bool] = lambda: True) -> SavedSession | None:
        """Lease the session of this key → what it is, if it was begun with these settings; who has it here loses it.

        there(): asked before each renewal, whether its page still is; from the thread that writes, so it must be short.
        Raises Held if another process has it, OSError for a store that does not answer.
        """
        self.forget(key)
        written = _Written(secrets.token_hex(8), there)
        parts = self._store.claim(key, written.writer)
        if parts is None:
            raise Held
        memory = None
        try:
            memory = _decoded(parts, begun)
        except ValueError as error:
            log.warning("a session cannot be resumed: %s", error)
        if memory is not None:
            written.head, written.history = memory.head, memory.history
        with self._changed:
            self._written[key] = written
        return memory

    def keep(self, key: str, memory: SavedSession) -> str | None:
        """Write what is new in it, soon; nothing is taken any more once it is stopped, or once another page has the
        session. → `problem`, up to now."""
        with self._changed:
            written = self._written.get(key)
            if not self._stopped and not (written is not None and written.lost):
                self._waiting[key] = memory
                self._changed.notify_all()
            return self._problems.get(key)

    def problem(self, key: str) -> str | None:
        """Why what was handed over last is not in the store, None if it is, or is still to be written."""
        with self._changed:
            return self._problems.get(key)

    def leaving(self, key: str) -> None:
        """The page goes: its lease is renewed no more, but ends only with the last that is to be kept."""
        with self._changed:
            if key in self._written:
                self._written[key].renewed = False

    def forget(self, key: str) -> None:
        """The page is gone; what was kept stays for half an hour, for whoever claims it."""
        self.flush(key)
        with self._changed:
            written = self._written.pop(key, None)
            self._problems.pop(key, None)
        if written is not None:
            try:
                self._store.release(key, written.writer)
            except OSError as error:
                log.warning("a session is free only after a while: %s", error)

    def flush(self, key: str) -> None:
        """Wait until what was handed over is written."""
        with self._changed:
            self._changed.wait_for(lambda: key not in self._waiting and self._busy != key)

    def stop(self) -> None:
        """Write all, and close the store."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()
        self._thread.join()
        self._store.close()

    def _run(self) -> None:
        due = time.monotonic()
        while True:
            memory = written = None
            with self._changed:
                self._busy = None
                self._changed.notify_all()
                self._changed.wait_for(lambda: self._waiting or self._stopped, max(due - time.monotonic(), 0.0))
                if not self._waiting and self._stopped:
                    return
                if self._waiting:
                    self._busy = next(iter(self._waiting))
                    memory, written = self._waiting.pop(self._busy), self._written.get(self._busy)
            if self._busy is not None and memory is not None and written is not None:
                self._try_to_write(self._busy, memory, written)
            if time.monotonic() >= due:
                self._renew()
                due = time.monotonic() + RENEW_EVERY

    def _renew(self) -> None:
        with self._changed:
            all_written = {key: written for key, written in self._written.items() if written.renewed}
        all_written = {key: written for key, written in all_written.items() if written.there()}
        try:
            lost = self._store.renew({key: written.writer for key, written in all_written.items()})
        except OSError as error:
            if not self._unrenewed:  # one line until it answers again
                log.warning("sessions are not kept alive: %s", error)
            self._unrenewed = True
            return
        self._unrenewed = False
        for key in lost:
            self._lose(key, all_written[key])

    def _lose(self, key: str, written: _Written) -> None:
        """Another page has the session: this one writes it no more, and says so."""
        with self._changed:
            if self._written.get(key) is not written or written.lost:
                return
            written.renewed, written.lost = False, True
            self._waiting.pop(key, None)
            self._problems[key] = TAKEN
        log.warning("a session is not kept: %s", TAKEN)

    def _try_to_write(self, key: str, memory: SavedSession, written: _Written) -> None:
        """What fails is said, and tried again with what is handed over next."""
        problem = None
        try:
            if not self._write(key, memory, written):
                self._lose(key, written)
                return
        # a full disk, a Redis that is down; a state that nobody said how to store
        except (OSError, TypeError) as error:
            problem = str(error)
            log.warning("a session is not kept: %s", error)
        with self._changed:
            if problem is None:
                self._problems.pop(key, None)
            else:
                self._problems[key] = problem

    def _write(self, key: str, memory: SavedSession, written: _Written) -> bool:
        """False if the session is another's."""
        parts = {}
        history, before = memory.history, written.history
        for first in range(0, len(history), CHUNK):
            chunk, known = history[first : first + CHUNK], before[first : first + CHUNK]
            if len(chunk) != len(known) or not all(map(_same, chunk, known)):
                parts[str(first // CHUNK)] = codec.encode(chunk)
        if memory.head != written.head:
            parts[HEAD] = msgspec.msgpack.encode(memory.head)
        gone = [str(k) for k in range(_chunks(len(history)), _chunks(len(before)))]
        if not parts and not gone:
            return True
        if not self._store.save(key, written.writer, parts, gone):
            return False
        written.head, written.history = memory.head, history
        return True


def _decoded(parts: dict[str, bytes], begun: Settings) -> SavedSession | None:
    """None without a session that goes on from these settings. Raises ValueError for parts that do not fit."""
    if HEAD not in parts:
        return None
    try:
        head = msgspec.msgpack.decode(parts[HEAD], type=SavedPage)
    except msgspec.MsgspecError as error:
        raise ValueError(f"it is of another version: {error}") from None
    if head.version != __version__ or head.begun != begun:
        return None
    names = [str(k) for k in range(_chunks(head.length))]
    if not parts.keys() >= set(names):
        raise ValueError("a part of it is missing")
    history = tuple(moment for name in names for moment in codec.decode(parts[name]))
    if len(history) != head.length or not 0 <= head.cursor < head.length:
        raise ValueError("its parts are of different moments")
    return SavedSession(head, history)


def _same(one: Snapshot, other: Snapshot) -> bool:
    return one is other or one.keeps_the_same(other)


def _chunks(length: int) -> int:
    return -(-length // CHUNK)
