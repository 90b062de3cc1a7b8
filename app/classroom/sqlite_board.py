"""The board in an SQLite file beside the sessions, which the processes of a server look at a few times a second."""

import contextlib
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from ..sessions.sqlite_file import open_file
from .board import GONE_S, KEPT_S, MOST_REPLIES, Posted


class SqliteBoard:
    """See Board. name: of the class; a file may have several."""

    look_every = 0.25

    def __init__(self, folder: Path, name: str, clock: Callable[[], float] = time.time):
        self._name, self._clock, self._lock = name, clock, threading.Lock()
        path = folder / "classes.sqlite"
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        try:
            path.touch(0o600)
            self._file = open_file(path)
            run = self._file.execute
            run("PRAGMA synchronous = OFF")  # of no use after a power cut
            run("CREATE TABLE IF NOT EXISTS class (name TEXT PRIMARY KEY, number INTEGER, data BLOB, seen REAL)")
            of_class = "class TEXT REFERENCES class ON DELETE CASCADE"
            run(
                f"CREATE TABLE IF NOT EXISTS roster ({of_class}, process TEXT, data BLOB, seen REAL, "
                "PRIMARY KEY (class, process))"
            )
            run(
                f"CREATE TABLE IF NOT EXISTS reply ({of_class}, call TEXT, student TEXT, data BLOB, "
                "PRIMARY KEY (class, call, student))"
            )
        except sqlite3.Error as error:
            raise OSError(f"cannot keep a class in {path}: {error}") from None
        with self._transaction() as run:
            run("DELETE FROM class WHERE seen < ?", (self._clock() - KEPT_S,))
            run("INSERT OR IGNORE INTO class VALUES (?, 0, ?, ?)", (name, b"", self._clock()))

    def orders(self) -> Posted:
        with self._using() as run:
            found = run("SELECT number, data, seen FROM class WHERE name = ?", (self._name,)).fetchone()
        if found is None:
            raise OSError("the class was removed from the store")
        return Posted(found[0], found[1], self._age(found[2]))

    def order(self, number: int, data: bytes) -> bool:
        with self._transaction() as run:
            changed = run(
                "UPDATE class SET number = number + 1, data = ?, seen = ? WHERE name = ? AND number = ?",
                (data, self._clock(), self._name, number),
            )
            return changed.rowcount == 1

    def live(self, number: int) -> None:
        with self._transaction() as run:
            run("UPDATE class SET seen = ? WHERE name = ? AND number = ?", (self._clock(), self._name, number))

    def publish(self, process: str, data: bytes | None) -> None:
        now = self._clock()
        with self._transaction() as run:
            if data is None:
                run("UPDATE roster SET seen = ? WHERE class = ? AND process = ?", (now, self._name, process))
            else:
                run("INSERT OR REPLACE INTO roster VALUES (?, ?, ?, ?)", (self._name, process, data, now))

    def leave(self, process: str) -> None:
        with self._transaction() as run:
            run("DELETE FROM roster WHERE class = ? AND process = ?", (self._name, process))

    def rosters(self) -> list[bytes]:
        with self._using() as run:
            found = run("SELECT data, seen FROM roster WHERE class = ?", (self._name,)).fetchall()
        return [data for data, seen in found if self._age(seen) < GONE_S]

    def reply(self, call: str, replies: Mapping[str, bytes]) -> None:
        with self._transaction() as run:
            kept = {student for (student,) in self._replied(run, "student", call)}
            for student, data in replies.items():
                if student in kept or len(kept) < MOST_REPLIES:
                    kept.add(student)
                    run("INSERT OR REPLACE INTO reply VALUES (?, ?, ?, ?)", (self._name, call, student, data))

    def replies(self, call: str) -> dict[str, bytes]:
        with self._using() as run:
            return dict(self._replied(run, "student, data", call))

    def watch(self, changed: Callable[[], None]) -> None:
        pass

    def close(self) -> None:
        with self._lock:
            self._file.close()

    def _replied(self, run, what: str, call: str) -> list:
        return run(f"SELECT {what} FROM reply WHERE class = ? AND call = ?", (self._name, call)).fetchall()

    def _age(self, seen: float) -> float:
        """s; a clock that was set back makes nothing younger than new."""
        return abs(self._clock() - seen)

    @contextlib.contextmanager
    def _using(self) -> Iterator[Callable]:
        """Raises OSError."""
        with self._lock:
            try:
                yield self._file.execute
            except sqlite3.Error as error:
                raise OSError(f"the store of the class: {error}") from None

    @contextlib.contextmanager
    def _transaction(self) -> Iterator[Callable]:
        with self._using() as run, self._file:  # commits, or rolls back
            run("BEGIN IMMEDIATE")
            yield run
