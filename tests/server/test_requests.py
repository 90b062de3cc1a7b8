"""Requests of browsers, proxies and monitors are answered; what is no request ends without harm."""

import contextlib
import socket

import pytest
from serving import Server
from test_seats import HANDSHAKE, place_of


@pytest.fixture(scope="module")
def serving():
    server = Server()
    yield server
    assert server.stop() == 0


def received(url: str, request: bytes) -> bytes:
    """All that comes back until the server ends the connection."""
    came = b""
    with socket.create_connection(place_of(url), timeout=20) as client, contextlib.suppress(ConnectionError):
        client.sendall(request)
        while data := client.recv(1 << 16):
            came += data
    return came


def answer_to(url: str, request: bytes) -> tuple[int, dict[str, str], bytes]:
    """Status, headers and body."""
    head, _, body = received(url, request).partition(b"\r\n\r\n")
    status, *lines = head.decode().split("\r\n")
    return int(status.split()[1]), dict(line.split(": ", 1) for line in lines), body


HOST = "Host: 127.0.0.1\r\n"
ANSWERED = {
    "GET": ("GET / HTTP/1.1\r\n" + HOST, 200),
    "HEAD": ("HEAD / HTTP/1.1\r\n" + HOST, 200),
    "GET of HTTP/1.0": ("GET / HTTP/1.0\r\n", 200),
    "health": ("GET /health HTTP/1.1\r\n" + HOST, 200),
    "HEAD of health": ("HEAD /health HTTP/1.1\r\n" + HOST, 200),
    "HTTP/1.0 of health": ("GET /health HTTP/1.0\r\n", 200),
    "HEAD of HTTP/1.0 of health": ("HEAD /health HTTP/1.0\r\n", 200),
    "no such file": ("GET /nothing HTTP/1.1\r\n" + HOST, 404),
    "no such file, its head": ("HEAD /nothing HTTP/1.1\r\n" + HOST, 404),
    "a name that no file has": (f"GET /{'a' * 3000} HTTP/1.1\r\n" + HOST, 404),
    "two origins": ("GET / HTTP/1.1\r\nOrigin: a\r\norigin: b\r\n" + HOST, 400),
    "two hosts of health": ("GET /health HTTP/1.1\r\n" + 2 * HOST, 400),
    "two hosts": ("GET / HTTP/1.1\r\n" + 2 * HOST, 400),
    "a websocket with two keys": (HANDSHAKE.format(host="a")[:-2] + "Sec-WebSocket-Key: a\r\n", 400),
    "a websocket with two origins": (HANDSHAKE.format(host="a")[:-2] + "Origin: a\r\norigin: b\r\n", 400),
    "a websocket with a bad key": (HANDSHAKE.format(host="a").replace("Key: ", "Key: x")[:-2], 400),
}
NO_REQUEST = {
    "empty lines": "\r\n" * 20_000,
    "another method": "OPTIONS / HTTP/1.1\r\n" + HOST,
    "with a body": "POST / HTTP/1.1\r\nContent-Length: 3\r\n" + HOST,
    "with chunks": "GET / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n" + HOST,
    "another language": "hello\r\n",
    "HTTP/2": "PRI * HTTP/2.0\r\n",
    "a header without a colon": "GET / HTTP/1.1\r\nHost\r\n",
    "a header with a space": "GET / HTTP/1.1\r\nHo st: a\r\n",
    "200 headers": "GET / HTTP/1.1\r\n" + HOST + "a: b\r\n" * 200,
    "a header of 10 kB": "GET / HTTP/1.1\r\n" + HOST + f"a: {'b' * 10_000}\r\n",
}


@pytest.mark.parametrize("what", ANSWERED)
def test_a_request_is_answered(serving, what):
    request, status = ANSWERED[what]
    found, headers, body = answer_to(serving.url, request.encode() + b"\r\n")
    assert found == status and headers["Connection"] == "close"
    if request.startswith("HEAD"):
        assert body == b"" and int(headers["Content-Length"]) > 0
    else:
        assert len(body) == int(headers["Content-Length"]) > 0


@pytest.mark.parametrize("what", NO_REQUEST)
def test_what_is_no_request_brings_nothing_and_harms_nobody(serving, what):
    assert b" 200 " not in received(serving.url, NO_REQUEST[what].encode() + b"\r\n")[:20]
    assert answer_to(serving.url, f"GET /health HTTP/1.1\r\n{HOST}\r\n".encode())[0] == 200
