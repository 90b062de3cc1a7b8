"""Where a class meets: the same theorems in a process, in a file that processes share, and in a Redis."""

import contextlib
import threading
from concurrent.futures import ThreadPoolExecutor

import pytest
from viewimit.app.classroom.board import GONE_S
from viewimit.app.classroom.boards import open_board
from viewimit.app.classroom.local_board import LocalBoard
from viewimit.app.classroom.sqlite_board import SqliteBoard
from viewimit.app.sessions import sqlite_file
from waiting import wait_until


@pytest.fixture(params=["process", "file", "redis"])
def open_one(request, tmp_path):
    """Opens the board of a class, by its name, as each process does."""
    if request.param == "process":
        boards = {}
        return lambda name: boards.setdefault(name, LocalBoard())
    where = str(tmp_path) if request.param == "file" else request.getfixturevalue("redis_url")
    return lambda name: open_board(where, name, shared=True)


@pytest.fixture
def two(open_one, request):
    with (
        contextlib.closing(open_one(request.node.name)) as here,
        contextlib.closing(open_one(request.node.name)) as there,
    ):
        yield here, there


def test_orders_are_seen_by_all_and_given_in_place_of_those_that_stand(two):
    here, there = two
    assert here.orders()[:2] == (0, b"")
    assert here.order(0, b"first") and there.orders()[:2] == (1, b"first")
    assert there.order(1, b"second") and not here.order(1, b"late")
    assert here.orders()[:2] == (2, b"second")


def test_of_many_orders_at_once_one_stands(two):
    begin = threading.Barrier(2)

    def order(board, number):
        begin.wait()
        return board.order(number, b"x")

    with ThreadPoolExecutor(2) as pool:
        for number in range(10):
            assert sorted(pool.map(order, two, [number] * 2)) == [False, True]


def test_a_roster_is_its_process_and_goes_with_it(two):
    here, there = two
    here.publish("a", b"one")
    there.publish("b", b"two")
    there.publish("b", None)
    assert sorted(here.rosters()) == [b"one", b"two"]
    here.leave("a")
    assert there.rosters() == [b"two"]


def test_replies_are_kept_by_call_and_student_the_newest_of_each(two):
    here, there = two
    here.reply("round 1", {"mira": b"0", "ben": b"1"})
    there.reply("round 1", {"ben": b"2"})
    there.reply("round 2", {"ben": b"3"})
    assert here.replies("round 1") == {"mira": b"0", "ben": b"2"}
    assert there.replies("round 2") == {"ben": b"3"} and here.replies("round 3") == {}


def test_a_class_knows_nothing_of_another(open_one, request):
    here, other = (open_one(f"{request.node.name} {k}") for k in range(2))
    here.order(0, b"first")
    here.publish("a", b"one")
    here.reply("round 1", {"ben": b"1"})
    assert other.orders()[:2] == (0, b"") and other.rosters() == [] and other.replies("round 1") == {}


def test_no_flood_of_replies_is_kept(two, monkeypatch):
    for module in ("local_board", "sqlite_board", "redis_board"):
        monkeypatch.setattr(f"viewimit.app.classroom.{module}.MOST_REPLIES", 3)
    here, _ = two
    here.reply("round 1", {f"{k}": b"x" for k in range(9)})
    assert len(here.replies("round 1")) == 3


@pytest.mark.parametrize("kind", ["process", "file"])
def test_who_gives_no_sign_of_life_is_gone(kind, tmp_path):
    now = 1000.0
    clock = lambda: now
    board = LocalBoard(clock) if kind == "process" else SqliteBoard(tmp_path, "a class", clock)
    board.order(0, b"x")
    board.publish("a", b"one")
    now += GONE_S - 1
    board.publish("a", None)
    board.live(1)
    now += GONE_S - 1
    assert board.rosters() == [b"one"] and board.orders().age == GONE_S - 1
    board.live(0)  # of orders that stand no more
    now += 2
    assert board.rosters() == [] and board.orders().age > GONE_S


def test_a_redis_tells_of_new_orders(redis_url):
    with contextlib.closing(open_board(redis_url, "told", True)) as here:
        told = threading.Event()
        here.watch(told.set)

        def heard():
            here.order(here.orders().number, b"x")
            return told.wait(0.1)

        wait_until(heard)


def test_a_file_that_cannot_be_is_said(tmp_path, monkeypatch):
    tmp_path.joinpath("classes.sqlite").mkdir()
    with pytest.raises(OSError, match="classes.sqlite"):
        open_board(str(tmp_path), "a class", True)
    assert sqlite_file.LOCKED_S < 1
