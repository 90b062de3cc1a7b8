"""A store may hold anything: what no page has written is refused before use, set aside, and told."""

import contextlib
import sqlite3
import threading
from typing import Any, TypeVar

import msgspec
import numpy as np
import pytest
import zstandard
from protocol import Client
from quiet_page import QuietPage
from serving import Here, browser_of, kept_of
from sessions_kept import BEGUN, kept_session
from typing_extensions import TypeAliasType
from viewimit.app.page.page import CannotResume
from viewimit.app.sessions import codec, saved
from viewimit.app.sessions.autosave import Autosave
from viewimit.app.sessions.kinds import fits
from viewimit.app.sessions.saved import HEAD, SavedSession
from viewimit.app.sessions.sqlite_store import SqliteStore
from viewimit.app.sessions.stores import open_store
from waiting import wait_until

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

KEY = "key"
TOO_LARGE = bytes(codec.MOST_BYTES + 1)


@pytest.fixture(scope="module")
def kept() -> SavedSession:
    return kept_session(motions=5)


@pytest.fixture
def parts(kept) -> dict[str, bytes]:
    return {HEAD: msgspec.msgpack.encode(kept.head), "0": codec.encode(kept.history)}


def changed_head(parts, **fields) -> dict[str, bytes]:
    return {**parts, HEAD: msgspec.msgpack.encode({**msgspec.msgpack.decode(parts[HEAD]), **fields})}


def changed_moments(parts, change) -> dict[str, bytes]:
    """change(listed): objects as the codec lists them."""
    listed, values = msgspec.msgpack.decode(codec.unpacked(parts["0"]))
    change(listed)
    return {**parts, "0": zstandard.compress(msgspec.msgpack.encode((listed, values)))}


def of_kind(listed, kind):
    """The first object of a kind, as a dictionary that may be changed."""
    return next(content[0] for name, *content in listed if name == kind)


def other_field(kind, name, value):
    return lambda listed: of_kind(listed, kind).update({name: value})


def other_array(kind, name, value):
    """In place of the array that is there, so that the order of objects stays."""

    def change(listed):
        (place,) = of_kind(listed, kind)[name]
        listed[place] = ["array", value.dtype.str, value.shape, value.tobytes()]

    return change


def test_a_record_that_is_whole_is_gone_on_with(parts, kept):
    assert saved.decoded(parts, BEGUN).head == kept.head


@pytest.mark.parametrize("streamed", [False, True])
def test_no_more_is_unpacked_than_a_part_may_take(streamed):
    packing = zstandard.ZstdCompressor().compressobj()
    data = packing.compress(TOO_LARGE) + packing.flush() if streamed else zstandard.compress(TOO_LARGE)
    assert len(data) < 2_000
    with pytest.raises(ValueError, match="unpacks to more than"):
        codec.decode(data)


def test_all_parts_together_have_a_limit(parts):
    size = len(codec.unpacked(parts["0"]))
    assert saved.decoded(parts, BEGUN, unpacked=size) is not None
    with pytest.raises(ValueError, match="unpacks to more than"):
        saved.decoded(parts, BEGUN, unpacked=size - 1)


@pytest.mark.parametrize(
    "fields",
    [
        {"length": 2**62},
        {"length": 0},
        {"cursor": -1},
        {"cursor": 2**62},
        {"cursor": 6},
        {"length": 3},
        {"speed": float("nan")},
        {"speed": float("inf")},
        {"speed": -1.0},
        {"chosen": -5},
        {"chosen": "all"},
        {"show": {"rays": "yes"}},
        {"motion": 5},
        {"more": 1},
    ],
    ids=str,
)
def test_a_head_that_no_page_has_is_refused(parts, fields):
    assert saved.decoded(changed_head(parts, cursor=2), BEGUN).head.cursor == 2
    with pytest.raises(ValueError):
        saved.decoded(changed_head(parts, **fields), BEGUN)


@pytest.mark.parametrize(
    "change",
    [
        other_field("Snapshot", "motion", "three"),
        other_field("Snapshot", "motion", True),
        other_field("Snapshot", "motion", 9),
        other_field("Snapshot", "status", 3),
        other_field("Snapshot", "E", None),
        other_field("Snapshot", "theta", 1.0),
        other_field("Snapshot", "views", None),
        other_field("Snapshot", "settings", None),
        other_field("Snapshot", "lag", "late"),
        other_field("Snapshot", "look_again", 1),
        other_field("Snapshot", "servo_state", 5),
        other_field("TrustRegionState", "visits", None),
        other_field("Region", "radius", "wide"),
        other_array("Snapshot", "theta", np.zeros(3)),
        other_array("Snapshot", "theta", np.array([np.nan, 0])),
        other_array("Snapshot", "commanded", np.zeros((2, 2))),
        other_field("Snapshot", "target", 1.0),
        other_array("FourViews", "demo", np.zeros((3, 4))),
        other_array("FourViews", "own", np.zeros(4)),
        other_array("FourViews", "visible", np.ones((10, 4))),
    ],
)
def test_moments_that_no_session_has_are_refused(parts, change):
    with pytest.raises(ValueError):
        saved.decoded(changed_moments(parts, change), BEGUN)


@pytest.mark.parametrize("name", ["transfer", "servo"])
def test_moments_of_methods_that_only_their_author_has_are_refused(parts, name):
    change = lambda listed: of_kind(listed, "settings").update({name: "own"})
    with pytest.raises(ValueError, match="a transfer or a servo that only its author has"):
        saved.decoded(changed_moments(parts, change), BEGUN)


T = TypeVar("T")


@pytest.mark.parametrize(
    "array", [TypeAliasType("Array", np.ndarray), TypeAliasType("Of", np.ndarray[Any, T], type_params=(T,))[np.dtype]]
)
def test_a_name_for_a_type_is_what_it_names(array):
    """As numpy's `NDArray`, since 2.5."""
    assert fits(np.zeros(2), array) and fits(None, array | None) and not fits(1.0, array) and not fits(None, array)


@pytest.mark.parametrize("plain", [b"\x91" * 5_000, b"\x92\x91\x91\xd9\x02\xff\xff\x90", b"\x92\xc0\xc0"])
def test_what_nests_or_is_no_text_is_refused(plain):
    with pytest.raises(ValueError):
        codec.decode(zstandard.compress(plain))


@pytest.fixture(params=["file", "redis"])
def where(request, tmp_path):
    return str(tmp_path) if request.param == "file" else request.getfixturevalue("redis_url")


@pytest.fixture
def key(request):
    return request.node.name


def test_a_record_that_cannot_be_is_told_and_set_aside(where, key, parts, kept):
    bad = changed_head(parts, length=2**62)
    with contextlib.closing(open_store(where)) as there:
        there.save(key, "a", {**bad, "7": b"left over"})
        autosave = Autosave(open_store(where))
        assert autosave.claim(key, BEGUN) is None
        assert "begins anew" in autosave.lost(key) and autosave.problem(key) is None
        assert there.read(key) == {} and there.read(f"aside {key}") == {**bad, "7": b"left over"}
        autosave.keep(key, kept)
        autosave.stop()
        assert there.names(key) == {HEAD, "0"}
    again = Autosave(open_store(where))
    assert again.claim(key, BEGUN).head == kept.head and again.lost(key) is None
    again.stop()


def test_parts_that_are_no_bytes_are_refused(tmp_path, parts):
    store = SqliteStore(tmp_path)
    store.save(KEY, "a", parts)
    with contextlib.closing(sqlite3.connect(tmp_path / "sessions.sqlite", isolation_level=None)) as file:
        file.execute("UPDATE part SET data = 5 WHERE name = '0'")
        autosave = Autosave(store)
        assert autosave.claim(KEY, BEGUN) is None and "no bytes" in autosave.lost(KEY)
    autosave.stop()


@pytest.mark.parametrize("record", [{b"writer": b"\xff"}, {b"writer": b"a", b"part:\xff": b""}, "a string"])
def test_a_redis_with_other_records_ends_no_writing(redis_url, record, kept, key):
    import redis

    writing = lambda: {thread for thread in threading.enumerate() if thread.name == "viewimit-autosave"}
    before = writing()
    with redis.Redis.from_url(redis_url) as there:
        if isinstance(record, dict):
            there.hset(f"viewimit:{key}", mapping=record)
        else:
            there.set(f"viewimit:{key}", record)
        autosave = Autosave(open_store(redis_url))
        assert autosave.claim(key, BEGUN) is None
        there.hset("viewimit:other", b"writer", b"\xff")  # and one that comes later
        for name in (key, "other", key):
            autosave.keep(name, kept)
        autosave.claim("third", BEGUN)
        autosave.keep("third", kept)
        autosave.stop()
    assert not writing() - before
    again = Autosave(open_store(redis_url))
    assert again.claim(key, BEGUN) is not None and again.claim("third", BEGUN) is not None
    again.stop()


def test_a_redis_knows_other_writers_by_their_bytes(redis_url, key):
    import redis

    with redis.Redis.from_url(redis_url) as there, contextlib.closing(open_store(redis_url)) as store:
        there.hset(f"viewimit:{key}", b"writer", b"\xff")
        assert store.save(key, "a", {"0": b"x"}) is False


def test_a_page_refuses_moments_of_another_arm(kept):
    seven = Session(Settings.paper(joints=tuple(range(1, 8))))
    others = tuple(moment.with_fields(settings=BEGUN) for moment in seven.history)
    with pytest.raises(CannotResume, match="not of this scene"):
        QuietPage(BEGUN, resumed=SavedSession(msgspec.structs.replace(kept.head, cursor=0), others))


def test_a_visitor_whose_record_is_of_no_use_is_told_and_begins_anew(tmp_path):
    here = Here(tmp_path)
    try:
        cookie = browser_of(here.url)
        Client(here.url, cookie=cookie).ready().close()
        wait_until(lambda: kept_of(str(tmp_path), cookie))
        with contextlib.closing(sqlite3.connect(tmp_path / "sessions.sqlite", isolation_level=None)) as file:
            wait_until(lambda: file.execute("UPDATE part SET data = x'00' WHERE name = '0'").rowcount)
        again = Client(here.url, cookie=cookie).ready()
        wait_until(lambda: "begins anew" in again.status)
        again.close()
    finally:
        here.stop()
