"""The head of a request, before websockets reads it, which answers nothing but a GET of HTTP/1.1."""

import asyncio
import http
import re
import socket
from collections.abc import Generator
from contextlib import suppress
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any, Protocol

from viser import ClientHandle
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed, SecurityError
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.protocol import State
from websockets.streams import StreamReader

from . import messages
from .limits import Limits, PendingConnections, TokenBucket, Unsent, network_of
from .messages import PART, Hostile, MessageValidator, Refused

MOST_HEAD = 1 << 14  # bytes
METHODS = "GET, HEAD"
ONCE = (  # what two answers would be given to, or none
    "Accept-Encoding", "Content-Length", "Cookie", "Host", "Origin", "Sec-Fetch-Site", "Sec-Purpose",
    "Sec-WebSocket-Key", "Sec-WebSocket-Version", "Transfer-Encoding", "Upgrade", "X-Forwarded-Proto",
)  # fmt: skip
_END = re.compile(rb"\r?\n\r?\n")
_LINE = re.compile(rb"([!#$%&'*+.^_`|~\w-]+) ([!-~\x80-\xff]+) HTTP/(\d)\.(\d)\r")


class NotAnswered(ValueError):
    """A request that gets nothing but a status and a sentence."""

    def __init__(self, status: http.HTTPStatus, what: str):
        super().__init__(what)
        self.status = status


@dataclass(frozen=True)
class RequestHead:
    """of_body: whether the answer may have one; websocket: whether it asks for one; plain: it, as a GET of HTTP/1.1,
    which is answered alike; behind: what has come after it."""

    of_body: bool
    websocket: bool
    plain: bytes
    behind: bytes


def is_whole(received: bytes) -> bool:
    return _END.search(received.lstrip(b"\r\n")) is not None


def read_head(received: bytes) -> RequestHead | None:
    """The head of what has come, None while there is more to come. Raises NotAnswered."""
    received = received.lstrip(b"\r\n")
    end = _END.search(received)
    if len(received) > MOST_HEAD if end is None else end.end() > MOST_HEAD:
        raise too_long()
    if end is None:
        return None
    first, _, rest = received.partition(b"\n")
    line = _LINE.fullmatch(first)
    if line is None:
        raise NotAnswered(http.HTTPStatus.BAD_REQUEST, "a line that is no request")
    method, target, major, minor = line.groups()
    if major != b"1":
        raise NotAnswered(http.HTTPStatus.HTTP_VERSION_NOT_SUPPORTED, "another version than HTTP/1.0 or HTTP/1.1")
    if method.decode() not in METHODS.split(", "):
        raise NotAnswered(http.HTTPStatus.METHOD_NOT_ALLOWED, f"another method than {METHODS}")
    behind = received[end.end() :]
    plain = b"GET " + target + b" HTTP/1.1\r\n" + rest.removesuffix(behind)
    request = _as_websockets_reads(plain)
    doubled = next((name for name in ONCE if len(request.headers.get_all(name)) > 1), None)
    if doubled is not None:
        raise NotAnswered(http.HTTPStatus.BAD_REQUEST, f"a request with more than one {doubled}")
    websocket = "Upgrade" in request.headers
    if websocket and (method != b"GET" or minor == b"0"):
        raise NotAnswered(http.HTTPStatus.BAD_REQUEST, "a websocket by another request than a GET of HTTP/1.1")
    return RequestHead(method == b"GET", websocket, plain, behind)


def too_long() -> NotAnswered:
    return NotAnswered(http.HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, f"a head of more than {MOST_HEAD} bytes")


def _as_websockets_reads(head: bytes) -> Request:
    reader = StreamReader()
    reader.feed_data(head)
    reader.feed_eof()
    try:
        return _result(Request.parse(reader.read_line))
    except SecurityError:
        raise NotAnswered(http.HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, "too many headers, or too long") from None
    except (ValueError, EOFError, LookupError, NotImplementedError):
        raise NotAnswered(http.HTTPStatus.BAD_REQUEST, "a malformed head, or one that a body follows") from None


def _result(parsing: Generator[None, None, Request]) -> Request:
    """Of a parser that has all that it asks for."""
    try:
        next(parsing)
    except StopIteration as done:
        return done.value
    raise EOFError


# Answers that are not a page.


def plain_response(status: http.HTTPStatus, text: str, kind: str = "text/plain", **more: str) -> Response:
    """more: further headers. The connection ends with it."""
    body = text.encode()
    headers = Headers({"Content-Type": f"{kind}; charset=utf-8", "Content-Length": str(len(body)), **more})
    headers["Connection"] = "close"
    headers["Cache-Control"] = "no-store"
    return Response(status.value, status.phrase, headers, body)


# A connection whose messages are checked before viser sees them, at a bounded rate.

MOST_MESSAGE = PART + 4096  # bytes
FRAMES_A_SECOND, FRAMES_AT_ONCE = 150, 600  # of all kinds; a browser sends at most 20 a second and widget
REFUSALS_A_SECOND, REFUSALS_AT_ONCE = 0.5, 20  # messages that are dropped, before the client is closed
LINES_OF_ONE = 1.0  # a second, that one connection brings into the log
UNSENT = 1 << 18  # bytes that the system keeps for a client that is slow to take them
LOOKS = 4  # at what waits for a client, in the time in which it must take something of it


class Host(Protocol):
    """What a connection asks of the server that it belongs to."""

    limits: Limits
    pending: PendingConnections

    def note(self, connection: "GuardedConnection", what: str) -> None: ...

    def client_of(self, connection: "GuardedConnection") -> ClientHandle | None: ...

    def belongs_to_another(self, uuid: str) -> bool: ...

    def leave(self, connection: "GuardedConnection") -> None: ...


class GuardedConnection(ServerConnection):
    """A connection whose `recv` returns messages that were checked only. network: where it comes from."""

    def __init__(self, host: Host, *args, **limits):
        super().__init__(*args, **limits)
        self._host = host
        self.network = network_of(None)
        self._unsent = Unsent()
        self._received = b""  # of a request that has not come as a whole; then what came behind it before its answer
        self._came = 0  # bytes, with empty lines before it
        self._head: RequestHead | None = None
        self._refused = False
        self._frames = TokenBucket(FRAMES_A_SECOND, FRAMES_AT_ONCE)
        self._lines = TokenBucket(LINES_OF_ONE, 1)
        self._refusals = TokenBucket(REFUSALS_A_SECOND, REFUSALS_AT_ONCE)
        self._validator: MessageValidator | None = None
        self._failing: asyncio.Task | None = None
        self._late: asyncio.TimerHandle | None = None
        self._starts: asyncio.TimerHandle | None = None
        self._looks: asyncio.TimerHandle | None = None

    @property
    def wants_no_body(self) -> bool:
        """Whether its request is for the head of an answer."""
        return self._head is not None and not self._head.of_body

    @property
    def name(self) -> str:
        """For the log."""
        address = self.remote_address
        return f"{address[0]}:{address[1]}" if address else "a client that is gone"

    def connection_made(self, transport) -> None:
        super().connection_made(transport)
        self.network = network_of(self.remote_address)
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNSENT)
        self._host.pending.add(self, self.network, transport.abort)
        self._late = self.loop.call_later(self._host.limits.head_within, self._end_if_late)
        self._look()

    def connection_lost(self, exc: Exception | None) -> None:
        self._host.leave(self)
        for timer in (self._late, self._starts, self._looks):
            if timer is not None:
                timer.cancel()
        super().connection_lost(exc)

    def take_seat(self) -> None:
        self._starts = self.loop.call_later(self._host.limits.page_within, self._end_if_idle)

    def data_received(self, data: bytes) -> None:
        if self._head is not None:
            self._read_on(data)
        elif not self._refused:
            self._came += len(data)
            self._received = (self._received + data).lstrip(b"\r\n")
            if b"\n" in data or self._came > MOST_HEAD:  # else it cannot be whole
                self._begin()

    def _begin(self) -> None:
        """Once all of a request's head has come."""
        try:
            self._head = read_head(self._received)
            if self._head is None and self._came > MOST_HEAD:
                raise too_long()
        except NotAnswered as refusal:
            self._refuse(refusal)
            return
        if self._head is not None:
            self._received = b""
            super().data_received(self._head.plain)
            self._read_on(self._head.behind)

    def _read_on(self, data: bytes) -> None:
        """What comes behind a request's head. Before the answer websockets would take it for a frame, fail, and answer
        nothing: what follows the request for a websocket waits, be it not too much; all else asks for nothing more."""
        if self.protocol.state is not State.CONNECTING:
            super().data_received(data)
        elif self._head is not None and self._head.websocket and len(self._received) + len(data) <= MOST_HEAD:
            self._received += data

    async def handshake(self, *args, **options) -> None:
        await super().handshake(*args, **options)
        early, self._received = self._received, b""
        if early and self.protocol.state is State.OPEN:
            super().data_received(early)

    def eof_received(self) -> bool | None:  # type: ignore[override]  # asyncio takes an answer, websockets gives none
        """Who has sent all of a request may end its side, and is answered yet; True: the connection stays."""
        if self._refused:
            return False  # it is closed once the answer is sent
        if self._head is not None and not self._head.websocket and self.protocol.state is State.CONNECTING:
            return True
        return super().eof_received()

    def _end_if_late(self) -> None:
        """Who has begun a request and not said all of its head is told so; who has said nothing is left as it is."""
        if self._head is None and self._received and not self._refused:
            within = self._host.limits.head_within
            self._refuse(NotAnswered(HTTPStatus.REQUEST_TIMEOUT, f"a head that was not whole after {within:g} s"))

    def _refuse(self, refusal: NotAnswered) -> None:
        """Say why, and read no more. It is not closed at once, or what the client still sends would undo the answer."""
        self._refused = True
        self._host.note(self, str(refusal))
        allow = {"Allow": METHODS} if refusal.status == HTTPStatus.METHOD_NOT_ALLOWED else {}
        answer = plain_response(refusal.status, str(refusal) + "\n", **allow)
        if self._received.startswith(b"HEAD "):
            answer.body = b""
        self._received = b""
        self.loop.call_later(self._host.limits.closed_within, self.transport.abort)
        self.transport.write(answer.serialize())
        with suppress(OSError):  # it has just gone
            self.transport.write_eof()

    def send_data(self) -> None:
        before = self.transport.get_write_buffer_size()
        super().send_data()
        self._unsent.written(before, self.transport.get_write_buffer_size())

    def _look(self) -> None:
        """Whatever goes on, who takes nothing of what waits is left: closing would wait behind it."""
        within = self._host.limits.stalled_within
        if self._unsent.stalled(self.transport.get_write_buffer_size()) >= within:
            self._host.note(self, f"a client that has taken nothing for {within:g} s; closed")
            self.transport.abort()
            return
        self._looks = self.loop.call_later(within / LOOKS, self._look)

    async def keepalive(self) -> None:
        """In place of websockets' own, which waits without limit until a ping is on its way."""
        limits = self._host.limits
        while True:
            await asyncio.sleep(limits.ping_every)
            try:
                answered = await asyncio.wait_for(self.ping(), limits.written_within)
                self.latency = await asyncio.wait_for(answered, limits.pong_within)
            except asyncio.TimeoutError:
                self._end(CloseCode.INTERNAL_ERROR, "silence: a ping had no answer")
                return
            except ConnectionClosed:
                return

    def process_event(self, event) -> None:
        if self.request is not None and not self._frames.take():
            self._end(CloseCode.POLICY_VIOLATION, "a flood of messages")
            return
        super().process_event(event)

    async def recv(self, decode: bool | None = None) -> Any:
        """The next message that passes the validator, as it came: bytes."""
        while True:
            try:
                raw = await super().recv(decode)
            except ConnectionClosed as closed:
                if closed.sent is not None and closed.sent.code == CloseCode.MESSAGE_TOO_BIG:
                    self._host.note(self, f"a message of more than {MOST_MESSAGE} bytes")
                raise
            try:
                self._admit(raw)
                return raw
            except Refused as refusal:
                if self._lines.take():
                    self._host.note(self, str(refusal))
                if not self._refusals.take():
                    self._end(CloseCode.POLICY_VIOLATION, "too many messages that make no sense")
            except Hostile as refusal:
                self._end(CloseCode.POLICY_VIOLATION, str(refusal))

    def _admit(self, raw: bytes | str) -> None:
        message = messages.read(raw)
        if self._validator is None:
            client = self._host.client_of(self)
            if client is None:
                if not isinstance(message, messages.ViewerCameraMessage):
                    raise Hostile(f"{type(message).__name__} before the first view")
                return
            self._validator = MessageValidator(client, self._host.belongs_to_another)
            if self._starts is not None:
                self._starts.cancel()
        self._validator.admit(message)

    def _end_if_idle(self) -> None:
        if self._host.client_of(self) is None:
            self._end(CloseCode.POLICY_VIOLATION, "a seat for nobody: no page has come")

    def _end(self, code: CloseCode, what: str) -> None:
        """Say it in the log and close; what comes after is not read any more, and who does not say goodbye is left."""
        if self._failing is None:
            due = 0.0 if self._lines.take() else 1 / LINES_OF_ONE
            self.loop.call_later(due, self._host.note, self, f"{what}; closed")
            self._failing = self.loop.create_task(self._fail(code, what))
            self.loop.call_later(self._host.limits.closed_within, self.transport.abort)

    async def _fail(self, code: CloseCode, what: str) -> None:
        try:
            async with self.send_context():
                self.protocol.fail(code, what.encode()[:100].decode(errors="ignore"))
        except ConnectionClosed:
            pass
