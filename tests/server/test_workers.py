"""Several processes behind one port: how visitors are spread over them, and what becomes of them when one ends."""

import asyncio
import contextlib
import multiprocessing
import os
import signal
import socket
import sys
import threading
import time
from types import SimpleNamespace

import pytest
from browsing import open_page, posture, press, stands, wait, wait_for_status, wait_until_complete
from protocol import Client
from serving import Server, tell_all, workers_of
from test_faults import comes_back, what_a_visitor_sees, work
from viewimit.app.server import processes
from viewimit.app.server.address import listen
from viewimit.app.server.limits import ServerOptions
from viewimit.app.server.processes import DECLINES_FOR, LOOK_EVERY, FairListener, Signs, Termination, supervised
from viewimit.app.server.seats import AWAKE_FOR, WELL_FOR, Seats
from waiting import wait_until
from websockets.exceptions import InvalidStatus

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="processes cannot share a port here")


def test_a_server_is_well_while_all_its_processes_give_signs_of_life(monkeypatch):
    now = 1000.0
    monkeypatch.setattr(time, "monotonic", lambda: now)
    seats = Seats(2)
    seats.rows[0].live()
    assert not seats.well and not seats.rows[1].began
    seats.rows[1].live()
    assert seats.well
    now += WELL_FOR + 1
    seats.rows[0].live()
    assert not seats.well
    seats.rows[0].seats, seats.rows[1].seats = 3, 4
    assert seats.taken == 7
    seats.rows[1].clear()
    assert seats.taken == 3 and not seats.rows[1].began


class Accepting:
    """A process of several that share listening sockets, as far as accepting goes: in this process, in a loop of its
    own. accepted: connections, in their order."""

    def __init__(self, listeners, seats: Seats, process: int):
        self.accepted: list[asyncio.StreamWriter] = []
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        begin = self._begin(FairListener([listener.dup() for listener in listeners], seats, process))
        self._server = asyncio.run_coroutine_threadsafe(begin, self._loop).result(5)

    async def _begin(self, listener: FairListener) -> asyncio.Server:
        return await asyncio.start_server(lambda _, writer: self.accepted.append(writer), sock=listener)

    @property
    def port(self) -> int:
        return self._server.sockets[0].getsockname()[1]

    async def _end(self) -> None:
        self._server.close()
        for writer in self.accepted:
            writer.close()

    def stop(self) -> None:
        if not self._thread.is_alive():
            return
        asyncio.run_coroutine_threadsafe(self._end(), self._loop).result(5)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()


@pytest.fixture
def sharing():
    """Two processes' parts of the listeners of a place, and the seats that they count."""
    with contextlib.ExitStack() as stack:

        def begin(host: str = "127.0.0.1"):
            listeners, seats = listen(host, 0), Seats(2)
            for row in seats.rows:
                row.seen = time.monotonic() + 600  # awake all the time
            both = [Accepting(listeners, seats, k) for k in range(2)]
            for one in (*both, *(SimpleNamespace(stop=listener.close) for listener in listeners)):
                stack.callback(one.stop)
            return both, seats

        yield begin


def test_connections_go_to_the_process_with_fewest_seats(sharing):
    (one, other), seats = sharing()
    seats.rows[0].seats = 1
    for k in range(1, 6):
        socket.create_connection(("127.0.0.1", one.port)).close()
        wait_until(lambda k=k: len(other.accepted) == k)
    seats.rows[1].seats = 2
    socket.create_connection(("127.0.0.1", one.port)).close()
    wait_until(lambda: len(one.accepted) == 1)
    assert len(other.accepted) == 5


def test_who_comes_does_not_wait_for_a_process_that_hangs_or_only_begins(sharing):
    (one, other), seats = sharing()
    other.stop()
    seats.rows[0].seats = 3
    seats.rows[1].seen = time.monotonic() - 2 * AWAKE_FOR
    socket.create_connection(("127.0.0.1", one.port)).close()
    wait_until(lambda: len(one.accepted) == 1)
    seats.rows[1].clear()
    socket.create_connection(("127.0.0.1", one.port)).close()
    wait_until(lambda: len(one.accepted) == 2)


def test_a_class_that_comes_at_once_is_spread(sharing):
    both, seats = sharing()
    clients = []
    for k in range(60):
        clients.append(socket.create_connection(("127.0.0.1", both[0].port)))
        wait_until(lambda k=k: sum(len(one.accepted) for one in both) == k + 1)
        for row, one in zip(seats.rows, both):
            row.seats = len(one.accepted)
    for client in clients:
        client.close()
    assert {len(one.accepted) for one in both} == {30}


def test_a_process_that_declines_looks_at_the_queue_now_and_then(sharing, monkeypatch):
    asked = []
    monkeypatch.setattr(Seats, "fewest_awake", lambda seats: asked.append(time.monotonic()) or 0)
    (one, other), seats = sharing()
    other.stop()
    seats.rows[0].seats = 1
    with socket.create_connection(("127.0.0.1", one.port)):
        wait_until(lambda: len(asked) > 10)
        looks, lasted = len(asked), asked[-1] - asked[0]
        assert looks <= 2 + lasted / DECLINES_FOR and not one.accepted
        seats.rows[0].seats = 0
        wait_until(lambda: len(one.accepted) == 1)


@pytest.mark.skipif(not socket.has_ipv6, reason="no IPv6 here")
def test_all_addresses_of_a_name_are_answered(sharing, monkeypatch):
    places = [(socket.AF_INET, ("127.0.0.1", 0)), (socket.AF_INET6, ("::1", 0, 0, 0))]
    found = [(family, socket.SOCK_STREAM, 0, "", place) for family, place in places]
    with monkeypatch.context() as named:
        named.setattr(socket, "getaddrinfo", lambda *_, **__: found)
        both, _ = sharing("a.name")
    for address in ("127.0.0.1", "::1"):
        socket.create_connection((address, both[0].port)).close()
    wait_until(lambda: sum(len(one.accepted) for one in both) == 2)


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="processes are found in /proc")
def test_when_a_worker_is_killed_its_visitors_go_on_in_another_and_the_others_notice_nothing():
    server = Server("--workers", "2")
    clients = [Client(server.url).ready() for _ in range(4)]
    assert server.seated == 4 and len(workers_of(server)) == 2
    angles = 20.0, 30.0, 40.0, 50.0
    for client, angle in zip(clients, angles):
        client.put("θ₂", angle)
        client.press("Make one step")
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
        client.press("Make one step")
    wait_until(lambda: all(client.value("History") == 2 for client in left))
    assert server.stop() == 0


def test_all_workers_together_take_as_many_clients_as_are_allowed():
    server = Server("--workers", "2", "--max-clients", "3")
    clients = [Client(server.url).ready() for _ in range(3)]
    with pytest.raises(InvalidStatus), server.says("all 3 are taken"):
        Client(server.url)
    clients.pop().close()
    wait_until(lambda: server.seated == 2)
    clients.append(Client(server.url).ready())
    for client in clients:
        client.close()
    assert server.stop() == 0


@pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="processes are found in /proc")
def test_processes_end_when_the_one_that_began_them_is_killed_and_no_session_is_lost():
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
    monkeypatch.setattr(processes, "MOST_ENDS", 3)
    options = ServerOptions(Settings.paper(scene="nowhere.toml"), workers=2)
    with pytest.raises(RuntimeError, match="end again and again"):
        with supervised(options, listen("127.0.0.1", 0), Termination()):
            pass
    assert capfd.readouterr().err.count("nowhere.toml") >= 3


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="processes cannot be stopped here")
def test_a_worker_that_gives_no_sign_of_life_is_ended_and_replaced(monkeypatch, caplog):
    monkeypatch.setattr(processes, "SILENT_FOR", 2.0)
    stopped, begun = Termination(), lambda: {child.pid for child in multiprocessing.active_children()}
    others = begun()
    with supervised(ServerOptions(workers=2), listen("127.0.0.1", 0), stopped):
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
