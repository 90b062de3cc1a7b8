"""Seats and connections that are held by who does nothing with them: they come back, and newcomers find room."""

import contextlib
import socket

import msgspec
import pytest
import viser
from protocol import VIEW, Client
from serving import Here, Server
from viewimit.app.server import web
from viewimit.app.server.limits import PENDING, Limits, PendingConnections, network_of
from waiting import stays, wait_until
from websockets.exceptions import InvalidStatus

HANDSHAKE = (
    "GET / HTTP/1.1\r\nHost: {host}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
    f"Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\nSec-WebSocket-Protocol: viser-v{viser.__version__}\r\n\r\n"
)
FIRST_VIEW = msgspec.msgpack.encode(VIEW)


def place_of(url: str) -> tuple[str, int]:
    host, port = url.removeprefix("http://").rsplit(":", 1)
    return host, int(port)


def connected(url: str, source: str = "127.0.0.1", unread: int = 4096) -> socket.socket:
    """A connection whose system keeps so many bytes of what is not read."""
    client = socket.socket()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, unread)
    client.bind((source, 0))
    client.settimeout(10)
    client.connect(place_of(url))
    return client


def deaf(url: str, unread: int = 4096) -> socket.socket:
    """A websocket that never answers a ping."""
    client = connected(url, unread=unread)
    client.sendall(HANDSHAKE.format(host=url.removeprefix("http://")).encode())
    return client


@pytest.fixture
def here():
    made = []

    def begin(limits: Limits) -> Here:
        made.append(Here(limits))
        return made[0]

    yield begin
    for server in made:
        server.stop()


def framed(payload: bytes) -> bytes:
    """A binary frame of a client, masked with zeros."""
    size = len(payload)
    return b"\x82" + (bytes([0x80 | size]) if size < 126 else b"\xfe" + size.to_bytes(2, "big")) + bytes(4) + payload


def test_seats_of_clients_that_send_nothing_and_read_nothing_are_free_again(here):
    server = here(Limits(seats_of_one=40, page_within=0.5, closed_within=0.3))
    with contextlib.ExitStack() as held:
        clients = [held.enter_context(deaf(server.url)) for _ in range(40)]
        assert all(client.recv(12) == b"HTTP/1.1 101" for client in clients)  # though the first may have left again
        wait_until(lambda: not server.access.seats, 15)
        with Client(server.url).ready() as newcomer:
            assert newcomer.closed(0) is None


@pytest.mark.skipif(not hasattr(socket, "TCP_USER_TIMEOUT"), reason="the system has no such limit")
def test_a_tab_that_stops_reading_is_left_and_a_slow_one_is_not(here, monkeypatch):
    monkeypatch.setattr(web, "TAKES_WITHIN", 2000)
    server = here(Limits(ping_every=60))
    with deaf(server.url) as asleep, deaf(server.url, 1 << 16) as slow:
        for client in (asleep, slow):
            client.sendall(framed(FIRST_VIEW))
        slow.settimeout(0.01)

        def reads_on() -> bool:
            with contextlib.suppress(TimeoutError):
                return bool(slow.recv(10_000))
            return True

        wait_until(lambda: reads_on() and len(server.access.seats) == 2)  # before a page is there, on a busy machine
        wait_until(lambda: reads_on() and len(server.access.seats) == server.pages == 1)
        stays(lambda: reads_on() and len(server.access.seats) == 1, 3)


def test_who_never_ends_the_head_of_a_request_is_closed(here):
    server = here(Limits(head_within=0.3, closed_within=0.3))
    with connected(server.url) as half, connected(server.url) as silent:
        half.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")
        for client in (half, silent):
            with contextlib.suppress(ConnectionResetError):
                assert client.recv(1) == b""


def test_the_oldest_of_an_address_that_has_too_many_goes_else_the_oldest_of_all():
    gone = []
    pending = PendingConnections(4, 2)
    for name, address in (("a1", 1), ("b1", 2), ("b2", 2), ("b3", 2), ("c1", 3), ("d1", 4)):
        pending.add(name, address, lambda name=name: gone.append(name))
    assert gone == ["b1", "a1"] and len(pending) == 4
    pending.discard("b2")
    pending.discard("b2")
    assert len(pending) == 3


def test_silent_connections_lock_nobody_out():
    server = Server()
    with contextlib.ExitStack() as held:
        for _ in range(PENDING + 5):
            held.enter_context(socket.create_connection(place_of(server.url)))
        with Client(server.url).ready() as newcomer:
            assert newcomer.closed(0) is None
    assert server.stop() == 0


def test_an_address_has_so_many_seats_and_others_have_the_rest():
    server = Server("--max-clients", "6", "--max-per-address", "3", "--host", "0.0.0.0")
    port = server.url.rsplit(":", 1)[1]
    url = f"http://127.0.0.1:{port}"
    clients = [Client(url) for _ in range(3)]
    with server.says("its address has 3 already"), pytest.raises(InvalidStatus) as refused:
        Client(url)
    assert refused.value.response.status_code == 429
    with connected(url, "127.0.0.2") as elsewhere:
        elsewhere.sendall(HANDSHAKE.format(host=f"127.0.0.1:{port}").encode())
        assert elsewhere.recv(12) == b"HTTP/1.1 101"
        wait_until(lambda: server.seated == 4)
    with connected(url) as page:
        page.sendall(b"GET / HTTP/1.1\r\nHost: here\r\n\r\n")
        assert page.recv(12) == b"HTTP/1.1 429"
    clients.pop().close()
    wait_until(lambda: server.seated == 2)
    clients.append(Client(url))
    for client in clients:
        client.close()
    assert server.stop() == 0


@pytest.mark.parametrize(
    "one, other, same",
    [
        ("192.0.2.1", "192.0.2.1", True),
        ("192.0.2.1", "192.0.2.2", False),
        ("192.0.2.1", "::ffff:192.0.2.1", True),
        ("2001:db8::1", "2001:db8::ffff:2", True),  # of one network
        ("2001:db8:0:1::1", "2001:db8:0:2::1", False),
        ("fe80::1%eth0", "fe80::2%eth0", False),
        ("::1", "::1", True),
    ],
)
def test_an_address_is_one_machine_or_the_network_it_can_choose_its_own_from(one, other, same):
    assert (network_of((one, 1)) == network_of((other, 2))) is same
    assert network_of((one, 1)) and network_of(None)
