"""Every request is answered: as asked, or with a status that says why not."""

import contextlib
import re
import socket

import h11
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from serving import Server
from test_seats import FIRST_VIEW, HANDSHAKE, framed, place_of
from viewimit.app.server.connection import MOST_HEAD, NotAnswered, as_get
from waiting import wait_until
from websockets.http11 import Request
from websockets.streams import StreamReader


@pytest.fixture(scope="module", params=[(), ("--workers", "2")], ids=["one process", "two workers"])
def serving(request):
    server = Server(*request.param)
    yield server
    assert server.stop() == 0


def answer_to(url: str, request: bytes, ends: bool = False) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body; the server ends the connection. ends: the client says that it will send no more."""
    with socket.create_connection(place_of(url), timeout=20) as client:
        client.sendall(request)
        if ends:
            client.shutdown(socket.SHUT_WR)
        received = b""
        while data := client.recv(1 << 16):
            received += data
    head, _, body = received.partition(b"\r\n\r\n")
    status, *lines = head.decode().split("\r\n")
    return int(status.split()[1]), dict(line.split(": ", 1) for line in lines), body


HOST = "Host: 127.0.0.1\r\n"
REQUESTS = {
    "GET": ("GET / HTTP/1.1\r\n" + HOST, 200),
    "HEAD": ("HEAD / HTTP/1.1\r\n" + HOST, 200),
    "GET of HTTP/1.0": ("GET / HTTP/1.0\r\n", 200),
    "health": ("GET /health HTTP/1.1\r\n" + HOST, 200),
    "HEAD of health": ("HEAD /health HTTP/1.1\r\n" + HOST, 200),
    "HTTP/1.0 of health": ("GET /health HTTP/1.0\r\n", 200),
    "HEAD of HTTP/1.0 of health": ("HEAD /health HTTP/1.0\r\n", 200),
    "nothing but empty lines": ("\r\n" * MOST_HEAD, 431),
    "an empty line before": ("\r\nGET /health HTTP/1.1\r\n" + HOST, 200),
    "no such file": ("GET /nothing HTTP/1.1\r\n" + HOST, 404),
    "no such file, its head": ("HEAD /nothing HTTP/1.1\r\n" + HOST, 404),
    "a name that no file has": (f"GET /{'a' * 3000} HTTP/1.1\r\n" + HOST, 404),
    "OPTIONS": ("OPTIONS / HTTP/1.1\r\n" + HOST, 405),
    "OPTIONS of HTTP/1.0": ("OPTIONS / HTTP/1.0\r\n", 405),
    "OPTIONS *": ("OPTIONS * HTTP/1.1\r\n" + HOST, 405),
    "POST": ("POST / HTTP/1.1\r\nContent-Length: 3\r\n" + HOST, 405),
    "POST of health": ("POST /health HTTP/1.1\r\nContent-Length: 3\r\n" + HOST, 405),
    "DELETE": ("DELETE / HTTP/1.1\r\n" + HOST, 405),
    "GET with a body": ("GET / HTTP/1.1\r\nContent-Length: 3\r\n" + HOST, 400),
    "GET with chunks": ("GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n" + HOST, 400),
    "two hosts": ("GET / HTTP/1.1\r\n" + 2 * HOST, 400),
    "no host": ("GET / HTTP/1.1\r\n", 400),
    "two origins": ("GET / HTTP/1.1\r\nOrigin: a\r\norigin: b\r\n" + HOST, 400),
    "two lengths": ("GET / HTTP/1.1\r\nContent-Length: 0\r\nContent-Length: 3\r\n" + HOST, 400),
    "no request": ("hello\r\n", 400),
    "no target": ("GET HTTP/1.1\r\n", 400),
    "a header without a colon": ("GET / HTTP/1.1\r\nHost\r\n", 400),
    "a header with a control character": ("GET / HTTP/1.1\r\na: \x01\r\n" + HOST, 400),
    "a header with a space": ("GET / HTTP/1.1\r\nHo st: a\r\n", 400),
    "a websocket by HEAD": (HANDSHAKE.format(host="a").replace("GET", "HEAD")[:-2], 400),
    "a websocket by HTTP/1.0": (HANDSHAKE.format(host="a").replace("1.1", "1.0", 1)[:-2], 400),
    "a websocket with two keys": (HANDSHAKE.format(host="a")[:-2] + "Sec-WebSocket-Key: a\r\n", 400),
    "a websocket with a bad key": (HANDSHAKE.format(host="a").replace("Key: ", "Key: x")[:-2], 400),
    "HTTP/2": ("PRI * HTTP/2.0\r\n", 505),
    "200 headers": ("GET / HTTP/1.1\r\n" + HOST + "a: b\r\n" * 200, 431),
    "a header of 10 kB": ("GET / HTTP/1.1\r\n" + HOST + f"a: {'b' * 10_000}\r\n", 431),
    "a head of 40 kB": ("GET / HTTP/1.1\r\n" + HOST + f"a: {'b' * 4_000}\r\n" * 10, 431),
}


@pytest.mark.parametrize("what", REQUESTS)
def test_every_request_is_answered(serving, what):
    request, status = REQUESTS[what]
    found, headers, body = answer_to(serving.url, request.encode() + b"\r\n")
    assert found == status and headers["Connection"] == "close"
    assert ("Allow" in headers) is (status == 405)
    if request.lstrip().startswith("HEAD"):
        assert body == b"" and int(headers["Content-Length"]) > 0
    else:
        assert len(body) == int(headers["Content-Length"]) > 0


@pytest.mark.parametrize("request_", [b"GET /health HTTP/1.0\n\n", b"GET /health HTTP/1.1\nHost: a\n\n"])
def test_lines_that_end_otherwise_are_answered_at_once(serving, request_):
    assert answer_to(serving.url, request_)[0] == 200


def test_who_has_said_all_is_answered_yet(serving):
    assert answer_to(serving.url, b"GET /health HTTP/1.0\r\n\r\n", ends=True)[0] == 200
    assert answer_to(serving.url, b"POST / HTTP/1.1\r\nHost: a\r\n\r\n", ends=True)[0] == 405


def test_the_head_of_an_answer_tells_of_what_the_answer_would_have(serving):
    sizes = {
        int(answer_to(serving.url, f"{method} / HTTP/1.1\r\n{HOST}\r\n".encode())[1]["Content-Length"])
        for method in ("GET", "HEAD")
    }
    assert len(sizes) == 1


def test_a_body_that_is_still_coming_does_not_undo_the_answer(serving):
    length = 4 << 20
    with socket.create_connection(place_of(serving.url), timeout=20) as client:
        client.sendall(f"POST / HTTP/1.1\r\n{HOST}Content-Length: {length}\r\n\r\n".encode())
        for _ in range(16):
            client.sendall(bytes(1 << 16))
        wait_until(lambda: re.match(rb"HTTP/1.1 405 .*\r\n\r\n", client.recv(4096), re.DOTALL))


@pytest.mark.parametrize("first", [f"GET /health HTTP/1.1\r\n{HOST}\r\n", f"HEAD / HTTP/1.1\r\n{HOST}\r\n"])
@pytest.mark.parametrize("behind", [f"GET /health HTTP/1.1\r\n{HOST}\r\n", "\r\n", "x" * 100_000])
def test_what_comes_behind_a_request_does_not_undo_its_answer(serving, first, behind):
    assert answer_to(serving.url, (first + behind).encode())[0] == 200


@pytest.mark.parametrize("behind", [b"GET / HTTP/1.1\r\n\r\n", framed(b"x"), framed(FIRST_VIEW), bytes(100_000)])
def test_what_comes_behind_the_request_for_a_websocket_is_read_after_its_answer(serving, behind):
    with socket.create_connection(place_of(serving.url), timeout=20) as client:
        client.sendall(HANDSHAKE.format(host="a").encode() + behind)
        assert client.recv(12) == b"HTTP/1.1 101"


def as_websockets_reads(head: bytes) -> Request:
    """Raises ValueError for what it would not answer."""
    reader = StreamReader()
    reader.feed_data(head)
    reader.feed_eof()
    try:
        next(Request.parse(reader.read_line))
    except StopIteration as done:
        return done.value
    raise ValueError("it waits for more")


@given(
    target=st.binary(min_size=1, max_size=20),
    headers=st.lists(st.tuples(st.binary(min_size=1, max_size=12), st.binary(max_size=20)), max_size=4),
)
@example(target=b"/\xff~", headers=[(b"a", b"\xe9\t."), (b"B", b"")])
@example(target=b"/", headers=[(b"a", b"b")] * 127)
@example(target=b"/", headers=[(b"a", b"b")] * 200)
@example(target=b"/" * 8200, headers=[])
@example(target=b"/", headers=[(b"Content-Length", b"0"), (b"a", b"b" * 8190)])
def test_what_is_taken_for_a_request_is_one_for_websockets_too(target, headers):
    asked = h11.Connection(h11.SERVER, MOST_HEAD)
    asked.receive_data(b"HEAD %s HTTP/1.0\r\n%s\r\n" % (target, b"".join(b"%s: %s\r\n" % one for one in headers)))
    with contextlib.suppress(h11.RemoteProtocolError, NotAnswered):
        request = asked.next_event()
        if isinstance(request, h11.Request):
            read = as_websockets_reads(as_get(request))
            assert read.path.encode("ascii", "surrogateescape") == request.target
            assert len(read.headers) <= len(request.headers)
