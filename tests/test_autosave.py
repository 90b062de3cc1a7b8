"""What of a long session is written again: only what is new in it."""

from collections import Counter

import pytest
from viewimit.app.sessions.autosave import CHUNK, Head, Keeper, Memory

from viewimit.history import RECENT, STRIDE
from viewimit.session import Session
from viewimit.settings import Settings

RESTLESS = Settings(servo="gradient-retuned", transfer="linear", noise_px=0.2)
KEY = "a page"


class CountingStore:
    """In memory; counts how often each part is written."""

    def __init__(self):
        self.parts, self.writes = {}, Counter()

    def claim(self, key, writer):
        return dict(self.parts)

    def save(self, key, writer, parts, gone=()):
        self.parts |= parts
        self.writes.update(parts.keys())
        for name in gone:
            self.parts.pop(name, None)
        return True

    def touch(self, keys):
        pass

    def close(self):
        pass


@pytest.fixture
def store():
    return CountingStore()


@pytest.fixture
def keeper(store):
    keeper = Keeper(store)
    yield keeper
    keeper.stop()


def keep(keeper, session):
    head = Head(
        begun=RESTLESS, cursor=session.cursor, length=len(session.history), preset="", speed=1.0, chosen=None, show={},
        dark=False, motion=None,
    )  # fmt: skip
    keeper.keep(KEY, Memory(head, tuple(session.history)))
    keeper.flush(KEY)


def test_moments_that_let_go_of_what_they_need_not_hold_are_not_written_again(store, keeper):
    assert CHUNK == STRIDE
    session = Session(RESTLESS)
    keeper.claim(KEY, RESTLESS)
    for _ in range(RECENT + 4 * STRIDE):
        session.step()
        keep(keeper, session)
    assert session.history[0].without_cache() is session.history[0]
    assert all(store.writes[str(k)] <= CHUNK for k in range(len(session.history) // CHUNK))


def test_a_resumed_session_writes_nothing_that_is_there(store, keeper):
    session, resumed = Session(RESTLESS), Session(RESTLESS)
    keeper.claim(KEY, RESTLESS)
    session.run(RECENT + 2 * STRIDE)
    keep(keeper, session)
    memory = keeper.claim(KEY, RESTLESS)
    resumed.resume(memory.history, memory.head.cursor)
    store.writes.clear()
    keep(keeper, resumed)
    assert not store.writes
    resumed.step()
    keep(keeper, resumed)
    assert set(store.writes) == {"head", str((len(resumed.history) - 1) // CHUNK)}
