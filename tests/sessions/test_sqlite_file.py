"""A new file that two processes of a server begin with at once."""

import contextlib
import sqlite3

import pytest
from viewimit.app.sessions import sqlite_file
from viewimit.app.sessions.sqlite_store import SqliteStore


def test_who_begins_with_it_just_then_is_waited_for(tmp_path, monkeypatch):
    with contextlib.closing(sqlite3.connect(tmp_path / "sessions.sqlite", isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        monkeypatch.setattr(sqlite_file.time, "sleep", lambda _: other.execute("COMMIT"))
        SqliteStore(tmp_path).close()


def test_it_is_not_waited_for_long(tmp_path, monkeypatch):
    monkeypatch.setattr(sqlite_file, "LOCKED_S", 0.1)
    with contextlib.closing(sqlite3.connect(tmp_path / "sessions.sqlite", isolation_level=None)) as other:
        other.execute("BEGIN IMMEDIATE")
        with pytest.raises(OSError, match="database is locked"):
            SqliteStore(tmp_path)
