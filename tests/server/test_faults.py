"""Faults of networks, browsers and sessions: who comes back finds everything as it was, and nobody else is harmed."""

import contextlib
import os
import re
import signal
import subprocess
import sys
import time

import pytest
from browsing import PAUSE
from drawn import MOTIONS_MADE, learners_bars
from protocol import Client, Tab
from serving import ENDS_WITHIN_S, Here, Server, processes_of, tell_all
from viewimit.app.panels.panel import SLOW, Layout
from viewimit.app.server import pages
from waiting import stays, wait_until

from viewimit.loop.session import Session


@pytest.fixture
def here():
    server = Here()
    yield server
    server.stop()


def what_a_visitor_sees(client: Client) -> dict:
    """Everything that must be as it was."""
    shown = (
        "θ₂",
        "θ₄",
        "Preset",
        "Speed",
        "Transfer",
        "Servo",
        "Pixel noise (px)",
        "Seed",
        "History",
        "Point",
        "Rays",
        "Dark",
    )
    return {label: client.value(label) for label in shown} | {"learner": learner_of(client), "status": client.status}


def learner_of(client: Client) -> str:
    """Its bars, with the demonstrator's angles marked on them."""
    return learners_bars(client.html.values())


def work(client: Client) -> None:
    """What a visitor does: chooses, runs, stops, goes back."""
    for label, value in (
        ("Preset", "Noisy pictures"),
        ("Seed", 12.0),
        ("Point", "3"),
        ("Rays", True),
        ("Dark", True),
        ("Speed", "10 a second"),
        ("θ₂", 55.0),
    ):
        client.put(label, value)
        client.values[client.widgets[label]] = value  # as a browser shows what was done in it
        time.sleep(PAUSE)  # as in a browser: viser hears two messages at once in either order, and a speed is not shown
    client.press("Play or pause")
    wait_until(lambda: (client.value("History") or 0) >= 6)
    client.press("Play or pause")
    wait_until(lambda: re.search("Paused|Arrived|At rest", client.status))  # on a busy host at rest already
    last = once_drawn(client)
    client.put("History", 4)
    client.values[client.widgets["History"]] = 4
    taken = lambda: any(f'{MOTIONS_MADE}"><span>Step 4 of' in html for html in client.html.values())  # by the server
    wait_until(lambda: taken() and learner_of(client) != last["learner"] and client.status != last["status"])


def once_drawn(client: Client) -> dict:
    """What a visitor sees of a page at rest, once the panels that are drawn more seldom are drawn too."""
    looks = [what_a_visitor_sees(client)]

    def stands():
        time.sleep(1.5 * SLOW)
        looks.append(what_a_visitor_sees(client))
        return looks[-1] == looks[-2]

    wait_until(stands)
    return looks[-1]


def comes_back(url: str, tab: Tab, seen: dict) -> None:
    with Client(url, tab=tab).ready() as client:
        wait_until(lambda: client.value("History") == seen["History"])
        wait_until(lambda: what_a_visitor_sees(client) == seen)
        stays(lambda: what_a_visitor_sees(client) == seen, 0.3)  # the panels are drawn three times
        assert what_a_visitor_sees(client) == seen
        client.put("History", 6)  # the later motions are kept too
        wait_until(lambda: learner_of(client) != seen["learner"])


@contextlib.contextmanager
def heard_of(number: int, how: signal.Handlers):
    """Processes that are begun inside hear of this signal by default, or not at all, however the tests were begun."""
    before = signal.signal(number, how)
    try:
        yield
    finally:
        signal.signal(number, before)


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="terminals send no signal here")
def test_a_terminal_that_is_closed_ends_the_server():
    with heard_of(signal.SIGHUP, signal.SIG_DFL):
        server = Server()
    with Client(server.url).ready():
        tell_all(processes_of(server.process.pid)[::-1], signal.SIGHUP)  # as a terminal does
        assert server.process.wait(ENDS_WITHIN_S) == 0


def test_a_server_that_hangs_ends_itself_and_says_where():
    hangs = """
import itertools, sys
from viewimit.app.page.page import Page
from viewimit.app.server import serve
serve.HANGS_AFTER = 3
Page.tick = lambda page, *_: sum(itertools.count())  # in C, so that no thread of Python's could end it
from viewimit.commands.cli import main
sys.exit(main(sys.argv[1:]))"""
    command = [sys.executable, "-I", "-c", hangs, "serve", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        url = re.search(r"http://\S+", server.stdout.readline())[0]
        with Client(url):
            assert server.wait(30) != 0
        assert "scheduler.py" in server.stderr.read()


def test_a_server_that_cannot_end_by_itself_is_ended():
    hangs = "import time; from viewimit.app.server import pages; pages.App.stop = lambda app: time.sleep(60)"
    serves = f"import sys; {hangs}; from viewimit.commands.cli import main; sys.exit(main(sys.argv[1:]))"
    command = [sys.executable, "-I", "-c", serves, "serve", "--port", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        assert "listening" in server.stdout.readline()
        server.terminate()
        assert server.wait(ENDS_WITHIN_S) == 1
        assert "does not end by itself" in server.stderr.read()


def test_a_session_whose_loop_fails_says_so_in_its_own_page_and_can_be_reset(here, monkeypatch, caplog):
    step = Session.step

    def breaks(session):
        if session.settings.seed == 13:
            raise RuntimeError("the arm fell off")
        return step(session)

    monkeypatch.setattr(Session, "step", breaks)
    with Client(here.url).ready() as unlucky, Client(here.url).ready() as other:
        unlucky.put("Seed", 13.0)
        other.press("Play or pause")
        wait_until(lambda: here.sessions[0].settings.seed == 13)
        unlucky.press("Play or pause")
        wait_until(lambda: "the arm fell off" in unlucky.status)
        wait_until(lambda: (other.value("History") or 0) >= 3)
        assert "the arm fell off" not in other.status
        unlucky.put("Seed", 7.0)
        wait_until(lambda: here.sessions[0].settings.seed == 7)
        unlucky.press("Reset to the start")
        wait_until(lambda: "Ready" in unlucky.status)
        unlucky.press("Play or pause")
        wait_until(lambda: (unlucky.value("History") or 0) >= 2)
    assert "RuntimeError('the arm fell off')" in caplog.text


@pytest.mark.skipif(not os.path.exists("/proc/self/statm"), reason="memory is read from /proc")
@pytest.mark.slow
def test_who_comes_and_goes_leaves_no_memory_behind(visits=125, bound_mb=12.5):
    server = Server()
    for visit in range(10 + visits):
        if visit == 10:  # what the first visitors bring in stays: the scene's meshes, code, caches
            before = server.memory
        with Client(server.url).ready() as client:
            client.press("Make one step")
    wait_until(lambda: server.seated == 0)
    grown = server.memory - before
    server.stop()
    assert grown < bound_mb, f"{grown:.1f} MB"


def test_a_page_that_cannot_be_made_says_why_and_comes_back_to_what_it_was(here, monkeypatch, caplog):
    monkeypatch.setattr(pages, "AGAIN_AFTER", 0.5)
    with Client(here.url).ready() as client:
        work(client)
        seen, tab = what_a_visitor_sees(client), client.keep()
    with monkeypatch.context() as broken:
        broken.setattr(Layout, "dropdown", lambda *_, **__: 1 / 0)
        with Client(here.url, tab=tab) as client:
            wait_until(lambda: any("cannot be shown: division by zero" in html for html in client.html.values()))
            assert client.closed(5) == (1013, "the page cannot be shown")
    assert caplog.text.count("a page cannot be shown: ZeroDivisionError") == 1 and not here.pages
    comes_back(here.url, tab, seen)
