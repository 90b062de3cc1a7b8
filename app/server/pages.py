"""The server: viser's, one page a browser tab, one scheduler for all."""

import asyncio
import contextlib
import gc
import html
import io
import logging
import warnings
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial

import viser
from websockets.frames import CloseCode

from viewimit.simulation.scene import load_scene

from .. import viser_private
from ..lab.lessons.format import Lesson
from ..lab.lessons.page import LabPages
from ..model.services import Services
from ..page.page import LEAVES_WITHIN, Page
from ..panels.panel import ClientInfo
from ..scene.arms import ALWAYS_SEEN, share_meshes
from ..scene.scene3d import share_light
from ..static import stylesheet
from .access import AccessControl
from .address import origin_for_others, own_names, path_of_page
from .connection import CONNECTION, GuardedConnection
from .limits import ServerOptions, in_a_line
from .scheduler import Scheduler

BUILT_AT_ONCE = 2  # pages: all others would wait for many more
AGAIN_AFTER = 5.0  # s, until who could not be shown a page is to try again
COLLECTS_AFTER = 1.0  # s, after a tab has left
log = logging.getLogger(__name__)


@contextlib.contextmanager
def serving(options: ServerOptions, port: int = 0, heartbeat: Callable[[], None] = lambda: None) -> Iterator[int]:
    """Serve pages inside, on the port that it yields. heartbeat(): called once a second while they are drawn."""
    own_names()  # begins to ask for them
    # On a server it is no fault to draw for a client that has just gone
    warnings.filterwarnings("ignore", message="Queued a .* on a closed connection")
    scheduler = Scheduler(heartbeat)
    lab = LabPages(options.settings.scene, options.settings.robot, options.lessons)
    access = AccessControl(options.limits, options.origins, lab.page)
    with (
        contextlib.redirect_stdout(io.StringIO()),
        viser_private.serving_with(access.serve),
    ):  # viser prints a banner of its own
        server = viser.ViserServer(host=options.host, port=port, label="viewimit", verbose=False)
    app = App(server, options, scheduler, lab.lessons)
    access.guard(server)
    gc.collect()
    gc.freeze()  # permanent objects are not searched whenever a tab closes
    try:
        yield server.get_port()
    finally:
        app.stop()
        with contextlib.redirect_stdout(io.StringIO()):
            server.stop()


class App:
    """Pages by client id, all of which come, are drawn and go in viser's event loop. lessons: of the lab, by name."""

    def __init__(
        self, server: viser.ViserServer, options: ServerOptions, scheduler: Scheduler, lessons: Mapping[str, Lesson]
    ):
        self._server, self._settings, self._scheduler = server, options.settings, scheduler
        self._host, self._lessons = options.host, lessons
        self._pages: dict[int, Page] = {}
        viser_private.send_at_once(server)
        self._building = asyncio.Semaphore(BUILT_AT_ONCE)
        self._collecting: asyncio.TimerHandle | None = None
        share = cache(partial(share_meshes, server))  # what no page has shown yet waits
        self.services = Services(share)
        server.gui.configure_theme(show_logo=False, show_share_button=False)
        server.gui.add_html(f"<style>{stylesheet()}</style>")
        share_light(server)
        for arm in ALWAYS_SEEN:
            share(load_scene(options.settings.scene, options.settings.robot).robot, arm)
        server.on_client_connect(self._connect)
        server.on_client_disconnect(self._disconnect)
        self._scheduler.start(server.get_event_loop())

    def stop(self) -> None:
        """Stop all pages and jobs. Not from the event loop."""
        self._scheduler.stop()
        self.services.camera.stop()
        asyncio.run_coroutine_threadsafe(self._retire_all(), self._server.get_event_loop()).result()
        self.services.stop()

    async def _retire_all(self) -> None:
        leaving = [asyncio.ensure_future(self._retire(client_id)) for client_id in list(self._pages)]
        if leaving:
            await asyncio.wait(leaving, timeout=LEAVES_WITHIN)

    async def _connect(self, client: viser.ClientHandle) -> None:
        connection = CONNECTION.get()
        connection.client = client
        async with self._building:
            if not self._is_here(client):  # it has left while others' pages were built
                return
            page = await asyncio.to_thread(self._build, client, connection)
        if page is None:
            return
        self._pages[client.client_id] = page
        if self._is_here(client):
            self._scheduler.add(page)
        else:  # it left meanwhile
            await self._retire(client.client_id)

    def _is_here(self, client: viser.ClientHandle) -> bool:
        return client.client_id in self._server.get_clients()

    def _build(self, client: viser.ClientHandle, connection: GuardedConnection) -> Page | None:
        """Return its page; None if it cannot be built, which its visitor then reads."""
        viser_private.send_at_once(client)
        try:
            with client.atomic():
                return self._page(client, connection)
        except Exception as error:  # a scene of the user's that has changed meanwhile, or what nobody foresaw
            self._send_back(client, connection, error)
            return None

    def _send_back(self, client: viser.ClientHandle, connection: GuardedConnection, error: Exception) -> None:
        """Show why there is no page, then close the connection: the browser connects again by itself."""
        log.error(in_a_line("a page cannot be shown", error))
        asyncio.run_coroutine_threadsafe(_close_soon(connection), self._server.get_event_loop())
        client.gui.reset()  # of its parts
        why = html.escape(str(error) or type(error).__name__)
        client.gui.add_html(f"<p>This page cannot be shown: {why}. It is tried again in {AGAIN_AFTER:g} s.</p>")

    def _page(self, client: viser.ClientHandle, connection: GuardedConnection) -> Page:
        request = connection.request
        assert request is not None, "it has a seat"
        origin, path = request.headers.get("Origin"), path_of_page(request.path)
        public = origin_for_others(self._host, origin)
        info = ClientInfo(origin and origin + path, public and public + path, self._lessons)
        return Page(client, self.services, self._settings, info)

    async def _disconnect(self, client: viser.ClientHandle) -> None:
        await self._retire(client.client_id)
        if self._collecting is None:  # once for all of a class that leaves at once
            self._collecting = asyncio.get_running_loop().call_later(COLLECTS_AFTER, self._collect)

    def _collect(self) -> None:
        self._collecting = None
        gc.collect()  # viser's handles are reference cycles

    async def _retire(self, client_id: int) -> None:
        """Forget a page. Its last turn may take LEAVES_WITHIN to end."""
        page = self._pages.pop(client_id, None)
        if page is None:
            return
        self._scheduler.remove(page)
        self.services.forget(page.queue)
        page.model.following.let_go()
        await asyncio.to_thread(page.close)


async def _close_soon(connection: GuardedConnection) -> None:
    await asyncio.sleep(AGAIN_AFTER)
    await connection.close(CloseCode.TRY_AGAIN_LATER, "the page cannot be shown")
