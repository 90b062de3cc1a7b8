"""The page's command: it checks its options, then serves pages until a signal."""

import contextlib
import logging
import os
import signal
import sys
import threading
import webbrowser
from dataclasses import replace

from viewimit.loop.session import Session
from viewimit.processes import stop_signals, usable_cores

from .address import address, invite, is_loopback, listen, require_free
from .limits import ServerOptions
from .processes import LOG_FORMAT, Termination, supervised
from .seats import Seats

__all__ = ["ServerOptions", "serve", "usual_per_address", "usual_workers"]

MOST_WORKERS = 4  # by default
STOPS_WITHIN = 9.0  # s, and then it is ended
log = logging.getLogger(__name__)


def serve(
    host: str = "127.0.0.1", port: int = 8080, options: ServerOptions | None = None, open_browser: bool = False
) -> None:
    """Serve the page until SIGINT, SIGTERM, or until its terminal is closed. port 0 takes a free one.

    Raises ValueError for settings that cannot be, PortInUse for a port that is taken, RuntimeError if the
    processes of the server do not begin.
    """
    options = replace(options or ServerOptions(), host=host)
    Session(options.settings)  # bad settings must fail here, not in every visitor's tab
    if options.workers > 1 and not can_share_a_port():
        raise ValueError(f"{options.workers} workers cannot share a port on Windows: take 1")
    require_free(host, port)
    logging.basicConfig(format=LOG_FORMAT)
    stopped = Termination()
    for number in stop_signals():
        signal.signal(number, lambda *_: stopped.set())
    ending = threading.Timer(STOPS_WITHIN, _end)
    ending.daemon = True
    with contextlib.ExitStack() as stack:
        stack.callback(ending.cancel)
        if options.workers > 1:
            listeners = listen(host, port)
            port = listeners[0].getsockname()[1]
            stack.enter_context(supervised(options, listeners, stopped))
        else:
            from .pages import serving  # what only supervises need not load viser

            port = stack.enter_context(serving(options, Seats(), port=port))
        url = address(host, port)
        print(f"viewimit is listening on {url}", flush=True)
        if not is_loopback(host):
            invite(host, port)
        if open_browser:
            webbrowser.open(url)
        while not stopped.wait(0.5):  # a signal that the system hands to another thread is seen at the next turn
            pass
        ending.start()


def _end() -> None:
    log.warning("the server does not end by itself, and is ended")
    os._exit(1)


def usual_workers(host: str) -> int:
    """One process where only this machine comes, else one a core, up to MOST_WORKERS."""
    if is_loopback(host) or not can_share_a_port():
        return 1
    return min(usable_cores(), MOST_WORKERS)


def usual_per_address(host: str, max_clients: int) -> int:
    """Tabs that one address may have: all where only this machine comes, on which a proxy may stand.

    Else a class behind one router needs most, and a tenth is left for who comes from elsewhere.
    """
    return max_clients if is_loopback(host) else max_clients - max_clients // 10


def can_share_a_port() -> bool:
    """Whether processes can accept from one inherited socket: on Windows, asyncio cannot."""
    return sys.platform != "win32"
