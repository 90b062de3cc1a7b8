"""The server of a class: it serves the lessons' page, and keeps one websocket per browser."""

import asyncio
import contextlib
import gzip
import hashlib
import ipaddress
import logging
import re
import signal
import socket
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from http import HTTPStatus

from websockets.asyncio.server import ServerConnection, serve
from websockets.datastructures import Headers, MultipleValuesError
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from viewimit.processes import stop_signals

from ..lab.lessons.format import Lesson
from ..lab.lessons.page import HERE, lesson_page
from ..lab.page import lab_page
from ..server.address import is_own_page
from ..server.limits import Limits, PendingConnections
from ..server.web import Connection, content_policy, plain_response, serving_options
from ..ways import Ways
from .protocol import MAX_MESSAGE_BYTES, Rejected, decode
from .room import Browser, Room

ENTRY = "lessons/class.js"
STYLES = "class.css", "../challenge/challenge.css"
WAYS = Ways(play="lab", learn="./")
LIMITS = Limits()
HEADERS = {
    "Cache-Control": "no-cache", "Vary": "Accept-Encoding", "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer", "Connection": "close",
}  # fmt: skip
TICK_S = 0.25
MAX_FRAME_BYTES = 4 * MAX_MESSAGE_BYTES  # longer messages are not even read
MAX_OPEN_FILES = 16_384  # connections are open files; systems allow 1,024 or fewer unless asked
BACKLOG = 2048  # connections that wait to be accepted, as when a class opens the page at once
UNREADABLE = {1002: "a frame that is none", 1007: "text that is not UTF-8", 1009: "a message that is too long"}
META_POLICY = re.compile(r'<meta http-equiv="Content-Security-Policy"[^>]*?script-src (?P<scripts>[^;"]*)[^>]*>\n?')
log = logging.getLogger(__name__)


class Page:
    """A page in one file, with the headers that go with it. Its own content policy is replaced by one with the same
    scripts. embed: origins whose pages may show it in a frame."""

    def __init__(self, html: str, embed: Sequence[str] = ()):
        policy = META_POLICY.search(html)
        self._scripts, self._embed = policy["scripts"] if policy else "'none'", embed
        self._plain = META_POLICY.sub("", html).encode()
        self._packed = gzip.compress(self._plain, 6)
        self._tag = f'"{hashlib.sha256(self._plain).hexdigest()[:24]}"'

    def answer(self, asked: Headers) -> Response:
        """Return the page, or that the browser has it."""
        policy = content_policy(asked.get("Host", ""), self._scripts, ancestors=self._embed)
        headers = Headers({**HEADERS, "Content-Security-Policy": policy, "ETag": self._tag})
        if asked.get("If-None-Match") == self._tag:
            return Response(304, "Not Modified", headers)
        body = self._plain
        if "gzip" in asked.get("Accept-Encoding", ""):
            headers["Content-Encoding"], body = "gzip", self._packed
        headers["Content-Type"], headers["Content-Length"] = "text/html; charset=utf-8", str(len(body))
        return Response(200, "OK", headers, body)


def class_pages(lessons: Mapping[str, Lesson], embed: Sequence[str]) -> dict[str, Page]:
    """Return the pages by path: lessons in one page, with what a lecturer and students need, and the lab. A lecturer's
    own lessons take seconds, as they are computed."""
    styles = "\n".join((HERE / name).read_text("utf-8") for name in STYLES)
    texts = {"/": lesson_page(lessons, ENTRY, styles, ways=WAYS), "/lab": lab_page(ways=WAYS)}
    return {path: Page(text, embed) for path, text in texts.items()}


class ClassServer:
    """Serves pages, by path, and the websockets of a room. origins: of its pages besides this machine's; trusted:
    addresses of proxies whose X-Forwarded-For is believed, separated by commas; * for all."""

    def __init__(self, room: Room, pages: Mapping[str, Page], origins: Sequence[str] = (), trusted: str = ""):
        self._room, self._pages, self._origins, self._trusted = room, pages, origins, trusted
        most = allow_many_connections() // 2  # the others are for those who have a websocket
        self._pending = PendingConnections(most, most)

    async def run(self, listeners: Sequence[socket.socket]) -> None:
        """Serve on listening sockets until a signal to end, then write what is not yet on the disk."""
        stopped, loop, room = asyncio.Event(), asyncio.get_running_loop(), self._room
        for number in stop_signals():
            signal.signal(number, lambda *_: loop.call_soon_threadsafe(stopped.set))
        tasks = [asyncio.create_task(room.store.write()), asyncio.create_task(self._tick())]
        options = serving_options(partial(Connection, self._pending), self._answer, MAX_FRAME_BYTES, LIMITS)
        options["compression"] = None  # messages are small, and it costs more time than all else
        async with contextlib.AsyncExitStack() as stack:
            for listener in listeners:
                await stack.enter_async_context(serve(self._serve, sock=listener, backlog=BACKLOG, **options))
            await stopped.wait()
        await room.store.flush()
        for task in tasks:
            task.cancel()
        room.store.close()

    async def _tick(self) -> None:
        while True:
            await asyncio.sleep(TICK_S)
            self._room.tick()

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Return a response, or None to take the websocket."""
        path = request.path.partition("?")[0]
        try:
            if path in self._pages:
                return self._pages[path].answer(request.headers)
            if path != "/socket":
                return plain_response(HTTPStatus.NOT_FOUND, "not found\n")
            origin, host = request.headers.get("Origin", ""), request.headers.get("Host", "")
        except MultipleValuesError:
            return plain_response(HTTPStatus.BAD_REQUEST, "a header that may come once comes twice\n")
        if not is_own_page(origin, host, self._origins):
            address = self._address_of(connection)
            log.warning("rejected from %s: a page of another origin, %.80r; --address lets its own in", address, origin)
            return plain_response(HTTPStatus.FORBIDDEN, "a page of another origin\n")
        return None

    def _address_of(self, connection: ServerConnection) -> str:
        """Where a browser is: of proxies that are trusted, what they say of it."""
        peer, request = connection.remote_address, connection.request
        proxies = self._trusted.replace(" ", "").split(",")
        forwarded = "" if request is None else ",".join(request.headers.get_all("X-Forwarded-For"))
        chain = [*filter(None, forwarded.replace(" ", "").split(",")), peer[0] if peer else ""]
        while len(chain) > 1 and ("*" in proxies or _is_in(chain[-1], proxies)):
            chain.pop()
        return chain[-1]

    async def _serve(self, connection: ServerConnection) -> None:
        """One websocket, from its handshake to its end."""
        self._pending.discard(connection)
        address, something = self._address_of(connection), asyncio.Event()
        browser = Browser(address, something.set)
        sending = asyncio.create_task(_send_all(connection, browser, something))
        try:
            try:
                message = await asyncio.wait_for(connection.recv(), LIMITS.head_within)
            except asyncio.TimeoutError:
                raise Rejected("a websocket that says nothing") from None
            while True:
                await self._room.receive(browser, decode(message))
                message = await connection.recv()
        except Rejected as error:
            log.warning("rejected from %s: %s", address, str(error).encode("unicode_escape").decode())
            await connection.close(CloseCode.POLICY_VIOLATION, str(error)[:100])
        except ConnectionClosed as closed:
            if closed.sent is not None and closed.sent.code in UNREADABLE:
                log.warning("rejected from %s: %s", address, UNREADABLE[closed.sent.code])
        finally:
            self._room.leave(browser)
            sending.cancel()


async def _send_all(connection: ServerConnection, browser: Browser, something: asyncio.Event) -> None:
    """Send the messages of a browser's outbox as they come, until cancelled."""
    with contextlib.suppress(ConnectionClosed):
        while True:
            await something.wait()
            something.clear()
            if browser.is_too_slow:
                await connection.close(CloseCode.TRY_AGAIN_LATER, "too slow: connect again")
                return
            while browser.outbox:
                await connection.send(browser.outbox.popleft())
            screen, browser.screen = browser.screen, None
            if screen is not None:
                await connection.send(screen)


def _is_in(address: str, networks: Sequence[str]) -> bool:
    try:
        return any(ipaddress.ip_address(address) in ipaddress.ip_network(one, strict=False) for one in networks if one)
    except ValueError:
        return False


def allow_many_connections() -> int:
    """Let this process open more files, where the system says how many those may be. Return how many."""
    if sys.platform == "win32":
        return MAX_OPEN_FILES
    import resource

    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    limit = MAX_OPEN_FILES if hard == resource.RLIM_INFINITY else min(hard, MAX_OPEN_FILES)
    with contextlib.suppress(ValueError, OSError):
        resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, limit), hard))
    return resource.getrlimit(resource.RLIMIT_NOFILE)[0]
