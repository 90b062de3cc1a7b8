"""Sessions are kept beside the scheduler: it hands over what a page is, one thread writes what of it is new.

A store may hang, refuse or hold anything: nobody waits for it longer than ANSWERS_WITHIN, or STOPS_WITHIN at the end.
"""

import logging
import math
import secrets
import threading
import time
from collections.abc import Callable, Iterable

from viewimit.loop.settings import Settings

from .saved import CHUNK, HEAD, MOST_BYTES, SavedPage, SavedSession
from .store import RENEW_EVERY, Store
from .stored import StoredSession
from .within import NotYet, answer_until

ANSWERS_WITHIN = 2.0  # s that a visitor waits for the store
STOPS_WITHIN = 6.0  # s for what is left to be written
TRIED_FOR = 60.0  # s to write what is left of a page that is gone, once a second
TAKEN = "another tab has taken this session"
log = logging.getLogger(__name__)

__all__ = ["CHUNK", "HEAD", "Autosave", "SavedPage", "SavedSession"]


class Autosave:
    """`keep` and `forget` return at once; `claim` and `flush` wait for what was handed over before, at most `within` s.
    Leases are renewed from `claim` to `forget`.

    `problem` says why a session is not kept, to be told to its visitor; None while it is.
    """

    def __init__(self, store: Store, within: float = ANSWERS_WITHIN, most_bytes: int = MOST_BYTES):
        self._store, self._within, self._most_bytes = store, within, most_bytes
        self._changed = threading.Condition()
        self._waiting: dict[str, SavedSession] = {}
        self._busy: str | None = None  # key that is being written
        self._written: dict[str, StoredSession] = {}
        self._again: dict[str, SavedSession] = {}  # of pages that are gone, what the store did not take
        self._leaving: dict[str, float] = {}  # keys whose page is gone, and until when s they are tried to be written
        self._going: set[str] = set()  # whose leases are given back just now
        self._problems: dict[str, str] = {}
        self._stopped = self._unrenewed = False
        self._thread = threading.Thread(target=self._run, name="viewimit-autosave", daemon=True)
        self._thread.start()

    def held(self, keys: Iterable[str]) -> dict[str, float]:
        """Which sessions are leased, by whomever, and for how many s yet. Raises OSError."""
        keys = list(keys)
        try:
            return answer_until(lambda: self._store.held(keys), time.monotonic() + self._within)
        except NotYet:
            raise OSError(f"the store of sessions gave no answer within {self._within:g} s") from None

    def claim(self, key: str, begun: Settings, there: Callable[[], bool] = lambda: True) -> SavedSession | None:
        """Lease the session of this key → what it is, if it was begun with these settings; who has it here loses it.

        there(): asked before each renewal, whether its page still is; from the thread that writes, so it must be short.
        What cannot be read is set aside, and `lost` says why. Raises Held if another process has it.
        """
        until = time.monotonic() + self._within
        self.flush(key)
        with self._changed:
            self._changed.wait_for(lambda: key not in self._going, max(until - time.monotonic(), 0.0))
            self._leaving.pop(key, None)
            written = self._written.get(key)
            if written is not None and not written.taken and written.claimed:
                written.there, written.renewed = there, True  # its lease goes on
                unwritten = self._waiting.get(key) or self._again.get(key)  # which the store may not have taken in time
                memory = unwritten or written.memory
                if memory is not None and memory.head.begun == begun:
                    return memory
        if written is not None and written.claimed and not written.taken:
            written = StoredSession(self._store, key, written.writer, there, claimed=True)
        else:
            written = StoredSession(self._store, key, secrets.token_hex(8), there)
        memory = written.read(begun, until, self._within)
        with self._changed:
            self._waiting.pop(key, None)
            self._written[key] = written
        return memory

    def lost(self, key: str) -> str | None:
        """Why its visitor does not go on with what was kept, to be told; None if they do, or nothing was."""
        with self._changed:
            written = self._written.get(key)
            return None if written is None else written.lost

    def set_aside(self, key: str, why: str) -> None:
        """What was claimed is of no use: it is kept apart, and the key begins anew."""
        with self._changed:
            written = self._written[key]
        written.set_aside(why, time.monotonic() + self._within)

    def keep(self, key: str, memory: SavedSession) -> str | None:
        """Write what is new in it, soon; nothing is taken any more once it is stopped, or once another page has the
        session. → `problem`, up to now."""
        with self._changed:
            written = self._written.get(key)
            if not self._stopped and not (written is not None and written.taken):
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
        """The page is gone: once what was handed over is written, its lease is given back, and nothing is known of it
        here. What was kept stays for half an hour, for whoever claims it."""
        with self._changed:
            self._problems.pop(key, None)
            if key in self._written:
                self._leaving[key] = time.monotonic() + TRIED_FOR
                self._changed.notify_all()

    def flush(self, key: str) -> bool:
        """Wait until what was handed over is written. False if the store does not take it in time."""
        with self._changed:
            return self._changed.wait_for(lambda: key not in self._waiting and self._busy != key, self._within)

    def stop(self, within: float = STOPS_WITHIN) -> None:
        """Write all, as far as that goes within so many s, and close the store."""
        with self._changed:
            self._stopped = True
            self._try_again()
            self._changed.notify_all()
        self._thread.join(within)
        if not self._thread.is_alive():
            self._store.close()
            return
        with self._changed:
            left = len(self._waiting) + (self._busy is not None)
            self._waiting.clear()
        log.warning("the store does not answer: what %d visitors did last is not kept", left)

    def _run(self) -> None:
        due = time.monotonic()
        while True:
            memory = written = None
            with self._changed:
                self._busy = None
                self._changed.notify_all()
                self._changed.wait_for(self._has_to_do, max(due - time.monotonic(), 0.0))
                ends = self._stopped and not self._waiting
                if ends:
                    self._leaving.update(dict.fromkeys(self._written, 0.0))
                if self._waiting:
                    self._busy = next(iter(self._waiting))
                    memory, written = self._waiting.pop(self._busy), self._written.get(self._busy)
            if self._busy is not None and memory is not None and written is not None:
                self._try_to_write(self._busy, memory, written)
            self._leave()
            if ends:
                return
            if time.monotonic() >= due:
                self._renew()
                self._try_again()
                due = time.monotonic() + RENEW_EVERY

    def _has_to_do(self) -> bool:
        return bool(self._waiting or self._stopped or self._leaving.keys() - self._again.keys())

    def _leave(self) -> None:
        """Know nothing any more of pages that are gone and written, and give their leases back."""
        with self._changed:
            self._going = self._leaving.keys() - self._waiting.keys() - self._again.keys()
            self._leaving = {key: until for key, until in self._leaving.items() if key not in self._going}
            gone = {key: self._written.pop(key, None) for key in self._going}
            for key in gone:
                self._problems.pop(key, None)
        for written in gone.values():
            try:
                if written is not None:
                    written.release()
            except Exception as error:  # as in writing
                log.warning("a session is free only after a while: %s", error)
        with self._changed:
            self._going = set()
            self._changed.notify_all()

    def _renew(self) -> None:
        with self._changed:
            leased = {key: written for key, written in self._written.items() if written.leased}
        leased = {key: written for key, written in leased.items() if written.there()}
        try:
            lost = self._store.renew({key: written.writer for key, written in leased.items()})
        except Exception as error:  # as in writing
            if not self._unrenewed:  # one line until it answers again
                log.warning("sessions are not kept alive: %s", error)
            self._unrenewed = True
            return
        self._unrenewed = False
        for key in lost:
            self._lose(key, leased[key])

    def _try_again(self) -> None:
        """To write what was left by pages that are gone, and that hand over nothing more."""
        with self._changed:
            for key, memory in self._again.items():
                self._waiting.setdefault(key, memory)
            self._again = {}

    def _lose(self, key: str, written: StoredSession) -> None:
        """Another page has the session: this one writes it no more, and says so."""
        with self._changed:
            if self._written.get(key) is not written or written.taken:
                return
            written.renewed, written.taken = False, True
            self._waiting.pop(key, None)
            self._problems[key] = TAKEN
        log.warning("a session is not kept: %s", TAKEN)

    def _try_to_write(self, key: str, memory: SavedSession, written: StoredSession) -> None:
        """What fails is said, and tried again with what is handed over next; once a second if its page is gone."""
        problem, again = None, False
        try:
            if not written.write(memory, self._most_bytes):
                self._lose(key, written)
                return
        # a full disk, a Redis that is down; a state that nobody said how to store
        except (OSError, TypeError) as error:
            problem, again = str(error), isinstance(error, OSError)
            if self.problem(key) != problem:
                log.warning("a session is not kept: %s", error)
        except Exception as error:  # this thread writes for everybody: what it did not foresee must not end it
            problem = f"{type(error).__name__}: {error}"
            log.exception("a session is not kept")
        with self._changed:
            if problem is None:
                self._problems.pop(key, None)
            else:
                self._problems[key] = problem
                if again and not written.renewed and time.monotonic() < self._leaving.get(key, math.inf):
                    self._again[key] = memory
