"""Where sessions are kept: the same theorems for the file and for a Redis."""

import contextlib
import os
import sqlite3
import sys
import time

import pytest
from viewimit.app.sessions.sqlite_store import SqliteStore
from viewimit.app.sessions.store import KEPT_S
from viewimit.app.sessions.stores import open_store, state_folder


@pytest.fixture(params=["file", "redis"])
def where(request, tmp_path):
    return str(tmp_path) if request.param == "file" else request.getfixturevalue("redis_url")


@pytest.fixture
def store(where):
    with contextlib.closing(open_store(where)) as store:
        yield store


@pytest.fixture
def key(request):
    return request.node.name


def test_what_was_saved_is_there(store, key):
    assert store.claim(key, "a") == {}
    assert store.save(key, "a", {"head": b"\x00\xff", "0": b"x" * 100_000})
    assert store.save(key, "a", {"0": b"y", "1": b"z"})
    assert store.claim(key, "b") == {"head": b"\x00\xff", "0": b"y", "1": b"z"}
    assert store.claim(f"{key} of another", "b") == {}


def test_parts_can_go(store, key):
    store.save(key, "a", {"0": b"0", "1": b"1", "2": b"2"})
    store.save(key, "a", {"0": b"new"}, gone=["1", "2", "3"])
    assert store.claim(key, "a") == {"0": b"new"}


def test_the_last_who_claimed_it_writes_alone(where, key):
    with contextlib.closing(open_store(where)) as here, contextlib.closing(open_store(where)) as there:
        here.claim(key, "old")
        assert here.save(key, "old", {"0": b"old"})
        assert there.claim(key, "new") == {"0": b"old"}
        assert there.save(key, "new", {"0": b"new"})
        assert not here.save(key, "old", {"0": b"late"})
        assert there.claim(key, "newer") == {"0": b"new"}


def test_a_file_forgets_what_gave_no_sign_of_life(tmp_path):
    now = [0.0]
    store = SqliteStore(tmp_path, clock=lambda: now[0])
    for key in ("left", "open"):
        store.save(key, "a", {"0": b"x"})
    now[0] = KEPT_S - 1
    store.touch(["open"])
    assert store.claim("left", "a")  # which is a sign of life
    now[0] = KEPT_S + 1
    store.save("left alone", "a", {"0": b"x"})
    now[0] = 2 * KEPT_S
    assert store.claim("open", "a") == {} and store.claim("left", "a") == {} and store.claim("left alone", "a")
    store.close()
    SqliteStore(tmp_path, clock=lambda: now[0]).close()
    with contextlib.closing(sqlite3.connect(tmp_path / "sessions.sqlite")) as file:
        assert file.execute("SELECT count(*) FROM part").fetchone() == (1,)


def test_a_redis_forgets_too(redis_url):
    import redis

    with contextlib.closing(open_store(redis_url)) as store:
        store.save("left", "a", {"0": b"x"})
        assert KEPT_S - 5 < redis.Redis.from_url(redis_url).ttl("viewimit:left") <= KEPT_S


@pytest.mark.skipif(os.name != "posix", reason="permissions of a POSIX file")
def test_only_its_user_reads_the_file(tmp_path):
    SqliteStore(tmp_path / "state").close()
    assert (tmp_path / "state").stat().st_mode & 0o077 == 0
    assert (tmp_path / "state" / "sessions.sqlite").stat().st_mode & 0o077 == 0


def test_a_store_that_cannot_be_used_is_said(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError):
        open_store(str(tmp_path / "file"))
    (tmp_path / "sessions.sqlite").write_bytes(b"no database" * 100)
    with pytest.raises(OSError, match="cannot keep sessions in .*: file is not a database"):
        open_store(str(tmp_path))


def test_a_redis_that_is_not_there_is_said(tmp_path):
    pytest.importorskip("redis")
    began = time.monotonic()
    with pytest.raises(OSError, match="cannot reach the Redis"):
        open_store(f"unix://{tmp_path}/nobody.sock")
    assert time.monotonic() - began < 10


@pytest.mark.skipif(sys.platform != "linux", reason="folders of Linux")
def test_without_a_place_it_is_the_users_own_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    assert state_folder() == tmp_path / "state/viewimit"
    monkeypatch.delenv("XDG_STATE_HOME")
    assert state_folder() == tmp_path / ".local/state/viewimit"
    open_store(None).close()
    assert any((tmp_path / ".local/state/viewimit").iterdir())
