"""Sessions in one SQLite file of this user's, shared by the processes of a server."""

import contextlib
import sqlite3
import threading
import time
from collections.abc import Iterable, Mapping
from pathlib import Path

from .store import KEPT_S, LEASE_S


class SqliteStore:
    """One file, sessions.sqlite, which only its user may read."""

    def __init__(self, folder: Path, clock=time.time):
        self._clock, self._lock = clock, threading.Lock()
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        path = folder / "sessions.sqlite"
        try:
            path.touch(0o600)
            self._file = sqlite3.connect(path, timeout=5.0, isolation_level=None, check_same_thread=False)
            self._file.execute("PRAGMA journal_mode = WAL")
            self._file.execute("PRAGMA synchronous = NORMAL")
            self._file.execute("PRAGMA foreign_keys = ON")
            self._file.execute("CREATE TABLE IF NOT EXISTS session (key TEXT PRIMARY KEY, writer TEXT, seen REAL)")
            self._file.execute(
                "CREATE TABLE IF NOT EXISTS lease (key TEXT REFERENCES session ON DELETE CASCADE, until REAL, "
                "PRIMARY KEY (key)) WITHOUT ROWID"
            )
            self._file.execute(
                "CREATE TABLE IF NOT EXISTS part (key TEXT REFERENCES session ON DELETE CASCADE, name TEXT, data BLOB, "
                "PRIMARY KEY (key, name)) WITHOUT ROWID"
            )
        except sqlite3.Error as error:
            raise OSError(f"cannot keep sessions in {path}: {error}") from None
        self.renew({})

    def claim(self, key: str, writer: str) -> dict[str, bytes] | None:
        with self._transaction() as run:
            self._remove_old(run)
            if self._left(run, key):
                return None
            now = self._clock()
            run("INSERT OR IGNORE INTO session VALUES (?, ?, ?)", (key, writer, now))
            run("UPDATE session SET writer = ?, seen = ? WHERE key = ?", (writer, now, key))
            run("INSERT OR REPLACE INTO lease VALUES (?, ?)", (key, now + LEASE_S))
            return dict(run("SELECT name, data FROM part WHERE key = ?", (key,)).fetchall())

    def held(self, keys: Iterable[str]) -> dict[str, float]:
        with self._transaction() as run:
            return {key: left for key in keys if (left := self._left(run, key))}

    def renew(self, leases: Mapping[str, str]) -> set[str]:
        lost = set()
        with self._transaction() as run:
            now = self._clock()
            for key, writer in leases.items():
                mine = run("UPDATE session SET seen = ? WHERE key = ? AND writer = ?", (now, key, writer))
                if mine.rowcount == 0:
                    lost.add(key)
                else:
                    run("INSERT OR REPLACE INTO lease VALUES (?, ?)", (key, now + LEASE_S))
            self._remove_old(run)
        return lost

    def save(self, key: str, writer: str, parts: dict[str, bytes], gone: Iterable[str] = ()) -> bool:
        with self._transaction() as run:
            run("INSERT OR IGNORE INTO session VALUES (?, ?, ?)", (key, writer, self._clock()))
            mine = run("UPDATE session SET seen = ? WHERE key = ? AND writer = ?", (self._clock(), key, writer))
            if mine.rowcount == 0:
                return False
            for name in gone:
                run("DELETE FROM part WHERE key = ? AND name = ?", (key, name))
            for name, data in parts.items():
                run("INSERT OR REPLACE INTO part VALUES (?, ?, ?)", (key, name, data))
            return True

    def release(self, key: str, writer: str) -> None:
        with self._transaction() as run:
            mine = run("UPDATE session SET writer = NULL WHERE key = ? AND writer = ?", (key, writer))
            if mine.rowcount:
                run("DELETE FROM lease WHERE key = ?", (key,))

    def close(self) -> None:
        with self._lock:
            self._file.close()

    def _left(self, run, key: str) -> float:
        """s for which it is leased yet, 0 if it is not."""
        found = run("SELECT until FROM lease WHERE key = ?", (key,)).fetchone()
        left = 0.0 if found is None else found[0] - self._clock()
        return left if 0 < left <= LEASE_S else 0.0  # more can only be if the clock has been set back

    def _remove_old(self, run) -> None:
        run("DELETE FROM session WHERE seen < ?", (self._clock() - KEPT_S,))

    @contextlib.contextmanager
    def _transaction(self):
        """All or nothing. Raises OSError."""
        with self._lock:
            try:
                with self._file:  # commits, or rolls back
                    self._file.execute("BEGIN IMMEDIATE")
                    yield self._file.execute
            except sqlite3.Error as error:
                raise OSError(f"the store of sessions: {error}") from None
