"""A connection, whose messages are checked before viser sees them."""

import asyncio
import logging
from collections.abc import Callable
from contextlib import suppress
from contextvars import ContextVar
from typing import Any

from viser import ClientHandle
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode

from . import messages
from .limits import Limits, PendingConnections, TokenBucket
from .messages import PART, Hostile, MessageValidator, Refused
from .web import Connection

MOST_MESSAGE = PART + 4096  # bytes
FRAMES_A_SECOND, FRAMES_AT_ONCE = 150, 600  # of all kinds; a browser sends at most 20 a second and widget
REFUSALS_A_SECOND, REFUSALS_AT_ONCE = 0.5, 20  # messages that are dropped, before the client is closed
log = logging.getLogger(__name__)


class GuardedConnection(Connection):
    """A connection whose `recv` returns messages that were checked only. client: viser's of it, from the first view on;
    seats: those that are taken; belongs_to_another(uuid): whether another client has such a widget."""

    client: ClientHandle | None = None

    def __init__(
        self, pending: PendingConnections, seats: set["GuardedConnection"], limits: Limits,
        belongs_to_another: Callable[[str], bool], *args, **options,
    ):  # fmt: skip
        super().__init__(pending, *args, **options)
        self._seats, self._limits, self._belongs_to_another = seats, limits, belongs_to_another
        self._frames = TokenBucket(FRAMES_A_SECOND, FRAMES_AT_ONCE)
        self._refusals = TokenBucket(REFUSALS_A_SECOND, REFUSALS_AT_ONCE)
        self._validator: MessageValidator | None = None
        self._failing: asyncio.Task | None = None
        self._starts: asyncio.TimerHandle | None = None

    def note(self, what: str) -> None:
        """Log what is refused, which may hold what the client wrote."""
        name = "{}:{}".format(*self.remote_address[:2]) if self.remote_address else "a client that is gone"
        log.warning("%s: refused %s", name, ascii(what)[1:-1][:300])

    def connection_lost(self, exc: Exception | None) -> None:
        self._seats.discard(self)
        if self._starts is not None:
            self._starts.cancel()
        super().connection_lost(exc)

    def take_seat(self) -> None:
        self.pending.discard(self)
        self._seats.add(self)
        self._starts = self.loop.call_later(self._limits.page_within, self._end_if_idle)

    def _end_if_idle(self) -> None:
        if self.client is None:
            self._end(CloseCode.POLICY_VIOLATION, "a seat for nobody: no page has come")

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
                    self.note(f"a message of more than {MOST_MESSAGE} bytes")
                raise
            try:
                self._admit(raw)
                return raw
            except Refused as refusal:
                if not self._refusals.take():
                    self._end(CloseCode.POLICY_VIOLATION, "too many messages that make no sense")
                elif self._failing is None:
                    self.note(str(refusal))
            except Hostile as refusal:
                self._end(CloseCode.POLICY_VIOLATION, str(refusal))

    def _admit(self, raw: bytes | str) -> None:
        message = messages.read(raw)
        if self._validator is None:
            if self.client is None:
                if not isinstance(message, messages.ViewerCameraMessage):
                    raise Hostile(f"{message.type} before the first view")
                return
            self._validator = MessageValidator(self.client, self._belongs_to_another)
            if self._starts is not None:
                self._starts.cancel()
        self._validator.admit(message)

    def _end(self, code: CloseCode, what: str) -> None:
        """Log the reason and close. Later messages are not read; without a closing handshake it is aborted."""
        if self._failing is None:
            self.note(f"{what}; closed")
            self._failing = self.loop.create_task(self._fail(code, what))
            self.loop.call_later(self._limits.closed_within, self.transport.abort)

    async def _fail(self, code: CloseCode, what: str) -> None:
        with suppress(ConnectionClosed):
            async with self.send_context():
                self.protocol.fail(code, what.encode()[:100].decode(errors="ignore"))


CONNECTION: ContextVar[GuardedConnection] = ContextVar("connection")  # whose messages are being answered
