"""Where sessions are kept: the same theorems for the file and for a Redis."""

import contextlib
import os
import sqlite3
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from viewimit.app.sessions import sqlite_store
from viewimit.app.sessions.sqlite_store import SqliteStore
from viewimit.app.sessions.store import KEPT_S, LEASE_S
from viewimit.app.sessions.stores import open_store, state_folder
from waiting import stays, wait_until

SHORT_S = 0.2  # in place of LEASE_S


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


@pytest.fixture
def two_processes(where):
    with contextlib.closing(open_store(where)) as here, contextlib.closing(open_store(where)) as there:
        yield here, there


@pytest.fixture
def short_leases(monkeypatch):
    monkeypatch.setattr(sqlite_store, "LEASE_S", SHORT_S)
    monkeypatch.setattr("viewimit.app.sessions.redis_store.LEASE_MS", round(1000 * SHORT_S))


def parts_of(store, key):
    """What is there, for whoever claims it."""
    found = store.claim(key, "a reader")
    store.release(key, "a reader")
    return found


def test_what_was_saved_is_there(store, key):
    assert store.claim(key, "a") == {}
    assert store.save(key, "a", {"head": b"\x00\xff", "0": b"x" * 100_000})
    assert store.save(key, "a", {"0": b"y", "1": b"z"})
    store.release(key, "a")
    assert store.claim(key, "b") == {"head": b"\x00\xff", "0": b"y", "1": b"z"}
    assert store.claim(f"{key} of another", "b") == {}


def test_parts_can_go(store, key):
    store.save(key, "a", {"0": b"0", "1": b"1", "2": b"2"})
    store.save(key, "a", {"0": b"new"}, gone=["1", "2", "3"])
    assert parts_of(store, key) == {"0": b"new"}


def test_a_session_is_leased_to_one_until_it_is_given_back(two_processes, key):
    here, there = two_processes
    assert here.claim(key, "one") == {}
    assert there.claim(key, "two") is None and here.claim(key, "three") is None
    assert set(there.held([key, f"{key} of another"])) == {key} and 0 < there.held([key])[key] <= LEASE_S
    assert here.save(key, "one", {"0": b"one"}) and not there.save(key, "two", {"0": b"two"})
    there.release(key, "two")  # which is not its to give
    assert there.claim(key, "two") is None
    here.release(key, "one")
    assert there.held([key]) == {} and there.claim(key, "two") == {"0": b"one"}
    assert not here.save(key, "one", {"0": b"late"}) and here.renew({key: "one"}) == {key}
    here.release(key, "one")
    assert there.renew({key: "two"}) == set() and here.claim(key, "one") is None


def test_of_many_who_claim_a_session_at_once_one_gets_it(where, key):
    stores = [open_store(where) for _ in range(4)]
    begin = threading.Barrier(len(stores))

    def claim(turn, k):
        begin.wait()
        return stores[k].claim(f"{key}{turn}", str(k))

    with ThreadPoolExecutor(len(stores)) as pool:
        for turn in range(10):
            claimed = list(pool.map(claim, [turn] * len(stores), range(len(stores))))
            assert claimed.count({}) == 1 and claimed.count(None) == 3
    for store in stores:
        store.close()


def test_a_lease_that_nobody_renews_comes_free_and_its_holder_writes_no_more(two_processes, key, short_leases):
    here, there = two_processes
    here.claim(key, "silent")
    here.save(key, "silent", {"0": b"before"})
    wait_until(lambda: there.claim(key, "next") == {"0": b"before"})
    assert not here.save(key, "silent", {"0": b"after"}) and here.renew({key: "silent"}) == {key}
    assert there.save(key, "next", {"0": b"next"})


def test_a_lease_that_is_renewed_does_not_end_and_one_that_nobody_has_taken_goes_on(two_processes, key, short_leases):
    here, there = two_processes
    here.claim(key, "a")

    def is_renewed():
        began = time.monotonic()
        assert here.renew({key: "a"}) == set()
        if there.claim(key, "b") is None:
            return True
        there.release(key, "b")  # this process was held up for longer than a lease lasts
        assert here.claim(key, "a") == {}
        return time.monotonic() - began >= SHORT_S

    stays(is_renewed, 2.5 * SHORT_S)
    wait_until(lambda: not there.held([key]))
    assert is_renewed()


def test_a_renewal_shows_in_the_time_that_is_left(two_processes, key):
    here, there = two_processes
    here.claim(key, "a")
    first = there.held([key])[key]
    wait_until(lambda: there.held([key])[key] < first - 0.01)
    second = there.held([key])[key]

    def shows():
        here.renew({key: "a"})
        return there.held([key])[key] > second  # which without a renewal it never is again

    wait_until(shows)


def test_a_clock_that_is_set_back_does_not_prolong_a_lease(tmp_path):
    now = [1e6]
    store = SqliteStore(tmp_path, clock=lambda: now[0])
    store.claim("key", "a")
    now[0] -= 3600
    assert store.held(["key"]) == {} and store.claim("key", "b") == {}
    store.close()


def test_a_file_of_the_version_before_is_read(tmp_path):
    with contextlib.closing(sqlite3.connect(tmp_path / "sessions.sqlite")) as file:
        file.execute("CREATE TABLE session (key TEXT PRIMARY KEY, writer TEXT, seen REAL)")
        file.execute("CREATE TABLE part (key TEXT REFERENCES session ON DELETE CASCADE, name TEXT, data BLOB, "
                     "PRIMARY KEY (key, name)) WITHOUT ROWID")  # fmt: skip
        file.execute("INSERT INTO session VALUES ('key', 'old', ?)", (time.time(),))
        file.execute("INSERT INTO part VALUES ('key', 'head', x'ff')")
        file.commit()
    with contextlib.closing(SqliteStore(tmp_path)) as store:
        assert store.claim("key", "a") == {"head": b"\xff"} and store.claim("key", "b") is None


def test_a_file_forgets_what_gave_no_sign_of_life(tmp_path):
    now = [0.0]
    store = SqliteStore(tmp_path, clock=lambda: now[0])
    for key in ("left", "open"):
        store.save(key, "a", {"0": b"x"})
    now[0] = KEPT_S - 1
    assert store.renew({"open": "a"}) == set()
    assert parts_of(store, "left")  # which is a sign of life
    now[0] = KEPT_S + 1
    store.save("left alone", "a", {"0": b"x"})
    now[0] = 2 * KEPT_S
    assert parts_of(store, "open") == {} and parts_of(store, "left") == {} and parts_of(store, "left alone")
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


def test_an_address_that_no_store_has_is_no_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError, match="^reddis:// is no address of a store: .* redis://") as refused:
        open_store("reddis://:secret@here:6379")
    assert "secret" not in str(refused.value) and not list(tmp_path.iterdir())


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
