"""Who may connect, and what each answer says about itself.

viser opens a websocket server that takes anybody, from any page, and any message; this stands around it.
"""

import asyncio
import http
import json
import logging
import socket
from collections.abc import Callable, Iterable

import viser
from viser import ViserServer
from websockets.datastructures import Headers
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.typing import Origin

from .. import viser_private
from .address import is_own_page
from .connection import CONNECTION, MOST_MESSAGE, GuardedConnection, plain_response
from .limits import (
    LINES_A_SECOND,
    LINES_AT_ONCE,
    Limits,
    PendingConnections,
    QuietLog,
    TokenBucket,
    in_a_line,
    logger_of,
)
from .page_head import content_policy, with_own_head
from .seats import Seats

FAULTS_A_SECOND = 1.0  # of the machinery, in the log
VERSION = "viser-v"
OWN_VERSION = VERSION + viser.__version__  # of the page, as its handshake says it
LAB_HEADERS = {"X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer"}  # its policy is in the page
log = logging.getLogger(__name__)

MAKE_ROOM = "This page tries again every few seconds; close a tab elsewhere to make room."
NO_SEAT = f"""<!doctype html><html><meta charset="utf-8"><meta http-equiv="refresh" content="5">
<link rel="icon" href="data:,"><title>{"viewimit: all seats are taken"}</title>
<body style="font:18px system-ui,sans-serif;margin:15vh auto;max-width:32em">
<h1>{"All seats are taken"}</h1><p>{{why}} {MAKE_ROOM}</p>
</body></html>"""


class AccessControl:
    """`serve` stands for websockets' own. limits: of each process; origins: pages elsewhere that may connect, as
    scheme://host:port; seats: of all processes; process: number of this one; listening: a socket to serve on, None:
    a port of its own; lab: pages of the lab, itself "", lessons by name.
    """

    def __init__(
        self,
        limits: Limits,
        origins: Iterable[str],
        seats: Seats,
        process: int = 0,
        listening: socket.socket | None = None,
        lab: Callable[[str], str | None] = lambda lesson: None,
    ):
        self._lab = lab
        self.limits, self._origins = limits, frozenset(origins)
        self._all_seats, self._own, self._listening = seats, seats.rows[process], listening
        self._server: ViserServer | None = None
        self._guarded = asyncio.Event()
        self.seats: set[GuardedConnection] = set()
        self.pending = PendingConnections(limits.pending, limits.pending_of_one)
        self._log = QuietLog(log, TokenBucket(LINES_A_SECOND, LINES_AT_ONCE))
        self._faults = QuietLog(log, TokenBucket(FAULTS_A_SECOND, 1))

    def guard(self, server: ViserServer) -> None:
        """Guard the clients of a server. Nobody gets a seat before."""
        self._server = server
        server.get_event_loop().call_soon_threadsafe(self._guarded.set)

    def serve(self, plain: Callable, handler, host, port, *, process_request, **options):
        def connect(protocol, websockets_server, **limits) -> GuardedConnection:
            return GuardedConnection(self, protocol, websockets_server, **limits)

        async def handle(connection: GuardedConnection) -> None:
            if connection.subprotocol != OWN_VERSION:  # viser would print the version as it is sent
                theirs = (connection.subprotocol or "unknown").removeprefix(VERSION)[:40]
                self.note(connection, f"a page of another version, {theirs}")
                said = f"Version mismatch. Client: {theirs}, Server: {viser.__version__}"  # as viser's page knows it
                await connection.close(CloseCode.PROTOCOL_ERROR, said)
                return
            CONNECTION.set(connection)  # for all tasks of it, which viser begins in this context
            await handler(connection)

        loop = asyncio.get_running_loop()
        loop.set_exception_handler(
            lambda __, context: self._faults.warn(in_a_line(context["message"], context.get("exception")))
        )
        place = {"host": host, "port": port} if self._listening is None else {"sock": self._listening}
        return plain(
            handle,
            **place,
            **options
            | {
                "process_request": lambda connection, request: self._answer(connection, request, process_request),
                "create_connection": connect,
                "max_size": MOST_MESSAGE,
                "ping_interval": self.limits.ping_every,
                "ping_timeout": self.limits.pong_within,
                "close_timeout": self.limits.closed_within,
                "server_header": None,
                "logger": logger_of(self._faults.warn),
            },
        )

    def note(self, connection: GuardedConnection, what: str) -> None:
        self._log.warn(f"{connection.name}: refused {what}")

    def belongs_to_another(self, uuid: str) -> bool:
        clients = {} if self._server is None else self._server.get_clients()
        return any(uuid in viser_private.own(client).widgets for client in clients.values())

    @property
    def full(self) -> bool:
        """Whether all processes together have as many tabs as they may; each may be one too many."""
        return self._all_seats.taken >= self.limits.seats

    def full_for(self, address: int) -> bool:
        """Whether as many tabs are open from there as one address may have."""
        return self._all_seats.taken_from(address) >= self.limits.seats_of_one

    async def _answer(self, connection: GuardedConnection, request: Request, viser_answers: Callable):
        """Return a response, or None to take the websocket. Wait until the server is guarded."""
        answer = await self._answer_whole(connection, request, viser_answers)
        if answer is not None and connection.is_head_request:
            answer.body = b""
        return answer

    async def _answer_whole(self, connection: GuardedConnection, request: Request, viser_answers: Callable):
        await self._guarded.wait()
        if connection.transport.is_closing():  # it did not
            return plain_response(http.HTTPStatus.SERVICE_UNAVAILABLE, "gone")
        path = request.path.partition("?")[0]
        if path == "/health":
            return self._tell_health()
        if path == "/lab" or path.startswith("/lab/"):
            return await self._answer_lab(path[5:])
        try:
            answer = viser_answers(connection, request)
        except (OSError, ValueError):  # a path that no file can have
            answer = plain_response(http.HTTPStatus.NOT_FOUND, "not found")
        if answer is None:
            return self._refuse_seat(connection, request)
        if answer.status_code == http.HTTPStatus.NOT_FOUND:
            answer = plain_response(http.HTTPStatus.NOT_FOUND, "not found")
        is_page = answer.headers.get("Content-Type", "").startswith("text/html")
        if is_page and self.full:
            why = f"{self._all_seats.taken} tabs are open here, which is as many as there is room for."
            answer = plain_response(http.HTTPStatus.SERVICE_UNAVAILABLE, NO_SEAT.format(why=why), "text/html")
        elif is_page and self.full_for(connection.network):
            why = (
                f"{self.limits.seats_of_one} tabs are open from your address, which is as many as one address may have."
            )
            answer = plain_response(http.HTTPStatus.TOO_MANY_REQUESTS, NO_SEAT.format(why=why), "text/html")
        elif is_page:
            with_own_head(answer)
        _describe(answer.headers, request.headers.get("Host", ""))
        return answer

    async def _answer_lab(self, name: str) -> Response:
        """Return the page of the lab or a lesson."""
        page = await asyncio.to_thread(self._lab, name)
        if page is None:
            return plain_response(http.HTTPStatus.NOT_FOUND, "no such lesson")
        return plain_response(http.HTTPStatus.OK, page, "text/html", **LAB_HEADERS)

    def _refuse_seat(self, connection: GuardedConnection, request: Request) -> Response | None:
        origin, host = request.headers.get("Origin"), request.headers.get("Host", "")
        if origin is not None and not is_own_page(Origin(origin), host, self._origins):
            self.note(connection, f"a page of {origin} on {host}; --origin {origin} would let it in")
            return plain_response(http.HTTPStatus.FORBIDDEN, "not from there")
        if self.full:
            self.note(connection, f"a seat: all {self.limits.seats} are taken")
            return plain_response(http.HTTPStatus.SERVICE_UNAVAILABLE, "all seats are taken")
        if self.full_for(connection.network):
            most = self.limits.seats_of_one
            self.note(connection, f"a seat: its address has {most} already; --max-per-address allows more")
            return plain_response(http.HTTPStatus.TOO_MANY_REQUESTS, "all seats of one address are taken")
        self.pending.discard(connection)
        self.seats.add(connection)
        self._own.take(connection.network)
        connection.take_seat()
        return None

    def leave(self, connection: GuardedConnection) -> None:
        """Free the place of a connection that has ended."""
        self.pending.discard(connection)
        if connection in self.seats:
            self.seats.discard(connection)
            self._own.leave(connection.network)

    def _tell_health(self) -> Response:
        well = self._all_seats.well
        status = http.HTTPStatus.OK if well else http.HTTPStatus.SERVICE_UNAVAILABLE
        report = {
            "status": "ok" if well else "failing",
            "clients": self._all_seats.taken,
            "workers": len(self._all_seats.rows),
        }
        return plain_response(status, json.dumps(report) + "\n", "application/json")


def _describe(headers: Headers, host: str) -> None:
    """Add the headers for security: where the page may connect to, and that its types are as declared."""
    headers["Content-Security-Policy"] = content_policy(host)
    headers["X-Content-Type-Options"] = "nosniff"
    headers["Referrer-Policy"] = "no-referrer"
    headers["Cross-Origin-Opener-Policy"] = "same-origin"
    for name, value in (("Cache-Control", "no-cache"), ("Connection", "close")):
        headers.pop(name, None)  # to set one that is there would add to it
        headers[name] = value
