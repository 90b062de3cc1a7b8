"""The door: who may connect, what each answer says about itself, and connections whose messages pass a gate.

viser opens a websocket server that takes anybody, from any page, and any message; the door stands around it.
"""

import asyncio
import http
import json
import logging
import socket
from collections.abc import Callable, Iterable

from viser import ViserServer
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.typing import Origin

from .. import viser_private
from . import message_schema
from .content_policy import content_policy
from .cookie import cookie_for, token_of
from .message_schema import Hostile, Refused
from .origins import is_own_page
from .rate_limits import QuietLog, TokenBucket
from .seat_counts import Row, Tally
from .validation import PART, Gate

MOST_MESSAGE = PART + 4096  # bytes
FRAMES_A_SECOND, FRAMES_AT_ONCE = 150, 600  # of all kinds; a browser sends at most 20 a second and widget
REFUSALS_A_SECOND, REFUSALS_AT_ONCE = 0.5, 20  # messages that are dropped, before the client is closed
PAGE_WITHIN = 30.0  # s from the handshake to the first camera message
PING_EVERY, PONG_WITHIN = 15.0, 15.0  # s: one that does not take what is sent does not answer either
CLOSED_WITHIN = 2.0  # s that a client is given to say goodbye
UNSENT = 1 << 18  # bytes that the system keeps for a client that is slow to take them
OPEN_FILES = 200  # connections at a time that are no seats yet, such as page loads
log = logging.getLogger(__name__)

FULL = """<!doctype html><html lang="en"><meta charset="utf-8"><meta http-equiv="refresh" content="5">
<title>viewimit: all seats are taken</title>
<body style="font:18px system-ui,sans-serif;margin:15vh auto;max-width:32em">
<h1>All seats are taken</h1><p>{count} tabs are open here, which is as many as there is room for. This page tries again
every few seconds; close a tab elsewhere to make room.</p></body></html>"""


class Door:
    """`serve` stands for websockets' own. max_clients: tabs at a time; origins: pages elsewhere that may connect, as
    scheme://host:port; row: this process's of the tally; listening: a socket in place of a port of its own.
    """

    def __init__(
        self,
        max_clients: int,
        origins: Iterable[str],
        tally: Tally,
        row: Row,
        listening: socket.socket | None = None,
    ):
        self._max_clients, self._origins = max_clients, frozenset(origins)
        self._tally, self._row, self._listening = tally, row, listening
        self._server: ViserServer | None = None
        self._guarded = asyncio.Event()
        self.seats: set[GuardedConnection] = set()
        self.opened = 0  # connections that have no seat yet
        self._log = QuietLog(log, TokenBucket(2, 30))

    def guard(self, server: ViserServer) -> None:
        """Whose clients pass it; nobody gets a seat before."""
        self._server = server
        server.get_event_loop().call_soon_threadsafe(self._guarded.set)

    def serve(self, plain: Callable, handler, host, port, *, process_request, **options):
        def connect(protocol, websockets_server, **limits) -> GuardedConnection:
            return GuardedConnection(self, protocol, websockets_server, **limits)

        place = {"host": host, "port": port} if self._listening is None else {"sock": self._listening}
        return plain(
            handler,
            **place,
            **options
            | {
                "process_request": lambda connection, request: self._answer(connection, request, process_request),
                "create_connection": connect,
                "max_size": MOST_MESSAGE,
                "ping_interval": PING_EVERY,
                "ping_timeout": PONG_WITHIN,
                "close_timeout": CLOSED_WITHIN,
                "server_header": None,
            },
        )

    def note(self, connection: "GuardedConnection", what: str) -> None:
        self._log.warn(f"{connection.name}: refused {what}")

    def client_of(self, connection: "GuardedConnection"):
        """Whose connection it is; None before its first camera message."""
        if self._server is None:
            return None
        one = viser_private.connection_of
        clients = self._server.get_clients().items()
        return next((client for number, client in clients if one(self._server, number) is connection), None)

    def belongs_to_another(self, uuid: str) -> bool:
        return any(uuid in viser_private.own(client).widgets for client in self._server.get_clients().values())

    @property
    def full(self) -> bool:
        return len(self.seats) >= self._max_clients

    async def _answer(self, connection: "GuardedConnection", request: Request, viser_answers: Callable):
        """A response, or None: take the websocket. Who comes before all is ready waits."""
        await self._guarded.wait()
        if connection.transport.is_closing():  # it did not
            return _response(http.HTTPStatus.SERVICE_UNAVAILABLE, "gone")
        path = request.path.partition("?")[0]
        if path == "/health":
            return self._tell_health()
        response = viser_answers(connection, request)
        if response is None:
            return self._refuse_seat(connection, request)
        is_page = response.headers.get("Content-Type", "").startswith("text/html")
        if is_page and self.full:
            response = _response(http.HTTPStatus.SERVICE_UNAVAILABLE, FULL.format(count=self._tally.seats), "text/html")
        elif is_page and token_of(request.headers) is None:
            response.headers["Set-Cookie"] = cookie_for(request.headers)
        _describe(response.headers, request.headers.get("Host", ""))
        return response

    def _refuse_seat(self, connection: "GuardedConnection", request: Request) -> Response | None:
        origin, host = request.headers.get("Origin"), request.headers.get("Host", "")
        if origin is not None and not is_own_page(Origin(origin), host, self._origins):
            self.note(connection, f"a page of {origin} on {host}; --origin {origin} would let it in")
            return _response(http.HTTPStatus.FORBIDDEN, "not from there")
        if self.full:
            self.note(connection, f"a seat: all {self._max_clients} are taken")
            return _response(http.HTTPStatus.SERVICE_UNAVAILABLE, "all seats are taken")
        self.seats.add(connection)
        self._row.seats = len(self.seats)
        connection.take_seat(token_of(request.headers))
        return None

    def leave(self, connection: "GuardedConnection") -> None:
        """It has ended."""
        self.seats.discard(connection)
        self._row.seats = len(self.seats)
        self._row.ended += 1

    def _tell_health(self) -> Response:
        well = self._tally.well
        status = http.HTTPStatus.OK if well else http.HTTPStatus.SERVICE_UNAVAILABLE
        told = {"status": "ok" if well else "failing", "clients": self._tally.seats, "workers": len(self._tally.rows)}
        return _response(status, json.dumps(told) + "\n", "application/json")


class GuardedConnection(ServerConnection):
    """A connection whose `recv` returns admitted messages only. token: of its browser, None without one."""

    def __init__(self, door: Door, *args, **limits):
        super().__init__(*args, **limits)
        self._door, self.token = door, None
        self._frames = TokenBucket(FRAMES_A_SECOND, FRAMES_AT_ONCE)
        self._refusals = TokenBucket(REFUSALS_A_SECOND, REFUSALS_AT_ONCE)
        self._gate: Gate | None = None
        self._failing: asyncio.Task | None = None
        self._starts: asyncio.TimerHandle | None = None

    @property
    def name(self) -> str:
        """For the log."""
        address = self.remote_address
        return f"{address[0]}:{address[1]}" if address else "a client that is gone"

    def connection_made(self, transport) -> None:
        super().connection_made(transport)
        self._door.opened += 1
        transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNSENT)
        if self._door.opened - len(self._door.seats) > OPEN_FILES:
            transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        self._door.opened -= 1
        self._door.leave(self)
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

    async def recv(self, decode: bool | None = None) -> bytes:
        """The next message that passes the gate."""
        while True:
            try:
                raw = await super().recv(decode)
            except ConnectionClosed as closed:
                if closed.sent is not None and closed.sent.code == CloseCode.MESSAGE_TOO_BIG:
                    self._door.note(self, f"a message of more than {MOST_MESSAGE} bytes")
                raise
            try:
                self._admit(raw)
                return raw
            except Refused as refusal:
                self._door.note(self, str(refusal))
                if not self._refusals.take():
                    self._end(CloseCode.POLICY_VIOLATION, "too many messages that make no sense")
            except Hostile as refusal:
                self._end(CloseCode.POLICY_VIOLATION, str(refusal))

    def _admit(self, raw: bytes | str) -> None:
        message = message_schema.read(raw)
        if self._gate is None:
            client = self._door.client_of(self)
            if client is None:
                if not isinstance(message, message_schema.ViewerCameraMessage):
                    raise Hostile(f"{type(message).__name__} before the first view")
                return
            self._gate = Gate(client, self._door.belongs_to_another)
            self._starts.cancel()
        self._gate.admit(message)

    def _end_if_idle(self) -> None:
        if self._door.client_of(self) is None:
            self._end(CloseCode.POLICY_VIOLATION, "a seat for nobody: no page has come")

    def _end(self, code: CloseCode, what: str) -> None:
        """Say it in the log and close; what comes after is not read any more."""
        if self._failing is None:
            self._door.note(self, f"{what}; closed")
            self._failing = self.loop.create_task(self._fail(code, what))

    async def _fail(self, code: CloseCode, what: str) -> None:
        try:
            async with self.send_context():
                self.protocol.fail(code, what.encode()[:100].decode(errors="ignore"))
        except ConnectionClosed:
            pass


def _response(status: http.HTTPStatus, text: str, kind: str = "text/plain") -> Response:
    body = text.encode()
    headers = Headers({"Content-Type": f"{kind}; charset=utf-8", "Content-Length": str(len(body))})
    headers["Connection"] = "close"
    headers["Cache-Control"] = "no-store"
    return Response(status.value, status.phrase, headers, body)


def _describe(headers: Headers, host: str) -> None:
    """What a browser must know of an answer: where it may connect to, and that it is what it says."""
    headers["Content-Security-Policy"] = content_policy(host)
    headers["X-Content-Type-Options"] = "nosniff"
    headers["Referrer-Policy"] = "no-referrer"
    headers["Cross-Origin-Opener-Policy"] = "same-origin"
    headers["Cache-Control"] = "no-cache"
