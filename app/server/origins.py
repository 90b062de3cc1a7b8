"""Which pages may connect: those that this server itself has served, under a name that cannot be someone else's."""

import ipaddress
import re
import socket
import threading
from collections.abc import Collection
from functools import cache
from urllib.parse import urlsplit

OF_DOCUMENTATION = {socket.AF_INET: "192.0.2.1", socket.AF_INET6: "2001:db8::1"}  # reserved: RFC 5737, RFC 3849
PORTS = {"http": 80, "https": 443}
NAME = re.compile(r"[\w.-]{1,253}", re.ASCII)  # of a machine, as browsers send it


def is_own_page(origin: str, host: str, allowed: Collection[str]) -> bool:
    """origin, host: the headers of a handshake; allowed: origins elsewhere that are trusted.

    A page of another site could reach this server under a name of its own that it has let point here
    (DNS rebinding); its Origin and Host agree then, so the name itself must be known: an address, or this machine's.
    """
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


def require_origin(text: str) -> None:
    """Raises ValueError for what no browser sends as an origin: it begins with a scheme and ends with host or port."""
    try:
        page = urlsplit(text.lower())
        known = page.scheme in PORTS and bool(page.hostname) and (page.port is None or page.port > 0)
    except ValueError:
        known = False
    else:
        known = known and page.username is None and page.path in ("", "/") and not (page.query or page.fragment)
        known = known and (_is_address(page.hostname or "") or NAME.fullmatch(page.hostname or "") is not None)
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
    """Return the names of this machine; its full one is added once the network has told it, which may take seconds."""
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
