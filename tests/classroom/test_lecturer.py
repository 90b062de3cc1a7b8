"""The lecturer's address, and a class over two processes of a server: by the protocol alone."""

import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor

import pytest
from class_tabs import Tab, ask_class, asked, lecturers_cookie
from serving import Server, browser_of, kept_of, workers_of
from viewimit.app.classroom.board import LED_S
from viewimit.app.server.lecturer import LecturerAccess, class_name, new_secret, require_secret
from waiting import wait_until

pytestmark = pytest.mark.skipif(not hasattr(socket, "send_fds"), reason="processes cannot hand over sockets here")


@pytest.fixture(scope="module")
def server():
    """Whose seats two students take."""
    with tempfile.TemporaryDirectory(prefix="viewimit-class-") as folder:
        server = Server("--workers", "2", "--max-clients", "2", "--lecturer", "--store", folder)
        server.store = folder
        yield server
        assert server.stop() == 0


@pytest.fixture(scope="module")
def secret(server):
    return wait_until(lambda: re.search(r"the lecturer opens http://\S+/lecturer/(\S+)\n", server.log))[1]


def test_a_secret_is_traded_for_a_cookie_and_a_wrong_one_is_told_nothing(server, secret):
    status, cookies = asked(server.url, f"/lecturer/{secret}")
    assert status == 303 and len(cookies) == 2 and secret not in "".join(cookies)
    assert all("HttpOnly" in one and "SameSite=Strict" in one for one in cookies)
    for wrong in (secret[:-1], f"{secret}x", "", "%00", secret.swapcase()):
        with server.says("an address of a lecturer that is not this class's"):
            assert asked(server.url, f"/lecturer/{wrong}") == (404, [])
    assert server.log.count(secret) == 1, "only where it is told"


def test_a_class_over_two_processes_is_led_asked_and_survives_one_of_them(server, secret):
    students = [Tab(server.url, browser_of(server.url)) for _ in range(2)]
    assert {tab.address[:8] for tab in students} == {"/touch/0", "/touch/1"}
    mira, ben = students
    mira.put("Your name", "<b>Mira")
    assert mira.follow("class/lead") == 204
    wait_until(lambda: "not the lecturer" in mira.status)
    lecturer = Tab(server.url, lecturers_cookie(server.url, secret))  # although all seats are taken
    wait_until(lambda: lecturer.shows("2 here") and lecturer.shows("&lt;b&gt;Mira"))
    assert not lecturer.shows("<b>Mira") and not mira.shows("2 here")
    assert lecturer.follow("class/lead") == 204
    wait_until(lambda: all(tab.shows("The lecturer leads") for tab in students))
    for _ in range(2):
        before = lecturer.E
        lecturer.press("Step: one motion")
        wait_until(lambda before=before: lecturer.E != before)
    wait_until(lambda: lecturer.E == mira.E == ben.E)
    mira.press("Step: one motion")
    wait_until(lambda: "The lecturer leads: this page" in mira.status)
    lecturer.follow("class/lead")
    wait_until(lambda: not any(tab.shows("The lecturer leads.") for tab in students))
    ask_class(lecturer, students)
    lecturer.follow("class/freeze")
    wait_until(lambda: mira.shows("The controls are frozen"))
    wait_until(lambda: all(kept.lesson is None for kept in kept_of_all(server, mira, lecturer)))  # else they are in it
    killed = time.monotonic()
    with server.says("another takes its place"):
        os.kill(workers_of(server)[int(mira.address[7])], signal.SIGKILL)
    gone = [tab.cookie for tab in (mira, lecturer) if tab.closed(10)]
    with ThreadPoolExecutor() as browsers:  # as pages do by themselves
        again = list(browsers.map(lambda cookie: Tab(server.url, cookie), gone))
    nobody_led = len(again) == 2 and time.monotonic() - killed > LED_S  # where a process takes that long to begin
    wait_until(lambda: again[0].shows("The controls are frozen") or nobody_led)
    newest = again[-1] if len(again) == 2 else lecturer
    wait_until(lambda: newest.shows("2 here") and newest.shows("&lt;b&gt;Mira"))
    for tab in (ben, newest, *again):
        tab.close()


def kept_of_all(server, *tabs):
    """What was written of them last."""
    own = [next(one for one in tab.cookie.split("; ") if one.startswith("viewimit")) for tab in tabs]
    return [kept_of(server.store, cookie) for cookie in own]


def test_without_a_lecturer_there_is_no_class():
    access = LecturerAccess(None)
    assert access.answer("/lecturer/", {}) is None and LecturerAccess(new_secret()).answer("/lecturer/é", {}) is None
    assert not access.is_lecturer({"Cookie": "lecturer="})


def cookie_given(access, secret):
    """To who has opened the lecturer's address."""
    given = access.answer(f"/lecturer/{secret}", {}).headers.get_all("Set-Cookie")
    (value,) = (one.partition(";")[0].removeprefix("lecturer=") for one in given if one.startswith("lecturer="))
    return value


def test_a_cookie_is_of_one_secret_and_is_not_the_secret():
    secret, another = new_secret(), new_secret()
    one, other = LecturerAccess(secret), LecturerAccess(another)
    value = cookie_given(one, secret)
    headers = {"Cookie": f"lecturer={value}"}
    assert one.is_lecturer(headers) and not other.is_lecturer(headers)
    assert not one.is_lecturer({"Cookie": "lecturer=é"}) and not one.is_lecturer({"Cookie": "=;=\x00"})
    assert len({secret, class_name(secret), value}) == 3 and class_name(secret) not in secret


@pytest.mark.parametrize("secret", ["", "short", "x" * 300, "with a space in it", "slash/slash/slash/slash"])
def test_a_secret_of_ones_own_must_not_be_guessed(secret):
    with pytest.raises(ValueError, match="secret"):
        require_secret(secret)


def test_a_bad_secret_is_said_on_the_command_line():
    command = [sys.executable, "-I", "-m", "viewimit.commands.cli", "serve", "--lecturer", "--port", "0"]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, "VIEWIMIT_LECTURER": "short"})
    assert done.returncode == 2 and "VIEWIMIT_LECTURER" in done.stderr and "short" not in done.stderr
