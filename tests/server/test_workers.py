"""Several processes behind one port, and what becomes of a visitor when one ends."""

import asyncio
import multiprocessing
import os
import signal
import socket
import threading
import time

import pytest
from browsing import open_page, posture, press, stands, wait, wait_for_status, wait_until_complete
from protocol import Client
from serving import Server, tell_all, workers_of
from test_faults import comes_back, what_a_visitor_sees, work
from viewimit.app.server import dispatcher as dispatcher_module
from viewimit.app.server import workers as workers_module
from viewimit.app.server.address import listen
from viewimit.app.server.dispatcher import Dispatcher, Placing
from viewimit.app.server.options import ServerOptions
from viewimit.app.server.seat_counts import WELL_FOR, SeatCounts
from viewimit.app.server.termination import Termination
from viewimit.app.server.workers import LOOK_EVERY, Signs, working
from waiting import wait_until
from websockets.exceptions import InvalidStatus

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

pytestmark = pytest.mark.skipif(not hasattr(socket, "send_fds"), reason="processes cannot hand over sockets here")
HEAD = b"GET / HTTP/1.1\r\nHost: here:80\r\n\r\n"


def test_a_connection_goes_to_the_worker_that_has_fewest():
    counts = SeatCounts(3)
    placing = Placing(ServerOptions(workers=3), counts)
    for _ in range(12):
        placing.handed[placing.place()] += 1
    assert placing.handed == [4, 4, 4]
    counts.rows[1].ended = 3  # three of the second worker's have gone
    assert placing.place() == 1


def test_a_worker_without_a_free_seat_gets_nobody_new_and_no_more_seats_are_given_than_there_are():
    options, counts = ServerOptions(max_clients=7, workers=3), SeatCounts(3)
    assert [options.clients_of(k) for k in range(3)] == [3, 2, 2]
    placing = Placing(options, counts)
    placing.handed = [0, 9, 9]
    assert placing.place() == 0
    counts.rows[0].seats = 3
    assert placing.place() in (1, 2)


def test_who_is_new_does_not_wait_for_a_worker_that_is_only_beginning():
    counts = SeatCounts(2)
    placing = Placing(ServerOptions(workers=2), counts)
    counts.rows[1].live()
    placing.handed = [0, 9]
    assert placing.place() == 1
    counts.rows[0].live()
    assert placing.place() == 0


def test_a_server_is_well_while_all_its_processes_give_signs_of_life(monkeypatch):
    now = 1000.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    counts = SeatCounts(2)
    counts.rows[0].live()
    assert not counts.well and not counts.rows[1].began
    counts.rows[1].live()
    assert counts.well
    now += WELL_FOR + 1
    counts.rows[0].live()
    assert not counts.well
    counts.rows[0].seats, counts.rows[1].seats = 3, 4
    assert counts.seats == 7
    counts.rows[1].clear()
    assert counts.seats == 3 and not counts.rows[1].began


class Dispatching:
    """A dispatcher in this process, with the ends that its workers would have."""

    def __init__(self, workers: int = 2):
        pairs = [socket.socketpair() for _ in range(workers)]
        self.ends = [theirs for _, theirs in pairs]
        for end in self.ends:
            end.settimeout(5)
        (listener,) = listen("127.0.0.1", 0)
        self.place = listener.getsockname()
        self._dispatcher = Dispatcher(
            Placing(ServerOptions(workers=workers), SeatCounts(workers)), [ours for ours, _ in pairs]
        )
        self._listener, self._stopped = listener, asyncio.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._run()), daemon=True)
        self._thread.start()

    async def _run(self) -> None:
        self._loop = asyncio.get_running_loop()
        accepting = self._loop.create_task(self._dispatcher.accept(self._listener))
        await self._stopped.wait()
        accepting.cancel()

    def stop(self) -> None:
        self._loop.call_soon_threadsafe(self._stopped.set)
        self._thread.join(5)
        self._listener.close()

    def handed(self, worker: int) -> socket.socket:
        _, (descriptor,), _, _ = socket.recv_fds(self.ends[worker], 1, 1)
        connection = socket.socket(fileno=descriptor)
        connection.settimeout(5)
        return connection


@pytest.fixture
def dispatching():
    made = Dispatching()
    yield made
    made.stop()


def test_a_connection_is_handed_over_whole(dispatching):
    for worker in (0, 1, 0):
        with socket.create_connection(dispatching.place) as client:
            client.sendall(HEAD[:20])
            time.sleep(0.05)  # so that the head comes in two parts
            client.sendall(HEAD[20:] + b"and more")
            with dispatching.handed(worker) as connection:
                sent = HEAD + b"and more"
                wait_until(lambda: connection.recv(1000, socket.MSG_PEEK) == sent)  # noqa: B023
                assert connection.recv(1000) == sent
                assert connection.getpeername() == client.getsockname()
                connection.sendall(b"an answer")
            assert client.recv(100) == b"an answer"


def test_who_never_ends_a_head_is_told_so_and_holds_nobody_up(dispatching, monkeypatch):
    monkeypatch.setattr(dispatcher_module, "HEAD_WITHIN", 0.5)
    with socket.create_connection(dispatching.place) as silent, socket.create_connection(dispatching.place) as gone:
        gone.close()
        silent.sendall(b"GET / HT")
        with socket.create_connection(dispatching.place) as other:
            other.sendall(HEAD)
            dispatching.handed(0).close()
        silent.settimeout(5)
        assert silent.recv(1000).startswith(b"HTTP/1.1 408 ")  # for it has begun


def test_a_head_that_does_not_grow_is_searched_once_and_looked_at_ever_more_rarely(monkeypatch):
    searched, slept, sleep = [], [], asyncio.sleep
    is_whole = dispatcher_module.is_whole
    monkeypatch.setattr(dispatcher_module, "is_whole", lambda head: searched.append(len(head)) or is_whole(head))
    monkeypatch.setattr(asyncio, "sleep", lambda s: slept.append(s) or sleep(s / 10))
    dispatching = Dispatching()
    with socket.create_connection(dispatching.place) as client:
        client.sendall(HEAD[:20])
        wait_until(lambda: len(slept) >= 8)
        assert slept[:6] == [0.02, 0.04, 0.08, 0.16, 0.32, 0.5] and max(slept) == 0.5
        client.sendall(HEAD[20:])
        dispatching.handed(0).close()
    assert searched == [20, len(HEAD)]
    dispatching.stop()


def test_of_connections_that_send_nothing_only_so_many_are_open_and_the_oldest_make_room(monkeypatch):
    monkeypatch.setattr(dispatcher_module, "UNPLACED", 3)
    dispatching = Dispatching()
    waiting = [socket.create_connection(dispatching.place) for _ in range(5)]
    for client in waiting:
        client.settimeout(5)
    assert [client.recv(10) for client in waiting[:2]] == [b"", b""]
    waiting[4].sendall(HEAD)
    dispatching.handed(0).close()
    for client in waiting:
        client.close()
    dispatching.stop()


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="processes are found in /proc")
def test_when_a_worker_is_killed_its_visitors_go_on_in_another_and_the_others_notice_nothing():
    server = Server("--workers", "2")
    clients = [Client(server.url).ready() for _ in range(4)]
    assert server.seated == 4 and len(workers_of(server)) == 2
    angles = 20.0, 30.0, 40.0, 50.0
    for client, angle in zip(clients, angles):
        client.put("θ₂", angle)
        client.press("Step: one motion")
    wait_until(lambda: all(client.value("History") == 1 for client in clients))
    tabs = [client.keep() for client in clients]
    seen = [what_a_visitor_sees(client) | {"θ₂": angle} for client, angle in zip(clients, angles)]
    with server.says("a process of the server has ended"):
        os.kill(workers_of(server)[0], signal.SIGKILL)
        gone = [client.closed(2) is not None for client in clients]
    assert sum(gone) == 2, "half of them were there"
    for tab, was_there, before in zip(tabs, gone, seen):
        if was_there:
            with Client(server.url, tab=tab).ready() as again:
                wait_until(lambda again=again, before=before: what_a_visitor_sees(again) == before)
    left = [client for client, was_there in zip(clients, gone) if not was_there]
    for client in left:
        client.press("Step: one motion")
    wait_until(lambda: all(client.value("History") == 2 for client in left))
    assert server.stop() == 0


def test_all_workers_together_take_as_many_clients_as_are_allowed():
    server = Server("--workers", "2", "--max-clients", "3")
    clients = [Client(server.url).ready() for _ in range(3)]
    with pytest.raises(InvalidStatus), server.says("all 1 are taken"):
        Client(server.url)
    clients.pop().close()
    wait_until(lambda: server.seated == 2)
    clients.append(Client(server.url).ready())
    for client in clients:
        client.close()
    assert server.stop() == 0


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="processes are found in /proc")
def test_workers_end_when_the_process_that_hands_over_is_killed():
    server = Server("--workers", "2")
    workers = workers_of(server)
    with Client(server.url).ready() as client:
        work(client)
        seen, tab = what_a_visitor_sees(client), client.keep()
        server.process.kill()
        server.process.wait()
        wait_until(lambda: not any(os.path.exists(f"/proc/{pid}") for pid in workers))
    server = Server()
    comes_back(server.url, tab, seen)
    server.stop()


def test_workers_that_cannot_begin_are_not_begun_for_ever(capfd, monkeypatch):
    monkeypatch.setattr(workers_module, "MOST_ENDS", 3)
    options = ServerOptions(Settings.paper(scene="nowhere.toml"), workers=2)
    with pytest.raises(RuntimeError, match="end again and again"):
        with working(options, listen("127.0.0.1", 0), Termination()):
            pass
    assert capfd.readouterr().err.count("nowhere.toml") >= 3


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="processes cannot be stopped here")
def test_a_worker_that_gives_no_sign_of_life_is_ended_and_replaced(monkeypatch, caplog):
    monkeypatch.setattr(workers_module, "SILENT_FOR", 2.0)
    stopped, begun = Termination(), lambda: {child.pid for child in multiprocessing.active_children()}
    others = begun()
    with working(ServerOptions(workers=2), listen("127.0.0.1", 0), stopped):
        first = begun() - others
        silent = min(first)
        os.kill(silent, signal.SIGSTOP)
        wait_until(lambda: silent not in begun() and len(begun() - others) == 2, 30)
        assert len(first & begun()) == 1, "the other one goes on"
        assert "no sign of life for 2 s: it is ended" in caplog.text and "another takes its place" in caplog.text
        stopped.set()
    assert not begun() - others


def test_who_was_asleep_itself_does_not_take_others_for_silent(monkeypatch):
    now = 1000.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    signs = Signs()
    assert signs.silent_for(999.0) == 0.0
    now += 3600  # a laptop that was shut, a terminal's Ctrl+Z
    assert signs.silent_for(999.0) <= 2 * LOOK_EVERY
    for _ in range(100):
        now += LOOK_EVERY
        signs.silent_for(999.0)
    assert 100 * LOOK_EVERY <= signs.silent_for(999.0) <= 102 * LOOK_EVERY
    assert signs.silent_for(now) == 0.0


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="processes are found in /proc")
def test_a_signal_to_all_processes_begins_none_again():
    server = Server("--workers", "2")
    tell_all(workers_of(server), signal.SIGTERM)
    wait_until(lambda: not workers_of(server))
    assert server.stop() == 0
    assert "another takes its place" not in server.log


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="processes cannot be stopped here")
def test_a_stop_takes_ten_seconds_at_most():
    server = Server("--workers", "2")
    os.kill(workers_of(server)[0], signal.SIGSTOP)
    with server.says("a process of the server does not end"):
        assert server.stop() == 0  # which waits no longer


@pytest.mark.browser
def test_pages_of_two_workers_run_and_come_back_after_a_reload(browser):
    server, alone = Server("--workers", "2"), Session(Settings.paper())
    alone.step()
    pages = [open_page(browser, server.url, "small") for _ in range(2)]
    for page in pages:
        press(page, "ArrowRight")
        wait_for_status(page, "^(?!Ready)")
    assert server.seated == 2
    for page in pages:
        wait(page, lambda page=page: posture(page) == stands(alone))
    pages[0].reload()
    wait_until_complete(pages[0])
    wait(pages[0], lambda: posture(pages[0]) == stands(alone))
    for page in pages:
        assert page.problems == []
        page.close()
    assert server.stop() == 0
