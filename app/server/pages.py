"""A process that serves pages: one viser server, one page a browser tab, one scheduler for all."""

import asyncio
import contextlib
import gc
import html
import io
import logging
import socket
import threading
import time
from collections.abc import Iterator, Mapping
from functools import cache, partial

import viser
from websockets.asyncio.server import ServerConnection
from websockets.frames import CloseCode

from viewimit.simulation.scene import load_scene

from .. import viser_private
from ..jobs.camera_images import MOST_SESSIONS, CameraProcess
from ..jobs.experiments import ExperimentWorker
from ..jobs.landscapes import LandscapeWorker
from ..lab.lessons.format import Lesson
from ..lab.lessons.page import LabPages
from ..model.services import Services
from ..page.page import LEAVES_WITHIN, CannotResume, Page
from ..page.scheduler import Scheduler
from ..panels.panel import ClientInfo
from ..scene.arms import ALWAYS_SEEN, share_meshes
from ..scene.scene3d import share_light
from ..sessions.autosave import Autosave
from ..sessions.resume import Place, SessionKeys
from ..sessions.stores import open_store
from ..static import stylesheet
from .access import AccessControl
from .address import origin_for_others, own_names
from .limits import ServerOptions, in_a_line
from .seats import Seats

BUILT_AT_ONCE = 2  # pages: all others would wait for many more
AGAIN_AFTER = 5.0  # s, until who could not be shown a page is to try again
log = logging.getLogger(__name__)


@contextlib.contextmanager
def serving(
    options: ServerOptions,
    seats: Seats,
    process: int = 0,
    listening: socket.socket | None = None,
    port: int = 0,
) -> Iterator[int]:
    """Pages are served inside, on the port that it yields; in the end all that the visitors did is kept.

    process: which of them this one is; listening: a socket in place of host and port.
    Raises OSError for a store that cannot be used.
    """
    own_names()  # begins to ask for them
    autosave = Autosave(open_store(options.store))
    scheduler = Scheduler(seats.rows[process].live, seats.rows[process].clear)
    lab = LabPages(options.settings.scene, options.settings.robot, options.lessons)
    access = AccessControl(options.limits, options.origins, seats, process, listening, lab.page)
    with (
        contextlib.redirect_stdout(io.StringIO()),
        viser_private.serving_with(access.serve),
    ):  # viser prints a banner of its own
        server = viser.ViserServer(host=options.host, port=port, label="viewimit", verbose=False)
    app = App(server, options, scheduler, autosave, lab.lessons)
    access.guard(server)
    gc.collect()
    gc.freeze()  # what is there for good need not be looked through whenever a tab is closed
    try:
        yield server.get_port()
    finally:
        app.stop()
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


class App:
    """Pages by client id. viser's threads connect and disconnect, its event loop draws.

    lessons: of the lab, by name.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        options: ServerOptions,
        scheduler: Scheduler,
        autosave: Autosave,
        lessons: Mapping[str, Lesson],
    ):
        self._server, self._settings, self._scheduler, self._autosave = server, options.settings, scheduler, autosave
        self._host, self._lessons = options.host, lessons
        self._pages: dict[int, tuple[Page, str | None]] = {}  # and the keys under which they are kept
        self._keys = SessionKeys(server, autosave, options.settings, self._retire)
        viser_private.wake_in_loop(server)
        self._lock, self._retiring = threading.Lock(), threading.RLock()  # of the pages; while one is being kept
        self._collecting, self._building = threading.Lock(), threading.Semaphore(BUILT_AT_ONCE)
        share = cache(partial(share_meshes, server))  # what no page has shown yet waits
        camera = CameraProcess(max(MOST_SESSIONS // options.workers, 1))
        workers = LandscapeWorker(), ExperimentWorker(), camera
        self.services = Services(*workers, scheduler.shedding, share)
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.add_html(f"<style>{stylesheet()}</style>")
        share_light(server)
        for arm in ALWAYS_SEEN:
            share(load_scene(options.settings.scene, options.settings.robot).robot, arm)
        server.on_client_connect(self._connect)
        server.on_client_disconnect(self._disconnect)
        self._scheduler.start(server.get_event_loop())

    def stop(self) -> None:
        """Nothing moves any more, and all that the visitors did is kept."""
        self._scheduler.stop()
        self.services.camera.stop()
        until = time.monotonic() + LEAVES_WITHIN
        with self._retiring:
            for client_id in list(self._pages):
                self._retire(client_id, max(until - time.monotonic(), 0.0))
            self._autosave.stop()
        self.services.experiments.stop()
        self.services.basins.stop()
        self.services.scripts.stop()

    def _connect(self, client: viser.ClientHandle) -> None:
        if client.client_id not in self._server.get_clients():  # it has left while others' pages were built
            return
        viser_private.wake_in_loop(client)
        viser_private.ignore_late_pushes(client)
        place = Place()
        try:
            place = self._keys.take(client)
            with self._building, client.atomic():
                page = self._page(client, place)
        except Exception as error:  # a scene of the user's that has changed meanwhile, or what nobody foresaw
            if place.key:
                self._keys.leave(place.key)
            self._send_back(client, error)
            return
        key = place.key
        with self._lock:
            self._pages[client.client_id] = page, key
            self._scheduler.add(page)
        if client.client_id not in self._server.get_clients():  # it closed before this callback ran
            self._retire(client.client_id)

    def _send_back(self, client: viser.ClientHandle, error: Exception) -> None:
        """Who cannot be shown a page is told why. A browser whose connection is closed comes back by itself."""
        log.error(in_a_line("a page cannot be shown", error))
        connection = viser_private.connection_of(self._server, client.client_id)
        if connection is not None:
            asyncio.run_coroutine_threadsafe(_close_soon(connection), self._server.get_event_loop())
        client.gui.reset()  # of what there is of it
        why = html.escape(str(error) or type(error).__name__)
        client.gui.add_html(f"<p>This page cannot be shown: {why}. It is tried again in {AGAIN_AFTER:g} s.</p>")

    def _page(self, client: viser.ClientHandle, place: Place) -> Page:
        """What was kept goes on, or the page says why it does not."""
        key = place.key
        keep = (lambda memory: self._autosave.keep(key, memory)) if key else (lambda memory: place.problem)
        origin = viser_private.origin_of(self._server, client.client_id)
        info = ClientInfo(origin, origin_for_others(self._host, origin), self._lessons)
        try:
            page = Page(client, self.services, self._settings, keep, place.memory, info)
        except CannotResume as error:
            if key is not None:
                self._autosave.set_aside(key, str(error))
            page = Page(client, self.services, self._settings, keep, None, info)
        if key is not None and (why := self._autosave.lost(key)) is not None:
            page.say(why)
        return page

    def _disconnect(self, client: viser.ClientHandle) -> None:
        self._retire(client.client_id)
        if self._collecting.acquire(blocking=False):  # one for all of a class that leaves at once
            try:
                gc.collect()  # viser's handles are reference cycles
            finally:
                self._collecting.release()

    def _retire(self, client_id: int, within: float = LEAVES_WITHIN) -> None:
        """Keep what the page is, once its last turn has ended within so many s, and forget it."""
        with self._lock:
            _, key = self._pages.get(client_id, (None, None))
        if key is not None:
            self._autosave.leaving(key)
        with self._retiring:
            with self._lock:
                page, key = self._pages.pop(client_id, (None, None))
            if page is None:
                return
            self._scheduler.remove(page)
            self.services.landscapes.forget(client_id)
            self.services.files.forget(client_id)
            self.services.experiments.forget(client_id)
            self.services.basins.forget(client_id)
            self.services.scripts.cancel(client_id)
            whole = page.close(within)
            if key is not None:
                if whole:  # else what was handed over some seconds ago stays
                    self._autosave.keep(key, page.memory())
                self._keys.leave(key)


async def _close_soon(connection: ServerConnection) -> None:
    await asyncio.sleep(AGAIN_AFTER)
    await connection.close(CloseCode.TRY_AGAIN_LATER, "the page cannot be shown")
