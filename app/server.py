"""The server: one viser server, one page a browser tab, one scheduler for all."""

import contextlib
import errno
import gc
import html
import io
import logging
import signal
import socket
import threading
import webbrowser
from collections.abc import Sequence
from functools import cache

import segno
import viser

from viewimit.session import Session
from viewimit.snapshot import Settings

from . import experiments_tab, help, learner_bars, plots, theme, verdict, wire
from .arms import share_meshes
from .camera_process import CameraProcess
from .door import Door
from .experiment_worker import ExperimentWorker
from .keeper import Keeper
from .landscape_worker import LandscapeWorker
from .origins import is_loopback, lan_address
from .page import Page
from .resume import Seats
from .scene3d import share_scene
from .scheduler import Scheduler
from .store import Store, open_store

PORTS_TO_TRY = 100


class PortInUse(OSError):
    """The port is taken; the message names the next free one."""


def serve(
    host: str = "127.0.0.1",
    port: int = 8080,
    settings: Settings | None = None,
    store: Store | None = None,
    max_clients: int = 40,
    open_browser: bool = False,
    origins: Sequence[str] = (),
) -> None:
    """Serve the page until SIGINT or SIGTERM. port 0 takes a free one.

    store: where sessions are kept, by default the user's own folder; it is closed in the end. origins: of pages
    elsewhere that may connect, such as https://class.example.org of a proxy.
    Raises ValueError for settings that cannot be, PortInUse for a port that is taken.
    """
    settings = settings or Settings()
    Session(settings)  # bad settings must fail here, not in every visitor's tab
    require_free(host, port)
    logging.basicConfig(format="%(asctime)s %(message)s")
    keeper = Keeper(store or open_store())
    scheduler = Scheduler()
    door = Door(max_clients, origins, scheduler.health)
    with contextlib.redirect_stdout(io.StringIO()), wire.serving_with(door.serve):  # viser prints a banner of its own
        server = viser.ViserServer(host=host, port=port, label="viewimit", verbose=False)
    app = App(server, settings, scheduler, keeper)
    door.guard(server)
    stopped = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    url = address(host, server.get_port())
    print(f"viewimit is listening on {url}", flush=True)
    if not is_loopback(host):
        invite(host, server.get_port())
    if open_browser:
        webbrowser.open(url)
    while not stopped.wait(0.5):  # a signal that the system hands to another thread is seen at the next turn
        pass
    app.stop()
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


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
        print(drawn.getvalue(), flush=True)


class App:
    """Pages by client id. viser's threads connect and disconnect, its event loop draws."""

    def __init__(self, server: viser.ViserServer, settings: Settings, scheduler: Scheduler, keeper: Keeper):
        self._server, self._settings, self._scheduler, self._keeper = server, settings, scheduler, keeper
        self._pages: dict[int, tuple[Page, str | None]] = {}  # and the keys under which they are kept
        self._seats = Seats(server, keeper, settings, self._retire)
        self._lock, self._retiring = threading.Lock(), threading.RLock()  # of the pages; while one is being kept
        self._collecting = threading.Lock()
        self._worker, self._experiments, self._camera = LandscapeWorker(), ExperimentWorker(), CameraProcess()
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        css = "".join(part.CSS for part in (theme, learner_bars, help, plots, verdict, experiments_tab))
        server.gui.add_html(f"<style>{css}</style>")
        share_scene(server)
        self._share_opponent = cache(lambda: share_meshes(server, "opponent"))  # its meshes wait for the first duel
        server.on_client_connect(self._connect)
        server.on_client_disconnect(self._disconnect)
        self._scheduler.start(wire.loop_of(server))

    def stop(self) -> None:
        """Nothing moves any more, and all that the visitors did is kept."""
        self._scheduler.stop()
        self._camera.stop()
        with self._retiring:
            for client_id in list(self._pages):
                self._retire(client_id)
            self._keeper.stop()
        self._experiments.stop()

    def _connect(self, client: viser.ClientHandle) -> None:
        key, resumed = self._seats.take(client)
        keep = (lambda memory: self._keeper.keep(key, memory)) if key else (lambda memory: None)
        shared = self._worker, self._experiments, self._camera, self._share_opponent, self._settings
        try:
            page = Page(client, *shared, keep, self._scheduler.load, resumed)
        except (ValueError, OSError) as error:  # a scene or URDF of the user's that has changed meanwhile
            client.gui.add_html(f"<p>This page cannot be shown: {html.escape(str(error))}</p>")
            if key:
                self._seats.leave(key)
            return
        with self._lock:
            self._pages[client.client_id] = page, key
            self._scheduler.add(page)
        if client.client_id not in self._server.get_clients():  # it closed before this callback ran
            self._retire(client.client_id)

    def _disconnect(self, client: viser.ClientHandle) -> None:
        self._retire(client.client_id)
        if self._collecting.acquire(blocking=False):  # one for all of a class that leaves at once
            try:
                gc.collect()  # viser's handles are reference cycles
            finally:
                self._collecting.release()

    def _retire(self, client_id: int) -> None:
        """Keep what the page is, and forget it."""
        with self._retiring:
            with self._lock:
                page, key = self._pages.pop(client_id, (None, None))
            if page is None:
                return
            self._scheduler.remove(page)
            self._worker.forget(client_id)
            self._experiments.forget(client_id)
            whole = page.close()
            if key is not None:
                if whole:  # else what was handed over some seconds ago stays
                    self._keeper.keep(key, page.memory())
                self._keeper.forget(key)
                self._seats.leave(key)
