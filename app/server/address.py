"""Where the server listens, and what others type to reach it."""

import contextlib
import errno
import io
import socket
import sys
from urllib.parse import urlsplit

import segno

from .origins import PORTS, is_loopback, lan_address

PORTS_TO_TRY = 100
EVERYWHERE = {"0.0.0.0": socket.AF_INET, "::": socket.AF_INET6}  # hosts, and the addresses that they listen on
BACKLOG = 100  # connections that wait to be accepted


class PortInUse(OSError):
    """The port is taken; the message names the next free one."""


def listen(host: str, port: int) -> list[socket.socket]:
    """Listening sockets on all addresses of a name. port 0 takes a free one. Raises OSError."""
    listeners: list[socket.socket] = []
    for family, *_, place in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE):
        listener = socket.socket(family, socket.SOCK_STREAM)
        _claim(listener)
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
            _claim(probe)
            probe.bind(address)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            return False
        raise OSError(f"cannot listen on {host}, port {port}: {error.strerror}") from None
    return True


def _claim(listener: socket.socket) -> None:
    """Let it bind a port that was left lately, but none at which a program listens."""
    if sys.platform == "win32":  # where SO_REUSEADDR would take the port of a program that listens
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
    else:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)


def address(host: str, port: int) -> str:
    """What to type into a browser on this machine."""
    shown = "localhost" if host in EVERYWHERE else f"[{host}]" if ":" in host else host
    return f"http://{shown}:{port}"


def address_for_others(host: str, port: int) -> str | None:
    """What to type elsewhere on the network; None where nobody there can reach it."""
    reached = lan_address(EVERYWHERE[host]) if host in EVERYWHERE else None if is_loopback(host) else host
    return None if reached is None else address(reached, port)


def origin_for_others(host: str, origin: str | None) -> str | None:
    """The same for a page that a browser has at this origin, which may be a proxy's: the origin itself, unless only
    this machine knows its name."""
    if origin is None:
        return None
    page = urlsplit(origin)
    name = page.hostname or ""
    if not is_loopback(name) and ("." in name or ":" in name):
        return origin
    return address_for_others(host, page.port or PORTS[page.scheme])


def invite(host: str, port: int) -> None:
    """Print what others on the network may open, for typing and for a phone's camera."""
    url = address_for_others(host, port)
    if url is None:
        print("no network that others could reach it by", flush=True)
        return
    drawn = io.StringIO()
    segno.make(url, micro=False).terminal(drawn, compact=True)
    print(f"others open {url}, which nothing encrypts: anybody on this network can")
    with contextlib.suppress(UnicodeEncodeError):  # a terminal without block characters has the address
        drawn.getvalue().encode(sys.stdout.encoding or "utf-8")  # for print would put ? in their place
        print(drawn.getvalue(), flush=True)
