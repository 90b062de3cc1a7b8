"""A connection: its request is read and answered, then its messages are checked before viser sees them."""

import asyncio
import re
import socket
from contextlib import suppress
from contextvars import ContextVar
from http import HTTPStatus
from typing import Any, Protocol

import h11
from viser import ClientHandle
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import MAX_LINE_LENGTH, MAX_NUM_HEADERS, Response
from websockets.protocol import State

from . import messages
from .limits import Limits, PendingConnections, TokenBucket, Unsent, network_of
from .messages import PART, Hostile, MessageValidator, Refused

MOST_HEAD = 1 << 14  # bytes of a request's head
METHODS = "GET, HEAD"
ONCE = (  # headers that would be given to two answers, or to none
    b"accept-encoding", b"host", b"origin", b"sec-websocket-key", b"sec-websocket-version", b"transfer-encoding",
    b"upgrade",
)  # fmt: skip
PRINTABLE = re.compile(rb"[\t -~\x80-\xff]*")
MOST_MESSAGE = PART + 4096  # bytes
FRAMES_A_SECOND, FRAMES_AT_ONCE = 150, 600  # of all kinds; a browser sends at most 20 a second and widget
REFUSALS_A_SECOND, REFUSALS_AT_ONCE = 0.5, 20  # messages that are dropped, before the client is closed
LINES_OF_ONE = 1.0  # a second, that one connection brings into the log
UNSENT = 1 << 18  # bytes that the system keeps for a client that is slow to take them
LOOKS = 4  # at what waits for a client, in the time in which it must take something of it


class NotAnswered(ValueError):
    """A request that gets nothing but a status and a sentence."""

    def __init__(self, status: HTTPStatus, what: str):
        super().__init__(what)
        self.status = status


def plain_response(status: HTTPStatus, text: str, kind: str = "text/plain", **more: str) -> Response:
    """Return an answer with which the connection ends. more: further headers."""
    body = text.encode()
    headers = Headers({"Content-Type": f"{kind}; charset=utf-8", "Content-Length": str(len(body)), **more})
    headers["Connection"] = "close"
    headers["Cache-Control"] = "no-store"
    return Response(status.value, status.phrase, headers, body)


def as_get(request: h11.Request) -> bytes:
    """Write the head of a request as a GET of HTTP/1.1, the only request that websockets reads. Raises NotAnswered."""
    headers = dict(request.headers)
    if request.http_version not in (b"1.0", b"1.1"):
        raise NotAnswered(HTTPStatus.HTTP_VERSION_NOT_SUPPORTED, "another version than HTTP/1.0 or HTTP/1.1")
    if request.method.decode() not in METHODS.split(", "):
        raise NotAnswered(HTTPStatus.METHOD_NOT_ALLOWED, f"another method than {METHODS}")
    twice = next((name for name in ONCE if [found for found, _ in request.headers].count(name) > 1), None)
    if twice is not None:
        raise NotAnswered(HTTPStatus.BAD_REQUEST, f"a request with more than one {twice.decode()}")
    if not all(PRINTABLE.fullmatch(value) for _, value in request.headers):
        raise NotAnswered(HTTPStatus.BAD_REQUEST, "a header with control characters")
    if b"transfer-encoding" in headers or headers.pop(b"content-length", b"0") != b"0":
        raise NotAnswered(HTTPStatus.BAD_REQUEST, "a head that a body follows")
    if b"upgrade" in headers and (request.method != b"GET" or request.http_version == b"1.0"):
        raise NotAnswered(HTTPStatus.BAD_REQUEST, "a websocket by another request than a GET of HTTP/1.1")
    lines = [b"GET %s HTTP/1.1\r\n" % request.target]
    lines += [b"%s: %s\r\n" % pair for pair in request.headers if pair[0] in headers]
    if len(lines) > MAX_NUM_HEADERS or max(map(len, lines)) > MAX_LINE_LENGTH or sum(map(len, lines)) > MOST_HEAD:
        raise NotAnswered(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, "too many headers, or too long")
    return b"".join(lines) + b"\r\n"


class Host(Protocol):
    """The part of the server that a connection uses."""

    limits: Limits
    pending: PendingConnections

    def note(self, connection: "GuardedConnection", what: str) -> None: ...

    def belongs_to_another(self, uuid: str) -> bool: ...

    def leave(self, connection: "GuardedConnection") -> None: ...


class GuardedConnection(ServerConnection):
    """A connection whose `recv` returns messages that were checked only. network: where it comes from; client: viser's
    of it, from the first view on."""

    client: ClientHandle | None = None

    def __init__(self, host: Host, *args, **limits):
        super().__init__(*args, **limits)
        self._host = host
        self.network = network_of(None)
        self._unsent = Unsent()
        self._http = h11.Connection(h11.SERVER, MOST_HEAD)
        self._came = 0  # bytes, with empty lines before the head
        self._begun = False
        self._asked: h11.Request | None = None
        self._early = b""  # what came behind the request for a websocket before its answer
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
    def is_head_request(self) -> bool:
        """Whether its request is for the head of an answer."""
        return self._asked is not None and self._asked.method == b"HEAD"

    @property
    def _asks_for_websocket(self) -> bool:
        return self._asked is not None and b"upgrade" in dict(self._asked.headers)

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
        if self._refused:
            return
        if self._asked is not None:
            self._read_on(data)
            return
        try:
            self._read_head(data)
        except NotAnswered as refusal:
            self._refuse(refusal)

    def _read_head(self, data: bytes) -> None:
        """Read on in the head of the request; once it is whole, websockets gets it as a GET."""
        self._came += len(data)
        data = data if self._begun else data.lstrip(b"\r\n")  # which may come first
        self._begun = self._begun or bool(data)
        if data:
            self._http.receive_data(data)
        try:
            event = self._http.next_event()
        except h11.RemoteProtocolError as error:
            status = HTTPStatus(error.error_status_hint)
            raise NotAnswered(status, "a malformed head, or one that is too long") from None
        if isinstance(event, h11.Request):
            self._asked = event
            super().data_received(as_get(event))
            self._read_on(self._http.trailing_data[0])
        elif self._came > MOST_HEAD:
            raise NotAnswered(HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, f"a head of more than {MOST_HEAD} bytes")

    def _read_on(self, data: bytes) -> None:
        """Read what follows a request's head. Before the answer, websockets would take it for a frame, and fail without
        an answer. So bytes after the request for a websocket wait, up to MOST_HEAD; after others they are dropped."""
        if self.protocol.state is not State.CONNECTING:
            super().data_received(data)
        elif self._asks_for_websocket and len(self._early) + len(data) <= MOST_HEAD:
            self._early += data

    async def handshake(self, *args, **options) -> None:
        await super().handshake(*args, **options)
        early, self._early = self._early, b""
        if early and self.protocol.state is State.OPEN:
            super().data_received(early)

    def eof_received(self) -> bool | None:  # type: ignore[override]  # asyncio takes an answer, websockets gives none
        """Return True to keep the connection: a client may end its side and still gets the answer."""
        if self._refused:
            return False  # it is closed once the answer is sent
        if self._asked is not None and not self._asks_for_websocket and self.protocol.state is State.CONNECTING:
            return True
        return super().eof_received()

    def _end_if_late(self) -> None:
        """Answer a client whose request has begun and is not whole. A silent one stays until it has to make room."""
        if self._asked is None and self._begun and not self._refused:
            within = self._host.limits.head_within
            self._refuse(NotAnswered(HTTPStatus.REQUEST_TIMEOUT, f"a head that was not whole after {within:g} s"))

    def _refuse(self, refusal: NotAnswered) -> None:
        """Answer why, and read no more. Closing at once would discard the answer while the client still sends."""
        self._refused = True
        self._host.note(self, str(refusal))
        allow = {"Allow": METHODS} if refusal.status == HTTPStatus.METHOD_NOT_ALLOWED else {}
        answer = plain_response(refusal.status, str(refusal) + "\n", **allow)
        if self.is_head_request:
            answer.body = b""
        self.loop.call_later(self._host.limits.closed_within, self.transport.abort)
        self.transport.write(answer.serialize())
        with suppress(OSError):  # it has just gone
            self.transport.write_eof()

    def send_data(self) -> None:
        before = self.transport.get_write_buffer_size()
        super().send_data()
        self._unsent.written(before, self.transport.get_write_buffer_size())

    def _look(self) -> None:
        """Abort the connection of a client that has read nothing for a while: closing it would wait behind the data."""
        within = self._host.limits.stalled_within
        if self._unsent.stalled(self.transport.get_write_buffer_size()) >= within:
            self._host.note(self, f"a client that has taken nothing for {within:g} s; closed")
            self.transport.abort()
            return
        self._looks = self.loop.call_later(within / LOOKS, self._look)

    async def keepalive(self) -> None:
        """Ping as websockets does, which waits without limit until a ping is sent."""
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
        """Return the next message that passes the guard, as bytes."""
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
            if self.client is None:
                if not isinstance(message, messages.ViewerCameraMessage):
                    raise Hostile(f"{type(message).__name__} before the first view")
                return
            self._validator = MessageValidator(self.client, self._host.belongs_to_another)
            if self._starts is not None:
                self._starts.cancel()
        self._validator.admit(message)

    def _end_if_idle(self) -> None:
        if self.client is None:
            self._end(CloseCode.POLICY_VIOLATION, "a seat for nobody: no page has come")

    def _end(self, code: CloseCode, what: str) -> None:
        """Log the reason and close. Later messages are not read; without a closing handshake it is aborted."""
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


CONNECTION: ContextVar[GuardedConnection] = ContextVar("connection")  # whose messages are being answered
