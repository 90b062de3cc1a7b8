"""What is handed over is kept; what cannot be kept is told to whoever handed it over, for as long as that holds."""

import dataclasses

import pytest
from quiet_page import QuietPage
from viewimit.app.page import KEPT_EVERY
from viewimit.app.sessions.autosave import Head, Keeper, Memory
from viewimit.app.sessions.sqlite_store import SqliteStore

from viewimit.session import Session
from viewimit.snapshot import Settings

KEY, BEGUN = "key", Settings()


class Refusing(SqliteStore):
    """A disk that can be full."""

    full = False

    def save(self, *args, **options):
        if self.full:
            raise OSError("no space left on device")
        return super().save(*args, **options)


@pytest.fixture
def store(tmp_path):
    return Refusing(tmp_path)


@pytest.fixture
def keeper(store):
    keeper = Keeper(store)
    keeper.claim(KEY, BEGUN)
    yield keeper
    keeper.stop()


def memory(*history):
    head = Head(
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
    return Memory(head, history)


def moment(**changes):
    return dataclasses.replace(Session(BEGUN).snapshot, **changes)


def test_a_store_that_refuses_is_told_until_it_takes_it_again(keeper, store):
    store.full = True
    assert keeper.keep(KEY, memory(moment())) is None  # nothing is known of it yet
    keeper.flush(KEY)
    assert keeper.problem(KEY) == "no space left on device"
    assert keeper.keep(KEY, memory(moment())) == "no space left on device"
    store.full = False
    keeper.keep(KEY, memory(moment()))
    keeper.flush(KEY)
    assert keeper.problem(KEY) is None and keeper.claim(KEY, BEGUN).head.length == 1


def test_a_state_that_nobody_said_how_to_store_is_told_and_costs_no_other_session(keeper):
    keeper.claim("other", BEGUN)
    for unknown, why in ((object(), "cannot keep a object"), (2**70, "cannot keep it")):
        keeper.keep(KEY, memory(moment(servo_state=unknown)))
        keeper.keep("other", memory(moment()))
        keeper.flush(KEY), keeper.flush("other")
        assert why in keeper.problem(KEY) and keeper.problem("other") is None
    keeper.forget(KEY)
    assert keeper.problem(KEY) is None


def test_the_page_says_so_as_long_as_it_holds(keeper, store):
    page = QuietPage(BEGUN, lambda memory: keeper.keep(KEY, memory))

    def hand_over():
        for seconds in (KEPT_EVERY, KEPT_EVERY, 0.5):
            page.tick(seconds)
            keeper.flush(KEY)

    store.full = True
    page.click("Play")
    hand_over()
    assert "not saved: no space left on device" in page.shown
    page.tick(60.0)
    assert "not saved" in page.shown
    store.full = False
    hand_over()
    assert "not saved" not in page.shown and "Moving" in page.shown
