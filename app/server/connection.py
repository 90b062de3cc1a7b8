"""A connection whose messages are checked before viser sees them, at a bounded rate."""

import asyncio
import socket
from typing import Any, Protocol

from viser import ClientHandle
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode

from . import message_schema
from .message_schema import Hostile, Refused
from .rate_limits import TokenBucket
from .validation import PART, MessageValidator

MOST_MESSAGE = PART + 4096  # bytes
FRAMES_A_SECOND, FRAMES_AT_ONCE = 150, 600  # of all kinds; a browser sends at most 20 a second and widget
REFUSALS_A_SECOND, REFUSALS_AT_ONCE = 0.5, 20  # messages that are dropped, before the client is closed
PAGE_WITHIN = 30.0  # s from the handshake to the first camera message
UNSENT = 1 << 18  # bytes that the system keeps for a client that is slow to take them
OPEN_FILES = 200  # connections at a time that are no seats yet, such as page loads


class Host(Protocol):
    """What a connection asks of the server that it belongs to. opened: connections of any kind; seats: of clients."""

    opened: int
    seats: set["GuardedConnection"]

    def note(self, connection: "GuardedConnection", what: str) -> None: ...

    def client_of(self, connection: "GuardedConnection") -> ClientHandle | None: ...

    def belongs_to_another(self, uuid: str) -> bool: ...

    def leave(self, connection: "GuardedConnection") -> None: ...


class GuardedConnection(ServerConnection):
    """A connection whose `recv` returns messages that were checked only. token: of its browser, None without one."""

    def __init__(self, host: Host, *args, **limits):
        super().__init__(*args, **limits)
        self._host = host
        self.token: str | None = None
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
        self._host.opened += 1
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNSENT)
        if self._host.opened - len(self._host.seats) > OPEN_FILES:
            transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        self._host.opened -= 1
        self._host.leave(self)
        if self._starts is not None:
            self._starts.cancel()
        super().connection_lost(exc)

    def take_seat(self, token: str | None) -> None:
        self.token = token
        self._starts = self.loop.call_later(PAGE_WITHIN, self._end_if_idle)

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
                self._host.note(self, str(refusal))
                if not self._refusals.take():
                    self._end(CloseCode.POLICY_VIOLATION, "too many messages that make no sense")
            except Hostile as refusal:
                self._end(CloseCode.POLICY_VIOLATION, str(refusal))

    def _admit(self, raw: bytes | str) -> None:
        message = message_schema.read(raw)
        if self._validator is None:
            client = self._host.client_of(self)
            if client is None:
                if not isinstance(message, message_schema.ViewerCameraMessage):
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
        """Say it in the log and close; what comes after is not read any more."""
        if self._failing is None:
            self._host.note(self, f"{what}; closed")
            self._failing = self.loop.create_task(self._fail(code, what))

    async def _fail(self, code: CloseCode, what: str) -> None:
        try:
            async with self.send_context():
                self.protocol.fail(code, what.encode()[:100].decode(errors="ignore"))
        except ConnectionClosed:
            pass
