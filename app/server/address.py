"""Where the server listens, and what others type to reach it."""

import contextlib
import errno
import io
import socket
import sys

import segno

from .lecturer import ROOT as LECTURER
from .origins import lan_address

PORTS_TO_TRY = 100
BACKLOG = 100  # connections that wait to be accepted


class PortInUse(OSError):
    """The port is taken; the message names the next free one."""


def listen(host: str, port: int) -> list[socket.socket]:
    """Listening sockets on all addresses of a name. port 0 takes a free one. Raises OSError."""
    listeners: list[socket.socket] = []
    for family, *_, place in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE):
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if family == socket.AF_INET6:
            listener.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        chosen = listeners[0].getsockname()[1] if listeners else port
        listener.bind((place[0], chosen, *place[2:]))
        listener.listen(BACKLOG)
        listeners.append(listener)
    return listeners


def require_free(host: str, port: int) -> None:
    """Raise PortInUse if another program listens there, OSError if this machine has no such address."""
    if _is_free(host, port):
        return
    following = range(port + 1, min(port + 1 + PORTS_TO_TRY, 65536))
    free = next((other for other in following if _is_free(host, other)), None)
    offer = f"; try --port {free}, which is free" if free else ""
    raise PortInUse(f"port {port} on {host} is in use{offer}")


def _is_free(host: str, port: int) -> bool:
    try:
        family, _, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            return False
        raise OSError(f"cannot listen on {host}, port {port}: {error.strerror}") from None
    return True


def address(host: str, port: int) -> str:
    """What to type into a browser on this machine."""
    shown = {"0.0.0.0": "localhost", "::": "localhost"}.get(host, f"[{host}]" if ":" in host else host)
    return f"http://{shown}:{port}"


def invite_lecturer(host: str, port: int, secret: str) -> None:
    """Print what who leads the class opens. To standard output alone: it is no line of a log."""
    print(f"the lecturer opens {address(host, port)}{LECTURER}{secret}\nand shows it to nobody", flush=True)


def invite(host: str, port: int) -> None:
    """Print what others on the network may open, for typing and for a phone's camera."""
    reached = lan_address() if host in ("0.0.0.0", "::") else host
    if reached is None:
        print("no network that others could reach it by", flush=True)
        return
    url = address(reached, port)
    drawn = io.StringIO()
    segno.make(url, micro=False).terminal(drawn, compact=True)
    print(f"others open {url}, which nothing encrypts: anybody on this network can")
    with contextlib.suppress(UnicodeEncodeError):  # a terminal without block characters has the address
        drawn.getvalue().encode(sys.stdout.encoding or "utf-8")  # for print would put ? in their place
        print(drawn.getvalue(), flush=True)
