"""The page's command: it checks its options, then serves pages until a signal."""

import contextlib
import faulthandler
import logging
import os
import signal
import sys
import threading
import webbrowser
from queue import Empty, SimpleQueue

from viewimit.loop.session import Session
from viewimit.processes import stop_signals

from .address import address, invite, is_loopback, require_free
from .limits import ServerOptions
from .pages import serving

LOG_FORMAT = "%(asctime)s %(message)s"
STOPS_WITHIN = 9.0  # s, and then it is ended
HANGS_AFTER = 20  # s without a round of the scheduler: whatever started the server starts it again
log = logging.getLogger(__name__)


def serve(options: ServerOptions, port: int = 8080, open_browser: bool = False) -> None:
    """Serve the page until SIGINT, SIGTERM, or until its terminal is closed. port 0 takes a free one. Raises ValueError
    for settings that cannot be, PortInUse for a port that is taken."""
    host = options.host
    Session(options.settings)  # bad settings must fail here, not in every visitor's tab
    require_free(host, port)
    logging.basicConfig(format=LOG_FORMAT)
    stopped: SimpleQueue[None] = SimpleQueue()  # whose put is safe in a signal handler
    for number in stop_signals():
        signal.signal(number, lambda *_: stopped.put(None))
    ending = threading.Timer(STOPS_WITHIN, _end)
    ending.daemon = True
    with contextlib.ExitStack() as stack:
        stack.callback(ending.cancel)
        stack.callback(faulthandler.cancel_dump_traceback_later)
        port = stack.enter_context(serving(options, port, _watch_for_hang))
        url = address(host, port)
        print(f"viewimit is listening on {url}", flush=True)
        if not is_loopback(host):
            invite(host, port)
        if open_browser:
            webbrowser.open(url)
        while True:  # a signal that the system hands to another thread is seen at the next turn
            with contextlib.suppress(Empty):
                stopped.get(timeout=0.5)
                break
        ending.start()


def _watch_for_hang() -> None:
    """End the process with a traceback unless this is called again in time. At a terminal, Ctrl-Z may stop it."""
    if not sys.stderr.isatty():
        faulthandler.dump_traceback_later(HANGS_AFTER, exit=True)


def _end() -> None:
    log.warning("the server does not end by itself, and is ended")
    os._exit(1)


def usual_per_address(host: str, max_clients: int) -> int:
    """Tabs that one address may have: all on this machine, where a proxy may stand; else a tenth is left for others."""
    return max_clients if is_loopback(host) else max_clients - max_clients // 10
