"""What a client sends is a line of the log that is bounded, and no traceback; a connection has few of them."""

import contextlib
import os
import resource
import socket

import msgspec
import pytest
from protocol import Client
from serving import Server
from test_seats import place_of
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
