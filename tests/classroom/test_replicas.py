"""A class over two servers that share a Redis: at one it is led and asked, at the other followed; one may be lost."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from class_tabs import Tab, ask_class, lecturers_cookie
from serving import Server, browser_of
from viewimit.app.server.lecturer import new_secret
from waiting import wait_until


@pytest.fixture
def secret(monkeypatch):
    """All replicas' own."""
    secret = new_secret()
    monkeypatch.setenv("VIEWIMIT_LECTURER", secret)
    return secret


@pytest.fixture
def two_servers(secret, redis_url):
    with ThreadPoolExecutor(2) as pool:
        servers = list(pool.map(lambda _: Server("--store", redis_url, "--lecturer"), range(2)))
    yield servers
    for server in servers:
        server.process.kill()


def test_a_class_over_two_servers_is_led_asked_and_survives_one_of_them(two_servers, secret):
    here, there = two_servers
    mira, ben = (Tab(server.url, browser_of(server.url)) for server in (here, there))
    mira.put("Your name", "Mira")
    lecturer = Tab(here.url, lecturers_cookie(here.url, secret))
    wait_until(lambda: lecturer.shows("2 here") and lecturer.shows("Mira"))
    assert lecturer.follow("class/lead") == 204
    wait_until(lambda: all(tab.shows("The lecturer leads") for tab in (mira, ben)))
    step(lecturer)
    wait_until(lambda: lecturer.E == mira.E == ben.E)
    lecturer.follow("class/lead")
    wait_until(lambda: not any(tab.shows("The lecturer leads.") for tab in (mira, ben)))
    ask_class(lecturer, [mira, ben])
    lecturer.follow("class/freeze")
    wait_until(lambda: ben.shows("The controls are frozen"))

    here.process.kill()
    moved = mira.cookie.replace(port_of(here), port_of(there), 1)  # browsers send it to any port of a machine
    lecturer = Tab(there.url, lecturers_cookie(there.url, secret))  # before the class is let go
    mira = Tab(there.url, moved)
    wait_until(lambda: mira.shows("The controls are frozen") and ben.shows("The controls are frozen"))
    lecturer.follow("class/freeze")
    wait_until(lambda: not any(tab.shows("The controls are frozen") for tab in (mira, ben)))
    lecturer.follow("class/lead")
    wait_until(lambda: all(tab.shows("The lecturer leads") for tab in (mira, ben)))
    step(lecturer)
    wait_until(lambda: lecturer.E == mira.E == ben.E)
    wait_until(lambda: lecturer.shows("2 here") and lecturer.shows("Mira"))  # who was at the lost one is not told twice
    for tab in (mira, ben, lecturer):
        tab.close()


def step(tab):
    before = tab.E
    tab.press("Step: one motion")
    wait_until(lambda: tab.E != before)


def port_of(server):
    return server.url.rsplit(":", 1)[1]
