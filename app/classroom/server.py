"""The server of a class: it serves the lessons' page, and keeps one websocket per browser."""

import asyncio
import contextlib
import gzip
import hashlib
import logging
import re
import sys
from collections.abc import AsyncIterator, Callable, Sequence
from dataclasses import dataclass

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp
from starlette.websockets import WebSocket, WebSocketDisconnect
from uvicorn.protocols.http.h11_impl import H11Protocol

from ..server.address import is_own_page
from .protocol import MAX_MESSAGE_BYTES, Rejected, decode
from .room import Browser, Room

SILENT_S = 10.0  # after which a connection that says nothing is closed
TICK_S = 0.25
PING_S = 15.0
MAX_FRAME_BYTES = 4 * MAX_MESSAGE_BYTES  # longer frames are not even read
MAX_OPEN_FILES = 16_384  # connections are open files; systems allow 1,024 or fewer unless asked
KEPT_FREE = 64  # open files for all else than connections
CLOSED_BY_POLICY, CLOSED_AS_SLOW = 1008, 1013  # codes of RFC 6455
UNREADABLE = {1002: "a frame that is none", 1007: "text that is not UTF-8", 1009: "a message that is too long"}
META_POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy"[^>]*?script-src (?P<scripts>[^;"]*)[^>]*>\n?')
HOST = re.compile(r"[\w.:\[\]-]{1,255}")
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ServerOptions:
    """How a class is served."""

    embed: tuple[str, ...] = ()  # origins whose pages may show the class in a frame
    origins: tuple[str, ...] = ()  # by which browsers know it besides its addresses and this machine's names
    trusted: str = ""  # addresses of proxies whose X-Forwarded headers are believed, separated by commas; * for all


class Page:
    """A page in one file, with the headers that go with it. Its own content policy is replaced by one with the same
    scripts.

    embed: origins whose pages may show it in a frame.
    """

    def __init__(self, html: str, embed: Sequence[str] = ()):
        policy = META_POLICY.search(html)
        self._scripts = policy["scripts"] if policy else "'none'"
        html = META_POLICY.sub("", html)
        self._ancestors = " ".join(("'self'", *embed))
        self._plain = html.encode()
        self._packed = gzip.compress(self._plain, 6)
        self._tag = f'"{hashlib.sha256(self._plain).hexdigest()[:24]}"'

    def policy(self, host: str) -> str:
        """Return the content policy of the page, which may talk to the host that it came from."""
        sockets = f" ws://{host} wss://{host}" if HOST.fullmatch(host) else ""
        return "; ".join(
            (
                "default-src 'none'",
                f"script-src {self._scripts}",
                "style-src 'unsafe-inline'",
                "img-src data: blob:",
                "font-src data:",
                f"connect-src 'self'{sockets}",
                "base-uri 'none'",
                "form-action 'none'",
                f"frame-ancestors {self._ancestors}",
            )
        )

    def answer(self, request: Request) -> Response:
        """Return the page, or that the browser has it."""
        headers = {
            "Content-Security-Policy": self.policy(request.headers.get("host", "")),
            "Cache-Control": "no-cache",
            "ETag": self._tag,
            "Vary": "Accept-Encoding",
            "X-Content-Type-Options": "nosniff",
            "Referrer-Policy": "no-referrer",
        }
        if request.headers.get("if-none-match") == self._tag:
            return Response(status_code=304, headers=headers)
        if "gzip" in request.headers.get("accept-encoding", ""):
            headers["Content-Encoding"] = "gzip"
            return Response(self._packed, headers=headers, media_type="text/html")
        return Response(self._plain, headers=headers, media_type="text/html")


def class_app(room: Room, pages: dict[str, Callable[[], Page]], options: ServerOptions) -> ASGIApp:
    """Return the application of a class.

    pages: what makes each page, by path; called in a thread, for the page at / at once, else when first asked.
    """
    making: dict[str, asyncio.Task[Page]] = {}

    def made(path: str) -> asyncio.Task[Page]:
        if path not in making or making[path].done() and making[path].exception():
            making[path] = asyncio.create_task(asyncio.to_thread(pages[path]))
        return making[path]

    async def page(request: Request) -> Response:
        return (await asyncio.shield(made(request.scope["path"]))).answer(request)

    async def socket(websocket: WebSocket) -> None:
        await _serve(room, websocket, options)

    @contextlib.asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        tasks = [asyncio.create_task(room.store.write()), asyncio.create_task(_tick(room)), made("/")]
        yield
        await room.store.flush()
        for task in tasks:
            task.cancel()
        room.store.close()

    routes = [Route(path, page) for path in pages]
    return Starlette(routes=[*routes, WebSocketRoute("/socket", socket)], lifespan=lifespan)


async def _tick(room: Room) -> None:
    while True:
        await asyncio.sleep(TICK_S)
        room.tick()


# Connections


async def _serve(room: Room, websocket: WebSocket, options: ServerOptions) -> None:
    """One websocket, from its handshake to its end."""
    address = websocket.client.host if websocket.client else ""
    origin, host = websocket.headers.get("origin", ""), websocket.headers.get("host", "")
    if not is_own_page(origin, host, options.origins):
        log.warning("rejected from %s: a page of another origin, %.80r; --address lets its own in", address, origin)
        await websocket.send_denial_response(PlainTextResponse("a page of another origin\n", 403))
        return
    await websocket.accept()
    something = asyncio.Event()
    browser = Browser(address, something.set)
    sending = asyncio.create_task(_send_all(websocket, browser, something))
    try:
        await _receive_all(room, websocket, browser)
    except Rejected as error:
        log.warning("rejected from %s: %s", address, str(error).encode("unicode_escape").decode())
        await _close(websocket, CLOSED_BY_POLICY, str(error)[:100])
    except WebSocketDisconnect as error:
        if error.code in UNREADABLE:
            log.warning("rejected from %s: %s", address, UNREADABLE[error.code])
    finally:
        room.leave(browser)
        sending.cancel()


async def _receive_all(room: Room, websocket: WebSocket, browser: Browser) -> None:
    try:
        first = await asyncio.wait_for(websocket.receive(), SILENT_S)
    except asyncio.TimeoutError:
        raise Rejected("a websocket that says nothing") from None
    while True:
        if first["type"] == "websocket.disconnect":
            raise WebSocketDisconnect(first.get("code", 1000))
        await room.receive(browser, decode(first.get("text")))
        first = await websocket.receive()


async def _send_all(websocket: WebSocket, browser: Browser, something: asyncio.Event) -> None:
    """Send the messages of a browser's outbox as they come, until cancelled."""
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        while True:
            await something.wait()
            something.clear()
            if browser.is_too_slow:
                await _close(websocket, CLOSED_AS_SLOW, "too slow: connect again")
                return
            while browser.outbox:
                await websocket.send_text(browser.outbox.popleft())
            screen, browser.screen = browser.screen, None
            if screen is not None:
                await websocket.send_text(screen)


async def _close(websocket: WebSocket, code: int, reason: str) -> None:
    with contextlib.suppress(WebSocketDisconnect, RuntimeError):
        await websocket.close(code, reason)


# uvicorn


class Impatient(H11Protocol):
    """HTTP connections that are closed if no request comes in time, or to make room for others."""

    silent: "dict[Impatient, None]" = {}  # connections without a request, the oldest first
    most = MAX_OPEN_FILES - KEPT_FREE  # connections at a time

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait for a request."""
        super().connection_made(transport)
        self._timer = asyncio.get_running_loop().call_later(SILENT_S, self._close_if_silent)
        self.silent[self] = None
        if len(self.connections) > self.most:
            next(iter(self.silent)).transport.abort()

    def handle_events(self) -> None:
        """Wait no more once there is a request."""
        super().handle_events()
        if self.scope is not None:
            self._stop_waiting()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no more."""
        self._stop_waiting()
        super().connection_lost(exc)

    def _close_if_silent(self) -> None:
        if self.scope is None:
            self.transport.abort()

    def _stop_waiting(self) -> None:
        self._timer.cancel()
        self.silent.pop(self, None)


def allow_many_connections() -> None:
    """Let this process open more files, where the system says how many those may be."""
    if sys.platform == "win32":
        return
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    limit = MAX_OPEN_FILES if hard == resource.RLIM_INFINITY else min(hard, MAX_OPEN_FILES)
    if soft < limit:
        with contextlib.suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (limit, hard))
    Impatient.most = max(resource.getrlimit(resource.RLIMIT_NOFILE)[0], 2 * KEPT_FREE) - KEPT_FREE


class _InOneLine(logging.Filter):
    """What uvicorn says of a browser's faults, without the stack of its own functions."""

    def filter(self, record: logging.LogRecord) -> bool:
        """Take the stack off."""
        if record.exc_info and isinstance(record.exc_info[1], UnicodeDecodeError):
            record.exc_info = None
        return True


def uvicorn_server(app: ASGIApp, options: ServerOptions) -> uvicorn.Server:
    """Return the server that runs an application: `.run(sockets=…)`."""
    allow_many_connections()
    logging.getLogger("uvicorn.error").addFilter(_InOneLine())
    config = uvicorn.Config(
        app,
        loop="asyncio",
        http=Impatient,
        ws="websockets-sansio",
        ws_max_size=MAX_FRAME_BYTES,
        ws_ping_interval=PING_S,
        ws_ping_timeout=PING_S,
        ws_per_message_deflate=False,  # messages are small, and it costs more time than all else
        log_config=None,
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=bool(options.trusted),
        forwarded_allow_ips=options.trusted,
        timeout_graceful_shutdown=3,
    )
    return uvicorn.Server(config)
