"""Sessions in one SQLite file of this user's, shared by the processes of a server."""

import contextlib
import sqlite3
import threading
import time
from collections.abc import Iterable
from pathlib import Path

from .store import KEPT_S


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
                "CREATE TABLE IF NOT EXISTS part (key TEXT REFERENCES session ON DELETE CASCADE, name TEXT, data BLOB, "
                "PRIMARY KEY (key, name)) WITHOUT ROWID"
            )
        except sqlite3.Error as error:
            raise OSError(f"cannot keep sessions in {path}: {error}") from None
        self.touch(())

    def claim(self, key: str, writer: str) -> dict[str, bytes]:
        with self._transaction() as run:
            self._remove_old(run)
            run("UPDATE session SET writer = ?, seen = ? WHERE key = ?", (writer, self._clock(), key))
            return dict(run("SELECT name, data FROM part WHERE key = ?", (key,)).fetchall())

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

    def touch(self, keys: Iterable[str]) -> None:
        with self._transaction() as run:
            for key in keys:
                run("UPDATE session SET seen = ? WHERE key = ?", (self._clock(), key))
            self._remove_old(run)

    def close(self) -> None:
        with self._lock:
            self._file.close()

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
