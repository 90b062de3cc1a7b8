"""Sessions in one SQLite file of this user's, shared by the processes of a server."""

import contextlib
import logging
import sqlite3
import threading
import time
from collections.abc import Iterable, Mapping
from pathlib import Path

from .sqlite_file import open_file
from .store import KEPT_S, LEASE_S, MOST_BYTES

log = logging.getLogger(__name__)


class SqliteStore:
    """One file, sessions.sqlite, which only its user may read. most_bytes: of all sessions in it."""

    def __init__(self, folder: Path, clock=time.time, most_bytes: int = MOST_BYTES):
        self._clock, self._lock, self._most_bytes = clock, threading.Lock(), most_bytes
        self._path = folder / "sessions.sqlite"
        self._open()
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
            return self._parts(run, key)

    def held(self, keys: Iterable[str]) -> dict[str, float]:
        with self._using() as run:
            return {key: left for key in keys if (left := self._left(run, key))}

    def renew(self, leases: Mapping[str, str]) -> set[str]:
        lost = set()
        with self._transaction() as run:
            now = self._clock()
            for key, writer in leases.items():
                run("INSERT OR IGNORE INTO session VALUES (?, ?, ?)", (key, writer, now))  # it may have been removed
                mine = run("UPDATE session SET seen = ? WHERE key = ? AND writer = ?", (now, key, writer))
                if mine.rowcount == 0:
                    lost.add(key)
                else:
                    run("INSERT OR REPLACE INTO lease VALUES (?, ?)", (key, now + LEASE_S))
            self._remove_old(run)
        return lost

    def read(self, key: str) -> dict[str, bytes]:
        with self._using() as run:
            return self._parts(run, key)

    def names(self, key: str) -> set[str]:
        with self._using() as run:
            return {name for (name,) in run("SELECT name FROM part WHERE key = ?", (key,))}

    def set_aside(self, key: str) -> None:
        aside = f"aside {key}"
        with self._transaction() as run:
            run("DELETE FROM session WHERE key = ?", (aside,))
            run("INSERT INTO session SELECT ?, '', seen FROM session WHERE key = ?", (aside, key))
            run("UPDATE part SET key = ? WHERE key = ?", (aside, key))

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
            self._make_room(run, key)
            return True

    def release(self, key: str, writer: str) -> None:
        with self._transaction() as run:
            mine = run("UPDATE session SET writer = NULL WHERE key = ? AND writer = ?", (key, writer))
            if mine.rowcount:
                run("DELETE FROM lease WHERE key = ?", (key,))

    def close(self) -> None:
        with self._lock:
            self._file.close()

    def _open(self) -> None:
        """Raises OSError."""
        path = self._path
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        try:
            path.touch(0o600)
            inode = path.stat().st_ino
            self._file = open_file(path)
            self._file.execute("PRAGMA synchronous = NORMAL")
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
        self._inode = inode

    def _open_again_if_deleted(self) -> None:
        """What is written into a file without a name is lost with its last process."""
        with contextlib.suppress(FileNotFoundError):
            if self._path.stat().st_ino == self._inode:
                return
        self._file.close()
        self._inode = -1  # of no file, should it not open
        self._open()
        log.warning("%s was deleted; sessions are written anew", self._path)

    def _left(self, run, key: str) -> float:
        """s for which it is leased yet, 0 if it is not."""
        found = run("SELECT until FROM lease WHERE key = ?", (key,)).fetchone()
        left = 0.0 if found is None else found[0] - self._clock()
        return left if 0 < left <= LEASE_S else 0.0  # more can only be if the clock has been set back

    @staticmethod
    def _parts(run, key: str) -> dict[str, bytes]:
        return dict(run("SELECT name, data FROM part WHERE key = ?", (key,)).fetchall())

    def _make_room(self, run, key: str) -> None:
        """Remove the oldest of the other sessions until those that are left are not too large."""
        number = lambda name: run(f"PRAGMA {name}").fetchone()[0]
        while (number("page_count") - number("freelist_count")) * number("page_size") > self._most_bytes:
            oldest = run("SELECT key FROM session WHERE key != ? ORDER BY seen LIMIT 1", (key,)).fetchone()
            if oldest is None:
                break
            run("DELETE FROM session WHERE key = ?", oldest)

    def _remove_old(self, run) -> None:
        run("DELETE FROM session WHERE seen < ?", (self._clock() - KEPT_S,))

    @contextlib.contextmanager
    def _using(self):
        """Raises OSError."""
        with self._lock:
            try:
                self._open_again_if_deleted()
                yield self._file.execute
            except sqlite3.Error as error:
                raise OSError(f"the store of sessions: {error}") from None

    @contextlib.contextmanager
    def _transaction(self):
        """All or nothing. Raises OSError."""
        with self._using() as run, self._file:  # commits, or rolls back
            run("BEGIN IMMEDIATE")
            yield run
