"""Starting: what can go wrong is said before a server runs."""

import io
import socket
import sys

import pytest
from protocol import Client
from viewimit.app.server import address as address_module
from viewimit.app.server.address import PortInUse, address_for_others, invite, is_loopback, path_of_page, require_free
from waiting import wait_until


def test_a_taken_port_is_named_with_the_next_free_one():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(PortInUse, match=rf"port {port} .* in use; try --port \d+"):
            require_free("127.0.0.1", port)
    with pytest.raises(OSError, match=r"^cannot listen on 192\.0\.2\.1, port 8080: [^()]+$"):
        require_free("192.0.2.1", 8080)


@pytest.mark.parametrize(
    "target, path",
    [
        ("/", ""),
        ("/?at=%2Fx%2F", "/x"),
        ("/?at=/courses/2026_a/", "/courses/2026_a"),
        ("/?at=//evil.example/", ""),
        ("/?at=/x/%22onclick=1/", ""),
        ("/?at=x/", ""),
        ("/?at=" + 9 * "/x", ""),
        ("/?at=%ff", ""),
    ],
)
def test_the_path_of_a_page_below_a_proxys_is_as_its_websocket_says_it(target, path):
    assert path_of_page(target) == path


def test_a_page_below_a_path_shares_links_to_itself(server):
    with Client(f"{server}/?at=%2Fx%2F", origin=server).ready() as client:
        client.press(next(command for command in client.commands if command.startswith("A link")))
        wait_until(lambda: any(f"{server}/x/?preset=paper" in html for html in client.html.values()))
        assert not any(f"{server}/?preset=" in html for html in client.html.values())


def test_others_are_told_an_address_of_the_kind_that_the_server_listens_on(monkeypatch):
    of_this_machine = {socket.AF_INET: "192.0.2.9", socket.AF_INET6: "2001:db8::9"}
    monkeypatch.setattr(address_module, "lan_address", of_this_machine.get)
    assert address_for_others("0.0.0.0", 8080) == "http://192.0.2.9:8080"
    assert address_for_others("::", 8080) == "http://[2001:db8::9]:8080"
    assert address_for_others("::1", 8080) is address_for_others("127.0.0.1", 8080) is None


def test_who_lets_others_in_is_told_the_address_and_shown_its_code(capsys, monkeypatch):
    invite("192.0.2.7", 8080)
    text, *drawn = capsys.readouterr().out.splitlines()
    assert "http://192.0.2.7:8080" in text
    code = [line for line in drawn if line]
    assert len(code) > 10 and set("".join(code)) <= set(" ▀▄█")
    lacking = io.TextIOWrapper(io.BytesIO(), "ascii", "replace")
    monkeypatch.setattr(sys, "stdout", lacking)
    invite("192.0.2.7", 8080)
    lacking.flush()
    assert lacking.buffer.getvalue().decode().splitlines() == [text]
    assert [is_loopback(host) for host in ("127.0.0.1", "::1", "localhost", "0.0.0.0", "192.0.2.7")] == [
        True, True, True, False, False,
    ]  # fmt: skip
