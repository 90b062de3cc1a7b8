"""Tabs of one browser at different processes, which share the store: what one does is never written over by another."""

import contextlib
import os
import signal

import pytest
from protocol import Client
from serving import Relay, Server, browser_of, kept_of
from viewimit.app.sessions.store import LEASE_S, RENEW_EVERY
from viewimit.app.sessions.stores import open_store
from waiting import stays, wait_until

TAKEN = "another tab has taken this session"


@pytest.fixture(scope="module", params=["file", "redis"])
def where(request, tmp_path_factory):
    if request.param == "redis":
        return request.getfixturevalue("redis_url")
    return str(tmp_path_factory.mktemp("leases") / "state")


@pytest.fixture(scope="module")
def two_servers(where):
    """Each test comes to them with a browser of its own; the last one kills one of them."""
    servers = Server("--store", where), Server("--store", where)
    yield servers
    for server in servers:
        server.process.send_signal(signal.SIGCONT)
        server.process.kill()


def cookie_at(server: Server | Relay, cookie: str) -> str:
    """A browser's cookie, as a server at another port has it."""
    return f"viewimit-{server.url.rsplit(':', 1)[1]}={cookie.split('=')[1]}"


def open_at(server: Server, cookie: str) -> Client:
    return Client(server.url, cookie=cookie_at(server, cookie)).ready()


def left_of_lease(where: str, cookie: str) -> float:
    """s, of a browser's first tab."""
    with contextlib.closing(open_store(where)) as store:
        return sum(store.held([f"{cookie.split('=')[1]}.0"]).values())


def choose(client: Client, angle: float) -> None:
    """Pose the demonstrator, and see the page take it."""
    client.put("θ₂", angle)
    client.press("Step: one motion")
    wait_until(lambda: client.value("History") == 1)


def test_tabs_of_a_browser_at_two_processes_have_a_session_each_and_keep_their_work(two_servers):
    here, there = two_servers
    cookie = browser_of(here.url)
    with open_at(here, cookie) as first, open_at(there, cookie) as second:
        choose(first, 60.0)
        choose(second, 70.0)
    with open_at(there, cookie) as first, open_at(here, cookie) as second:
        assert (first.value("θ₂"), second.value("θ₂")) == (60.0, 70.0)
        stays(lambda: TAKEN not in first.status + second.status, 0.3)


def test_a_tab_is_reloaded_at_another_process_and_has_its_session_at_once(two_servers):
    here, there = two_servers
    cookie = browser_of(here.url)
    with open_at(here, cookie) as tab:
        choose(tab, 61.0)
        for k in range(4):
            tab.close()
            tab = open_at((there, here)[k % 2], cookie)
            assert tab.value("θ₂") == 61.0
        tab.close()


def test_a_laptop_that_slept_comes_back_at_another_process(two_servers, where):
    here, there = two_servers
    relay, cookie = Relay(here.url), browser_of(here.url)
    asleep = Client(relay.url, cookie=cookie_at(relay, cookie)).ready()
    choose(asleep, 67.0)
    relay.silent.set()  # its connection looks open for half a minute
    wait_until(lambda: (page := kept_of(where, cookie)) and page.cursor == 1)
    wait_until(lambda: left_of_lease(where, cookie) < LEASE_S - 2 * RENEW_EVERY)  # nobody renews it any more
    with open_at(there, cookie) as second:
        wait_until(lambda: second.value("θ₂") == 67.0)
    relay.close()


def test_a_page_whose_session_another_has_taken_says_so_and_writes_no_more(two_servers):
    here, there = two_servers
    cookie = browser_of(here.url)
    with open_at(here, cookie) as stalled:
        choose(stalled, 64.0)
        os.kill(here.process.pid, signal.SIGSTOP)
        with open_at(there, cookie) as taker:
            choose(taker, 65.0)
            with here.says(TAKEN):
                os.kill(here.process.pid, signal.SIGCONT)
            wait_until(lambda: TAKEN in stalled.status)
            stalled.put("θ₂", 66.0)
    with open_at(there, cookie) as tab:
        assert tab.value("θ₂") == 65.0


def test_sessions_of_a_process_that_is_killed_come_free(two_servers, where):
    here, there = two_servers
    cookie = browser_of(here.url)
    tabs = [open_at(here, cookie) for _ in range(2)]
    for tab, angle in zip(tabs, (62.0, 63.0)):
        choose(tab, angle)
    kept = lambda: [kept_of(where, cookie, tab) for tab in (0, 1)]
    wait_until(lambda: all(page and page.cursor == 1 for page in kept()))
    with open_at(there, cookie) as third:
        assert third.value("θ₂") == 45.0
        here.process.kill()
        with open_at(there, cookie) as one, open_at(there, cookie) as two:
            assert (one.value("θ₂"), two.value("θ₂")) == (62.0, 63.0)
