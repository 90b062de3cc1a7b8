"""A connection, whose messages are checked before viser sees them. websockets reads its request."""

import asyncio
import re
import socket
from contextlib import suppress
from contextvars import ContextVar
from http import HTTPStatus
from typing import Any, Protocol

from viser import ClientHandle
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Response

from . import messages
from .limits import Limits, PendingConnections, TokenBucket, network_of
from .messages import PART, Hostile, MessageValidator, Refused

AS_GET = re.compile(rb"(?:GET|HEAD) (\S+) HTTP/1\.[01](?=\r\n)")  # websockets reads GET of HTTP/1.1 alone
UNSENT = 1 << 18  # bytes that the system keeps for a client: a ping does not wait long behind them
TAKES_WITHIN = 60_000  # ms, in which a client takes something of what is sent to it (Linux)
MOST_MESSAGE = PART + 4096  # bytes
FRAMES_A_SECOND, FRAMES_AT_ONCE = 150, 600  # of all kinds; a browser sends at most 20 a second and widget
REFUSALS_A_SECOND, REFUSALS_AT_ONCE = 0.5, 20  # messages that are dropped, before the client is closed


def plain_response(status: HTTPStatus, text: str, kind: str = "text/plain", **more: str) -> Response:
    """Return an answer with which the connection ends. more: further headers."""
    body = text.encode()
    headers = Headers({"Content-Type": f"{kind}; charset=utf-8", "Content-Length": str(len(body)), **more})
    headers["Connection"] = "close"
    headers["Cache-Control"] = "no-store"
    return Response(status.value, status.phrase, headers, body)


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
    is_head_request = False

    def __init__(self, host: Host, *args, **limits):
        super().__init__(*args, **limits)
        self._host = host
        self.network = network_of(None)
        self._frames = TokenBucket(FRAMES_A_SECOND, FRAMES_AT_ONCE)
        self._refusals = TokenBucket(REFUSALS_A_SECOND, REFUSALS_AT_ONCE)
        self._validator: MessageValidator | None = None
        self._failing: asyncio.Task | None = None
        self._starts: asyncio.TimerHandle | None = None

    @property
    def name(self) -> str:
        """For the log."""
        address = self.remote_address
        return f"{address[0]}:{address[1]}" if address else "a client that is gone"

    def connection_made(self, transport) -> None:
        super().connection_made(transport)
        self.network = network_of(self.remote_address)
        self._host.pending.add(self, self.network, transport.abort)
        ours = transport.get_extra_info("socket")
        ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNSENT)
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            ours.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, TAKES_WITHIN)

    def data_received(self, data: bytes) -> None:
        if self.request is None:
            self.is_head_request = self.is_head_request or data.startswith(b"HEAD ")
            data = AS_GET.sub(rb"GET \1 HTTP/1.1", data, count=1) if AS_GET.match(data) else data
        super().data_received(data)

    def connection_lost(self, exc: Exception | None) -> None:
        self._host.leave(self)
        if self._starts is not None:
            self._starts.cancel()
        super().connection_lost(exc)

    def take_seat(self) -> None:
        self._starts = self.loop.call_later(self._host.limits.page_within, self._end_if_idle)

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
                if not self._refusals.take():
                    self._end(CloseCode.POLICY_VIOLATION, "too many messages that make no sense")
                elif self._failing is None:
                    self._host.note(self, str(refusal))
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
            self._host.note(self, f"{what}; closed")
            self._failing = self.loop.create_task(self._fail(code, what))
            self.loop.call_later(self._host.limits.closed_within, self.transport.abort)

    async def _fail(self, code: CloseCode, what: str) -> None:
        with suppress(ConnectionClosed):
            async with self.send_context():
                self.protocol.fail(code, what.encode()[:100].decode(errors="ignore"))


CONNECTION: ContextVar[GuardedConnection] = ContextVar("connection")  # whose messages are being answered
