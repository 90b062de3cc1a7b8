"""A store that hangs, fills up, refuses or is deleted costs a moment at most, and no session that can be read."""

import contextlib
import os
import secrets
import shutil
import signal
import sqlite3
import subprocess
import threading
import time

import pytest
from sessions_kept import BEGUN, kept_session
from viewimit.app.sessions.autosave import ANSWERS_WITHIN, STOPS_WITHIN, Autosave
from viewimit.app.sessions.saved import MOST_BYTES, MOST_UNPACKED
from viewimit.app.sessions.sqlite_store import SqliteStore
from viewimit.app.sessions.stores import open_store
from waiting import wait_until

SOON = 0.2  # s, in place of ANSWERS_WITHIN and STOPS_WITHIN
KEY, OTHER = "key", "other"


class Hanging:
    """A store that answers nothing while it hangs."""

    def __init__(self, folder):
        self.goes_on, self.store = threading.Event(), SqliteStore(folder)
        self.goes_on.set()

    def __getattr__(self, name):
        return lambda *asked: (self.goes_on.wait(20), getattr(self.store, name)(*asked))[1]


@pytest.fixture(scope="module")
def kept():
    return kept_session(motions=5)


@pytest.fixture
def hanging(tmp_path):
    store = Hanging(tmp_path)
    yield store
    store.goes_on.set()


@contextlib.contextmanager
def within(seconds):
    began = time.monotonic()
    yield
    assert time.monotonic() - began < seconds


def test_what_a_person_waits_for_is_bounded():
    assert ANSWERS_WITHIN <= 2 and STOPS_WITHIN + 2 <= 10  # the scheduler takes up to 2 s to end


def test_a_store_that_hangs_holds_up_neither_visitor_nor_stop(hanging, kept):
    autosave = Autosave(hanging, within=SOON)
    autosave.claim(KEY, BEGUN)
    hanging.goes_on.clear()
    with within(5):
        assert autosave.claim(OTHER, BEGUN) is None
        assert "cannot be read now" in autosave.lost(OTHER)
        for _ in range(10):
            autosave.keep(KEY, kept)
            autosave.forget(KEY)
        assert not autosave.flush(KEY)
        autosave.stop(SOON)


def test_what_waits_to_be_written_is_gone_on_with(hanging, kept):
    autosave = Autosave(hanging, within=SOON)
    autosave.claim(KEY, BEGUN), autosave.claim(OTHER, BEGUN)
    hanging.goes_on.clear()
    autosave.keep(OTHER, kept)  # keeps the writing busy
    autosave.keep(KEY, kept)
    autosave.forget(KEY)
    assert autosave.claim(KEY, BEGUN) is kept
    hanging.goes_on.set()
    autosave.keep(KEY, kept)
    wait_until(lambda: hanging.names(KEY))
    autosave.stop()


def test_what_could_not_be_read_is_not_written_over(hanging, kept):
    hanging.save(KEY, "before", {"head": b"what was left"})
    autosave = Autosave(hanging, within=SOON)
    hanging.goes_on.clear()
    for key in (KEY, OTHER):
        assert autosave.claim(key, BEGUN) is None
    hanging.goes_on.set()
    for key in (KEY, OTHER):
        autosave.keep(key, kept)
        wait_until(lambda key=key: autosave.flush(key))
    assert "reload the page" in autosave.problem(KEY) and hanging.read(KEY) == {"head": b"what was left"}
    assert autosave.problem(OTHER) is None and "head" in hanging.names(OTHER)
    autosave.stop()


def test_a_redis_that_hangs_is_given_up(tmp_path, kept):
    pytest.importorskip("redis")
    from viewimit.app.sessions.redis_store import TIMEOUT_S, RedisStore

    assert TIMEOUT_S < ANSWERS_WITHIN
    program = shutil.which("redis-server") or pytest.skip("no redis-server")
    socket = tmp_path / "redis.sock"
    command = [program, "--port", "0", "--unixsocket", str(socket), "--save", "", "--dir", str(tmp_path)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    try:
        wait_until(socket.exists)
        store = RedisStore(f"unix://{socket}", timeout_s=SOON)
        autosave = Autosave(store)
        autosave.claim(KEY, BEGUN)
        os.kill(process.pid, signal.SIGSTOP)
        with within(ANSWERS_WITHIN + 0.5):
            assert autosave.claim(OTHER, BEGUN) is None
        autosave.keep(KEY, kept)
        wait_until(lambda: autosave.problem(KEY))
        assert "the Redis did not answer" in autosave.problem(KEY)
        for k in range(40):
            autosave.keep(str(k), kept)
        with within(SOON + 1):
            autosave.stop(SOON)
        with within(1.0), pytest.raises(OSError, match="did not answer"):
            store.names(KEY)
    finally:
        process.kill()
        process.wait(10)


def test_a_file_that_somebody_else_writes_is_read(tmp_path, kept):
    before, autosave = (Autosave(SqliteStore(tmp_path)) for _ in range(2))
    before.claim(KEY, BEGUN)
    before.keep(KEY, kept)
    before.stop()
    with contextlib.closing(sqlite3.connect(tmp_path / "sessions.sqlite", isolation_level=None)) as file:
        file.execute("BEGIN IMMEDIATE")
        with within(ANSWERS_WITHIN + 0.5):
            assert autosave.claim(KEY, BEGUN).head == kept.head
        autosave.keep(KEY, kept_session(motions=6))
        wait_until(lambda: autosave.problem(KEY))
        file.execute("ROLLBACK")
    later = kept_session(motions=7)
    autosave.keep(KEY, later)
    autosave.flush(KEY)
    assert autosave.problem(KEY) is None and autosave.claim(KEY, BEGUN).head == later.head
    autosave.stop()


def test_a_full_redis_is_read(redis_url, kept):
    import redis

    before, autosave = (Autosave(open_store(redis_url)) for _ in range(2))
    before.claim(KEY, BEGUN)
    before.keep(KEY, kept)
    before.stop()
    with redis.Redis.from_url(redis_url) as there:
        there.config_set("maxmemory", 1)
        try:
            assert autosave.claim(KEY, BEGUN).head == kept.head
            autosave.keep(KEY, kept_session(motions=6))
            wait_until(lambda: "the Redis refused" in (autosave.problem(KEY) or ""))
        finally:
            there.config_set("maxmemory", 0)
    autosave.keep(KEY, kept_session(motions=7))
    autosave.flush(KEY)
    assert autosave.problem(KEY) is None
    autosave.stop()


def test_a_file_that_was_deleted_is_written_anew(tmp_path, kept):
    autosave = Autosave(SqliteStore(tmp_path / "state"))
    autosave.claim(KEY, BEGUN)
    autosave.keep(KEY, kept)
    autosave.flush(KEY)
    shutil.rmtree(tmp_path / "state")
    autosave.keep(KEY, kept)  # in which nothing is new
    autosave.flush(KEY)
    assert autosave.problem(KEY) is None
    again = Autosave(SqliteStore(tmp_path / "state"))
    assert again.claim(KEY, BEGUN).head == kept.head
    for each in (autosave, again):
        each.stop()


def test_while_a_file_cannot_be_opened_anew_it_is_not_said_to_be_and_then_all_goes_on(tmp_path, caplog):
    """A folder in its place, and then the file itself again."""
    store, file, aside = SqliteStore(tmp_path), tmp_path / "sessions.sqlite", tmp_path / "aside"
    assert store.save(KEY, "a", {"0": b"kept"})
    for name in ("sessions.sqlite-wal", "sessions.sqlite-shm"):
        (tmp_path / name).unlink(missing_ok=True)
    file.rename(aside)
    file.mkdir()
    for _ in range(3):
        with pytest.raises(OSError, match="cannot keep sessions in"):
            store.save(KEY, "a", {"0": b"lost"})
    assert "written anew" not in caplog.text
    file.rmdir()
    aside.rename(file)
    assert store.save(KEY, "a", {"1": b"more"})
    assert caplog.text.count("written anew") == 1


LARGE, PART = 1 << 20, 200 << 10  # bytes


def test_the_oldest_of_a_file_make_room(tmp_path):
    now = [0.0]
    store = SqliteStore(tmp_path, clock=lambda: now[0], most_bytes=LARGE)
    for k in range(12):
        now[0] = k
        assert store.save(f"session {k}", "a", {"0": bytes(PART)})
        store.renew({"session 0": "a"})
    there = [k for k in range(12) if store.names(f"session {k}")]
    assert there == [0, 8, 9, 10, 11]  # as many as fit
    store.close()
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) < 8 * LARGE


def emptied(redis_url):
    """A connection to it."""
    import redis

    there = redis.Redis.from_url(redis_url)
    there.flushall()
    return there


def test_the_oldest_of_a_redis_make_room(redis_url):
    from viewimit.app.sessions.redis_store import RedisStore

    there, store = emptied(redis_url), RedisStore(redis_url, most_bytes=LARGE)
    for k in range(12):
        assert store.save(f"session {k}", "a", {"0": secrets.token_bytes(PART)})
        there.expire(f"viewimit:session {k}", 1_000 + k)  # as if seconds had passed
    assert [k for k in range(12) if store.names(f"session {k}")] == [8, 9, 10, 11]
    store.close()


def test_a_redis_that_others_fill_is_looked_at_before_long(redis_url):
    from viewimit.app.sessions.redis_store import LOOKED_AT_AFTER_S, RedisStore

    now, whole = [0.0], emptied(redis_url)
    own = RedisStore(redis_url, most_bytes=LARGE, clock=lambda: now[0])
    assert own.save("own", "a", {"0": b"little"})
    with whole.pipeline() as others:
        for k in range(12):
            others.hset(f"viewimit:other {k}", "part:0", secrets.token_bytes(PART))
            others.expire(f"viewimit:other {k}", 1_000 + k)
        others.execute()
    there = lambda: [k for k in range(12) if own.names(f"other {k}")]
    assert own.save("own", "a", {"0": b"little"}) and there() == list(range(12))
    now[0] += LOOKED_AT_AFTER_S
    assert own.save("own", "a", {"0": b"little"}) and there() == [8, 9, 10, 11]
    own.close()


def test_a_session_that_made_room_is_written_whole(tmp_path, kept):
    store = SqliteStore(tmp_path, most_bytes=LARGE)
    autosave = Autosave(store)
    autosave.claim(KEY, BEGUN)
    autosave.keep(KEY, kept)
    autosave.flush(KEY)
    store.save("another", "a", {"0": bytes(LARGE)})
    assert not store.names(KEY)
    autosave.keep(KEY, kept_session(motions=7))
    autosave.flush(KEY)
    assert autosave.claim(KEY, BEGUN).head.length == 8
    autosave.stop()


def test_a_session_has_a_size(tmp_path, kept):
    assert MOST_BYTES < MOST_UNPACKED
    autosave = Autosave(SqliteStore(tmp_path), most_bytes=1_000)
    autosave.claim(KEY, BEGUN)
    autosave.keep(KEY, kept)
    autosave.flush(KEY)
    assert "it takes more than" in autosave.problem(KEY)
    autosave.stop()
