"""Links of a page's drawings, followed by the browser that has them, and by others against a running server."""

import re
import socket
import time

import pytest
from protocol import Client
from serving import Here, Server, browser_of
from viewimit.app.server.content_policy import content_policy
from viewimit.app.server.dispatcher import Dispatcher, Placing
from viewimit.app.server.options import ServerOptions
from viewimit.app.server.seat_counts import SeatCounts
from viewimit.app.server.touches import TOUCHES_AT_ONCE, NotTouched, Touches
from waiting import stays, wait_until

TOKEN = "t" * 32


def asked(url: str, path: str, method: str = "GET", **headers) -> int:
    """Status of the answer to a request, sent as it is written."""
    host, port = url.removeprefix("http://").split(":")
    fields = {"Host": f"{host}:{port}", **{name.replace("_", "-"): value for name, value in headers.items()}}
    head = f"{method} {path} HTTP/1.1\r\n" + "".join(f"{name}: {value}\r\n" for name, value in fields.items())
    with socket.create_connection((host, int(port)), 10) as connection:
        connection.sendall(f"{head}\r\n".encode())
        answer = b""
        while chunk := connection.recv(1 << 16):
            answer += chunk
    head, _, body = answer.partition(b"\r\n\r\n")
    status = int(head.split()[1])
    if status == 204:
        assert b"no-store" in head and not body
    return status


class Tab(Client):
    """With the address of its links."""

    def __init__(self, url: str, cookie: str | None = None):
        self.url, self.cookie = url, cookie or browser_of(url)
        super().__init__(url, cookie=self.cookie)
        self.ready()
        self.address = wait_until(lambda: self._found(r'href="(/touch/[^/]+)/point/'))

    def follow(self, what: str, **headers) -> int:
        return asked(self.url, f"{self.address}/{what}", **{"Cookie": self.cookie, **headers})

    @property
    def chosen(self) -> int | None:
        """The point that its images ring."""
        found = self._found(r">point (\d+), its<")
        return None if found is None else int(found)

    def _found(self, pattern: str) -> str | None:
        return next((found[1] for html in list(self.html.values()) if (found := re.search(pattern, html))), None)


@pytest.fixture(scope="module")
def server():
    server = Server()
    yield server
    assert server.stop() == 0


@pytest.fixture(scope="module")
def tab(server):
    with Tab(server.url) as tab:
        yield tab


def test_a_link_reaches_its_page_and_is_answered_with_nothing(tab):
    assert tab.follow("point/7", Sec_Fetch_Site="same-origin") == 204
    wait_until(lambda: tab.chosen == 7)
    assert tab.follow("point/7") == 204  # over plain http from another machine browsers do not say from where
    wait_until(lambda: tab.chosen is None)


def test_a_value_that_cannot_be_is_refused_on_the_page_as_a_sliders_is(tab):
    assert tab.follow("point/99") == 204
    wait_until(lambda: "no point 99" in tab.status)
    for value in ("-,.", "nan", "1e999"):
        assert tab.follow(f"point/{value}") == 204
        wait_until(lambda value=value: value in tab.status and "is not a number" in tab.status)


def test_a_link_leads_somewhere_as_soon_as_a_browser_has_it(tmp_path, monkeypatch):
    opened = Touches.open
    monkeypatch.setattr(Touches, "open", lambda *what: time.sleep(0.5) or opened(*what))
    server = Here(tmp_path)
    with Tab(server.url) as tab:
        assert tab.follow("point/7") == 204
    server.stop()


OTHER = "viewimit-{port}=" + TOKEN
REFUSED = {
    "a forged secret": ("/touch/0." + "A" * 32 + "/point/1", {}, 403),
    "no cookie": ("{address}/point/1", {"Cookie": ""}, 403),
    "another browser's cookie": ("{address}/point/1", {"Cookie": OTHER}, 403),
    "another site": ("{address}/point/1", {"Sec_Fetch_Site": "cross-site"}, 403),
    "another port of this machine": ("{address}/point/1", {"Sec_Fetch_Site": "same-site"}, 403),
    "an address that was typed": ("{address}/point/1", {"Sec_Fetch_Site": "none"}, 403),
    "a link that is only fetched beforehand": ("{address}/point/1", {"Sec_Purpose": "prefetch"}, 403),
    "another worker's number": ("/touch/7.{secret}/point/1", {}, 403),
    "no secret": ("/touch/point/1", {}, 404),
    "no value": ("{address}/point/", {}, 404),
    "no control": ("{address}/nothing/1", {}, 404),
    "a character that no value has": ("{address}/point/1'", {}, 404),
    "a long value": ("{address}/point/" + "1" * 41, {}, 404),
    "a long address": ("{address}/point/" + "1" * 5000, {}, 404),
    "another alphabet": ("{address}/point/٣", {}, 404),
    "escapes": ("{address}/point/%31", {}, 404),
    "traversal": ("{address}/../../etc/passwd", {}, 404),
    "a query": ("{address}/point/1?2", {}, 404),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_no_link_of_the_page_asks_for_is_refused_with_one_line(server, tab, what):
    path, headers, status = REFUSED[what]
    path = path.replace("{address}", tab.address).replace("{secret}", tab.address.partition(".")[2])
    headers = {name: value.format(port=server.url.rsplit(":", 1)[1]) for name, value in headers.items()}
    with server.says("refused a touch"):
        assert asked(server.url, path, **{"Cookie": tab.cookie, **headers}) == status
    assert tab.chosen is None


@pytest.mark.parametrize("method", ["HEAD", "POST", "PUT", "OPTIONS"])
def test_only_what_a_link_sends_is_taken(tab, method):
    assert asked(tab.url, f"{tab.address}/point/1", method, Cookie=tab.cookie) == 405
    stays(lambda: tab.chosen is None, 0.2)


def test_a_tab_touches_no_other_tab_and_none_that_is_closed(server, tab):
    with Tab(server.url) as other, Tab(server.url, tab.cookie) as own_other:
        assert len({tab.address, other.address, own_other.address}) == 3
        assert asked(server.url, f"{tab.address}/point/3", Cookie=other.cookie) == 403
        before = tab.chosen, other.chosen
        assert own_other.follow("point/5") == 204
        wait_until(lambda: own_other.chosen == 5)
        assert (tab.chosen, other.chosen) == before != (5, 5)
    wait_until(lambda: other.follow("point/3") == 403)


def test_a_flood_is_refused_and_the_page_goes_on(server):
    with Tab(server.url) as flooded, Tab(server.url) as bystander:
        lines = len(server.lines)
        answers = [flooded.follow(f"point/{k % 10}") for k in range(TOUCHES_AT_ONCE + 30)]
        while answers[-1] != 429 and len(answers) < 10 * TOUCHES_AT_ONCE:  # where each takes long, it takes more
            answers.append(flooded.follow("point/1"))
        assert answers[:TOUCHES_AT_ONCE] == [204] * TOUCHES_AT_ONCE and answers[-1] == 429
        assert len(server.lines) - lines <= 30
        assert bystander.follow("point/2") == 204
        wait_until(lambda: bystander.chosen == 2)
        assert flooded.closed(0) is None


def test_the_policy_lets_links_aim_at_a_frame_of_the_page_alone():
    assert "frame-src 'self';" in content_policy("here:80") and "form-action 'none'" in content_policy("here:80")


def test_a_touch_finds_the_worker_of_its_page_also_when_that_is_full():
    workers = Server("--workers", "2", "--max-clients", "2")  # each is full with one
    try:
        cookie = browser_of(workers.url)
        with Tab(workers.url, cookie) as one, Tab(workers.url, cookie) as two:
            assert {one.address[:8], two.address[:8]} == {"/touch/0", "/touch/1"}
            for tab, point in ((one, 4), (two, 5)):
                assert tab.follow(f"point/{point}") == 204
                wait_until(lambda tab=tab, point=point: tab.chosen == point)
            assert asked(workers.url, "/touch/9.x/point/1", Cookie=cookie) == 404  # there is no such worker
    finally:
        assert workers.stop() == 0


def test_an_address_is_guessed_by_nobody_and_forgotten_with_its_tab():
    touches, done = Touches(3), []
    address, other = touches.new_address(), touches.new_address()
    assert address != other and len(address.partition(".")[2]) == 32
    touches.open(address, lambda *what: not done.append(what), TOKEN)
    headers = {"Cookie": f"viewimit={TOKEN}"}
    touches.follow(f"{address}/posture/45.5,-90", headers)
    assert done == [("posture", "45.5,-90")]
    touches.close(address)
    with pytest.raises(NotTouched):
        touches.follow(f"{address}/posture/1,2", headers)


def test_without_a_cookie_a_page_has_no_links(server):
    with Client(server.url).ready() as client:
        wait_until(lambda: any("The four images" in html for html in client.html.values()))
        assert not any("/touch/" in html for html in client.html.values())


def test_a_head_that_is_no_touch_goes_where_its_browser_goes():
    dispatcher = Dispatcher(Placing(ServerOptions(workers=2), SeatCounts(2)), socket.socketpair())
    where = lambda line: dispatcher.worker_for(f"{line} HTTP/1.1\r\nHost: a\r\n\r\n".encode())
    assert [where(f"GET /touch/{k}.x/point/1") for k in (0, 1)] == [0, 1]
    assert where("GET /touch/1x/point/1") == where("POST /touch/1.x/point/1") == where("GET /") == 0
