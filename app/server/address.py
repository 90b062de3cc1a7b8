"""Where the server listens, what others type to reach it, and which pages may connect."""

import contextlib
import errno
import io
import ipaddress
import re
import socket
import sys
import threading
from collections.abc import Collection
from functools import cache
from urllib.parse import parse_qs, urlsplit

import segno

OF_DOCUMENTATION = {socket.AF_INET: "192.0.2.1", socket.AF_INET6: "2001:db8::1"}  # reserved: RFC 5737, RFC 3849
PATH = re.compile(r"(/[\w.~-]{1,60}){0,6}", re.ASCII)
PORTS = {"http": 80, "https": 443}
BACKLOG = 100  # connections that wait to be accepted
NAME = re.compile(r"[\w.-]{1,253}", re.ASCII)  # of a machine, as browsers send it


def is_own_page(origin: str, host: str, allowed: Collection[str]) -> bool:
    """origin, host: the headers of a handshake; allowed: origins elsewhere that are trusted. A page of another site
    could reach this server under a name of its own that it has let point here (DNS rebinding); its Origin and Host
    agree then, so the name itself must be known: an address, or this machine's."""
    origin = origin.lower().rstrip("/")
    if origin in {other.lower().rstrip("/") for other in allowed}:
        return True
    try:
        page = urlsplit(origin)
        asked = urlsplit(f"//{host.lower()}")
        scheme_port = PORTS[page.scheme]
        same = page.hostname == asked.hostname and (page.port or scheme_port) == (asked.port or scheme_port)
    except (ValueError, KeyError):
        return False
    name = page.hostname
    return same and name is not None and (_is_address(name) or name in own_names())


def path_of_page(target: str) -> str:
    """Return the path below which a proxy serves the page, "" for none: its websocket's address says it, as ?at=/x/."""
    path = parse_qs(urlsplit(target).query).get("at", [""])[0].rstrip("/")
    return path if PATH.fullmatch(path) else ""


def require_origin(text: str) -> None:
    """Raises ValueError for what no browser sends as an origin: it begins with a scheme and ends with host or port."""
    try:
        page = urlsplit(text.lower())
        name, plain = page.hostname or "", page.username is None and page.path in ("", "/")
        known = page.scheme in PORTS and page.port != 0 and plain and not (page.query or page.fragment)
        known = known and (_is_address(name) or NAME.fullmatch(name) is not None)
    except ValueError:
        known = False
    if not known:
        raise ValueError(f"{text!r} is no origin: say the scheme, host and no path, such as https://class.example.org")


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def is_loopback(host: str) -> bool:
    """Whether only this machine reaches what listens there."""
    return host == "localhost" or _is_address(host) and ipaddress.ip_address(host).is_loopback


@cache
def own_names() -> set[str]:
    """Return the names of this machine; its full one follows once the resolver has answered, after seconds at times."""
    name = socket.gethostname().lower()
    names = {"localhost", name, f"{name}.local"}
    threading.Thread(target=lambda: names.add(socket.getfqdn().lower()), name="viewimit-name", daemon=True).start()
    return names


def lan_address(family: socket.AddressFamily = socket.AF_INET) -> str | None:
    """Return the address of a family under which others reach this machine; None without a network. Nothing is sent."""
    try:
        probe = socket.socket(family, socket.SOCK_DGRAM)
    except OSError:  # a system without IPv6
        return None
    with probe:
        try:
            probe.connect((OF_DOCUMENTATION[family], 9))  # tells only the way out
        except OSError:
            return None
        address = probe.getsockname()[0]
    return None if ipaddress.ip_address(address).is_loopback else address


PORTS_TO_TRY = 100
EVERYWHERE = {"0.0.0.0": socket.AF_INET, "::": socket.AF_INET6}  # hosts, and the addresses that they listen on


class PortInUse(OSError):
    """The port is taken; the message names the next free one."""


def listen(host: str, port: int) -> list[socket.socket]:
    """Listening sockets on all addresses of a name. port 0 takes a free one. Raises OSError."""
    listeners: list[socket.socket] = []
    for family, *_, place in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE):
        chosen = listeners[0].getsockname()[1] if listeners else port
        listeners.append(_bind(family, (place[0], chosen, *place[2:])))
        listeners[-1].listen(BACKLOG)
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
        family, *_, place = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
        _bind(family, place).close()
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            return False
        raise OSError(f"cannot listen on {host}, port {port}: {error.strerror}") from None
    return True


def _bind(family: int, place: tuple) -> socket.socket:
    """Return a socket with a port that may have been left lately, but at which no program listens."""
    bound = socket.socket(family, socket.SOCK_STREAM)
    try:
        if sys.platform == "win32":  # where SO_REUSEADDR would take the port of a program that listens
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_EXCLUSIVEADDRUSE, 1)
        else:
            bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if family == socket.AF_INET6:
            bound.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 1)
        bound.bind(place)
    except OSError:
        bound.close()
        raise
    return bound


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
    print(f"others open {url}, which nothing encrypts: anybody on this network can")
    print_qr(url)


def print_qr(url: str) -> None:
    drawn = io.StringIO()
    segno.make(url, micro=False).terminal(drawn, compact=True)
    with contextlib.suppress(UnicodeEncodeError):  # a terminal without block characters has the address
        drawn.getvalue().encode(sys.stdout.encoding or "utf-8")  # for print would put ? in their place
        print(drawn.getvalue(), flush=True)
