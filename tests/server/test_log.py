"""What a client sends is a line of the log that is bounded, and no traceback; a connection has few of them."""

import contextlib
import os
import resource
import socket

import msgspec
import pytest
from protocol import Client
from serving import Server
from test_seats import HANDSHAKE, connected, framed, place_of
from waiting import stays, wait_until

LONGEST = 450  # characters of a line


@pytest.fixture(scope="module")
def logging_server():
    server = Server()
    yield server
    assert server.stop() == 0


@contextlib.contextmanager
def few_lines(server: Server, at_least: int, at_most: int, *clients: socket.socket):
    """Inside, it writes so many lines about these connections, none of them long or of a traceback."""
    before, ports = len(server.lines), {client.getsockname()[1] for client in clients}
    yield
    wait_until(lambda: len(server.lines_about(ports, before)) >= at_least)
    stays(lambda: len(server.lines_about(ports, before)) <= at_most, 0.3)
    said = server.lines_about(ports, before)
    assert all(len(line) < LONGEST for line in said) and not any("Traceback" in line for line in said), said


def nested(depth: int) -> bytes:
    return b"\x91" * depth + b"\x00"


def test_refusals_of_one_connection_are_few_lines(logging_server):
    with Client(logging_server.url).ready() as client:
        with few_lines(logging_server, 2, 30, client.socket.socket):
            for _ in range(60):
                client.put("θ₂", "x")
            assert client.closed()[0] == 1008


@pytest.mark.parametrize("depth", [50, 400, 900, 982, 1000, 5000])
def test_nesting_of_any_depth_is_a_line(logging_server, depth):
    with Client(logging_server.url).ready() as client:
        uuid = client.widgets["θ₂"]
        head = msgspec.msgpack.encode({"type": "GuiUpdateMessage", "uuid": uuid})[1:]
        with few_lines(logging_server, 1, 1, client.socket.socket):
            client.send(b"\x83" + head + b"\xa7updates\x81\xa5value" + nested(depth))


@pytest.mark.parametrize(
    "frame", [framed(b"\x81\xa4type\xa1\xff"), framed(b"\x81\xa1\xff\x00"), b"\x81\x81" + bytes(4) + b"\xff"]
)
def test_bytes_that_are_no_text_are_a_line_at_most(logging_server, frame):
    with connected(logging_server.url, unread=1 << 20) as client, few_lines(logging_server, 0, 1, client):
        client.sendall(HANDSHAKE.format(host=logging_server.url[7:]).encode() + frame)
        while client.recv(1 << 16):
            pass


def test_a_long_version_is_not_written_whole(logging_server):
    head = HANDSHAKE.format(host=logging_server.url[7:]).replace("viser-v", "viser-v" + 4000 * "9")
    with connected(logging_server.url, unread=1 << 16) as client, few_lines(logging_server, 1, 1, client):
        client.sendall(head.encode())
        received = b""
        while data := client.recv(1 << 16):
            received += data
        assert b"Version mismatch. Client: 999" in received


def test_two_hosts_are_a_line(logging_server):
    with connected(logging_server.url) as client, few_lines(logging_server, 1, 1, client):
        client.sendall(b"GET /health HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n")
        assert client.recv(1 << 16).startswith(b"HTTP/1.1 400 ")


def test_who_asks_for_nothing_is_no_line(logging_server):
    clients = [connected(logging_server.url) for _ in range(20)]
    with few_lines(logging_server, 0, 0, *clients):
        for client in clients:
            client.close()


@pytest.mark.skipif(not hasattr(resource, "prlimit"), reason="needs prlimit")
def test_a_server_without_file_descriptors_says_it_in_few_lines():
    server = Server()
    most = len(os.listdir(f"/proc/{server.process.pid}/fd")) + 3
    _, hard = resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE)
    resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (most, hard))
    before = len(server.lines)
    with contextlib.ExitStack() as held, few_lines(server, 1, 99):
        for _ in range(20):
            held.enter_context(socket.create_connection(place_of(server.url)))
        stays(lambda: len(server.lines) - before <= 9, 3)
    resource.prlimit(server.process.pid, resource.RLIMIT_NOFILE, (hard, hard))
    assert server.stop() == 0
