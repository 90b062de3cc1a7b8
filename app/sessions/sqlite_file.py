"""An SQLite file that several processes of a server write."""

import sqlite3
import time
from pathlib import Path

LOCKED_S = 0.5  # that another process may hold the file
LOOK_AGAIN = 0.01  # s


def open_file(path: Path) -> sqlite3.Connection:
    """Of any thread, with a log of what is written ahead of it. Raises sqlite3.Error."""
    file = sqlite3.connect(path, timeout=LOCKED_S, isolation_level=None, check_same_thread=False)
    _write_ahead(file, time.monotonic() + LOCKED_S)
    file.execute("PRAGMA foreign_keys = ON")
    return file


def _write_ahead(file: sqlite3.Connection, until: float) -> None:
    """SQLite waits for nobody here: of two processes that begin with a new file at once, one would fail."""
    while True:
        try:
            file.execute("PRAGMA journal_mode = WAL")
            return
        except sqlite3.OperationalError as error:
            if "locked" not in str(error) or time.monotonic() > until:
                raise
            time.sleep(LOOK_AGAIN)
