"""What is handed over is kept; what cannot be kept is told to whoever handed it over, for as long as that holds."""

import dataclasses
from collections import Counter

import pytest
from quiet_page import QuietPage
from viewimit.app.page.page import KEPT_EVERY
from viewimit.app.sessions.autosave import CHUNK, Autosave, SavedPage, SavedSession
from viewimit.app.sessions.sqlite_store import SqliteStore
from waiting import wait_until

from viewimit.loop.history import RECENT, STRIDE
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

KEY, BEGUN = "key", Settings.paper()


class Refusing(SqliteStore):
    """A disk that can be full."""

    full = False

    def __init__(self, folder):
        super().__init__(folder)
        self.folder, self.refused = folder, []

    def save(self, *args, **options):
        if self.full:
            self.refused.append(args)
            raise OSError("no space left on device")
        return super().save(*args, **options)


@pytest.fixture
def store(tmp_path):
    return Refusing(tmp_path)


@pytest.fixture
def autosave(store):
    autosave = Autosave(store)
    autosave.claim(KEY, BEGUN)
    yield autosave
    autosave.stop()


def memory(*history):
    head = SavedPage(
        begun=BEGUN,
        cursor=0,
        length=len(history),
        preset="",
        speed=1.0,
        chosen=None,
        show={},
        dark=False,
        motion=None,
    )
    return SavedSession(head, history)


def moment(**changes):
    return dataclasses.replace(Session(BEGUN).snapshot, **changes)


def test_a_store_that_refuses_is_told_until_it_takes_it_again(autosave, store):
    store.full = True
    assert autosave.keep(KEY, memory(moment())) is None  # nothing is known of it yet
    autosave.flush(KEY)
    assert autosave.problem(KEY) == "no space left on device"
    assert autosave.keep(KEY, memory(moment())) == "no space left on device"
    store.full = False
    autosave.keep(KEY, memory(moment()))
    autosave.flush(KEY)
    assert autosave.problem(KEY) is None and autosave.claim(KEY, BEGUN).head.length == 1


def test_what_a_page_leaves_while_the_store_refuses_is_written_once_it_takes_it(autosave, store, caplog):
    store.full = True
    autosave.leaving(KEY)
    autosave.keep(KEY, memory(moment()))
    autosave.forget(KEY)
    wait_until(lambda: len(store.refused) >= 2)
    assert store.read(KEY) == {} and caplog.text.count("no space left") <= 2, "said, not each time"
    store.full = False
    wait_until(lambda: "head" in store.read(KEY) and not store.held([KEY]))


def test_what_a_page_has_left_is_gone_on_with_before_the_store_takes_it(autosave, store):
    store.full = True
    autosave.leaving(KEY)
    autosave.keep(KEY, memory(moment()))
    autosave.forget(KEY)
    wait_until(lambda: store.refused)
    assert autosave.claim(KEY, BEGUN).head.length == 1


def test_at_a_stop_what_pages_have_left_is_tried_once_more(store):
    autosave = Autosave(store)
    autosave.claim(KEY, BEGUN)
    store.full = True
    autosave.leaving(KEY)
    autosave.keep(KEY, memory(moment()))
    autosave.forget(KEY)
    wait_until(lambda: store.refused)
    store.full = False
    autosave.stop()
    assert "head" in SqliteStore(store.folder).read(KEY)


def test_a_state_that_nobody_said_how_to_store_is_told_and_costs_no_other_session(autosave):
    autosave.claim("other", BEGUN)
    for unknown, why in ((object(), "cannot keep a object"), (2**70, "cannot keep it")):
        autosave.keep(KEY, memory(moment(servo_state=unknown)))
        autosave.keep("other", memory(moment()))
        autosave.flush(KEY), autosave.flush("other")
        assert why in autosave.problem(KEY) and autosave.problem("other") is None
    autosave.forget(KEY)
    assert autosave.problem(KEY) is None


def test_the_page_says_so_as_long_as_it_holds(autosave, store):
    page = QuietPage(BEGUN, lambda memory: autosave.keep(KEY, memory))

    def hand_over():
        for seconds in (KEPT_EVERY, KEPT_EVERY, 0.5):
            page.tick(seconds)
            autosave.flush(KEY)

    store.full = True
    page.click("Play")
    hand_over()
    assert "not saved: no space left on device" in page.shown
    page.tick(60.0)
    assert "not saved" in page.shown
    store.full = False
    hand_over()
    assert "not saved" not in page.shown and "Moving" in page.shown


RESTLESS = Settings.paper(servo="gradient-retuned", transfer="linear", noise_px=0.2)


class CountingStore:
    """In memory; counts how often each part is written."""

    def __init__(self):
        self.parts, self.writes = {}, Counter()

    def claim(self, key, writer):
        return dict(self.parts)

    def read(self, key):
        return dict(self.parts)

    def names(self, key):
        return set(self.parts)

    def set_aside(self, key):
        self.parts.clear()

    def save(self, key, writer, parts, gone=()):
        self.parts |= parts
        self.writes.update(parts.keys())
        for name in gone:
            self.parts.pop(name, None)
        return True

    def held(self, keys):
        return {}

    def renew(self, leases):
        return set()

    def release(self, key, writer):
        pass

    def close(self):
        pass


@pytest.fixture
def counting():
    return CountingStore()


@pytest.fixture
def counted(counting):
    autosave = Autosave(counting)
    yield autosave
    autosave.stop()


def keep_session(autosave, session):
    head = SavedPage(
        begun=RESTLESS, cursor=session.cursor, length=len(session.history), preset="", speed=1.0, chosen=None, show={},
        dark=False, motion=None,
    )  # fmt: skip
    autosave.keep(KEY, SavedSession(head, tuple(session.history)))
    autosave.flush(KEY)


def test_moments_that_let_go_of_what_they_need_not_hold_are_not_written_again(counting, counted):
    assert CHUNK == STRIDE
    session = Session(RESTLESS)
    counted.claim(KEY, RESTLESS)
    for _ in range(RECENT + 4 * STRIDE):
        session.step()
        keep_session(counted, session)
    assert session.history[0].without_cache() is session.history[0]
    assert all(counting.writes[str(k)] <= CHUNK for k in range(len(session.history) // CHUNK))


def test_a_resumed_session_writes_nothing_that_is_there(counting, counted):
    session, resumed = Session(RESTLESS), Session(RESTLESS)
    counted.claim(KEY, RESTLESS)
    session.run(RECENT + 2 * STRIDE)
    keep_session(counted, session)
    memory = counted.claim(KEY, RESTLESS)
    resumed.resume(memory.history, memory.head.cursor)
    counting.writes.clear()
    keep_session(counted, resumed)
    assert not counting.writes
    resumed.step()
    keep_session(counted, resumed)
    assert set(counting.writes) == {"head", str((len(resumed.history) - 1) // CHUNK)}


def test_a_page_that_left_before_anything_was_kept_comes_back_to_its_own_place(tmp_path):
    autosave = Autosave(SqliteStore(tmp_path))
    assert autosave.claim(KEY, BEGUN) is None
    assert autosave.claim(KEY, BEGUN) is None  # as after a reload, while its lease is still held here
    later = memory(moment())
    autosave.keep(KEY, later)
    autosave.flush(KEY)
    assert autosave.problem(KEY) is None
    autosave.stop()
    again = Autosave(SqliteStore(tmp_path))
    assert again.claim(KEY, BEGUN).head == later.head
    again.stop()
