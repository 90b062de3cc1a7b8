"""Who may connect, and what each answer says about itself. viser opens a websocket server that takes anybody, from any
page, and any message; this stands around it."""

import asyncio
import json
import logging
from collections.abc import Callable, Iterable
from functools import partial
from http import HTTPStatus

import viser
from viser import ViserServer
from websockets.datastructures import MultipleValuesError
from websockets.frames import CloseCode
from websockets.http11 import Request, Response
from websockets.typing import Origin

from .. import viser_private
from .address import is_own_page
from .connection import CONNECTION, MOST_MESSAGE, GuardedConnection
from .limits import PENDING, Limits, PendingConnections, TokenBucket, in_a_line
from .page_head import page_policy, with_own_head
from .web import plain_response, serving_options

VERSION = "viser-v"
OWN_VERSION = VERSION + viser.__version__  # of the page, as its handshake says it
LAB_HEADERS = {"X-Content-Type-Options": "nosniff", "Referrer-Policy": "no-referrer"}  # its policy is in the page
log = logging.getLogger(__name__)

NO_SEAT = "All seats are taken ({why}). This page tries again every few seconds; close a tab elsewhere to make room.\n"


class AccessControl:
    """`serve` stands for websockets' own. origins: pages elsewhere that may connect, as scheme://host:port; lab: pages
    of the lab, itself "", lessons by name."""

    def __init__(self, limits: Limits, origins: Iterable[str], lab: Callable[[str], str | None] = lambda lesson: None):
        self._lab = lab
        self.limits, self._origins = limits, frozenset(origins)
        self._server: ViserServer | None = None
        self._guarded = asyncio.Event()
        self.seats: set[GuardedConnection] = set()
        self._faults = TokenBucket(1, 1)
        self.pending = PendingConnections(PENDING, limits.pending_of_one)

    def guard(self, server: ViserServer) -> None:
        """Guard the clients of a server. Nobody gets a seat before."""
        self._server = server
        server.get_event_loop().call_soon_threadsafe(self._guarded.set)

    def serve(self, plain: Callable, handler, host, port, *, process_request, **options):
        async def handle(connection: GuardedConnection) -> None:
            if connection.subprotocol != OWN_VERSION:  # viser would print the version as it is sent
                theirs = (connection.subprotocol or "unknown").removeprefix(VERSION)[:40]
                connection.note(f"a page of another version, {theirs}")
                said = f"Version mismatch. Client: {theirs}, Server: {viser.__version__}"  # as viser's page knows it
                await connection.close(CloseCode.PROTOCOL_ERROR, said)
                return
            CONNECTION.set(connection)  # for all tasks of it, which viser begins in this context
            await handler(connection)

        asyncio.get_running_loop().set_exception_handler(self._tell_fault)
        create = partial(GuardedConnection, self.pending, self.seats, self.limits, self.belongs_to_another)
        answer = lambda connection, request: self._answer(connection, request, process_request)
        return plain(handle, host, port, **options | serving_options(create, answer, MOST_MESSAGE, self.limits))

    def _tell_fault(self, _loop: asyncio.AbstractEventLoop, context: dict) -> None:
        """Without file descriptors asyncio tells a hundred a second."""
        if self._faults.take():
            log.error(in_a_line(context["message"], context.get("exception")))

    def belongs_to_another(self, uuid: str) -> bool:
        clients = {} if self._server is None else self._server.get_clients()
        return any(uuid in viser_private.own(client).widgets for client in clients.values())

    def _no_seat(self, connection: GuardedConnection) -> tuple[HTTPStatus, str] | None:
        """Return why there is no seat for a connection; None if there is one."""
        if len(self.seats) >= self.limits.seats:
            return HTTPStatus.SERVICE_UNAVAILABLE, f"all {self.limits.seats} are taken"
        most = self.limits.seats_of_one
        if sum(seat.network == connection.network for seat in self.seats) >= most:
            return HTTPStatus.TOO_MANY_REQUESTS, f"its address has {most} already; --max-per-address allows more"
        return None

    async def _answer(self, connection: GuardedConnection, request: Request, viser_answers: Callable):
        """Return a response, or None to take the websocket; a fault of its own is a line of the log, and a status."""
        try:
            return await self._answer_as_asked(connection, request, viser_answers)
        except MultipleValuesError as header:
            connection.note(f"a request with more than one {header}")
            return plain_response(HTTPStatus.BAD_REQUEST, "a header that may come once comes twice\n")
        except Exception as error:
            log.error(in_a_line("a request could not be answered", error))
            return plain_response(HTTPStatus.INTERNAL_SERVER_ERROR, "the server met an error\n")

    async def _answer_as_asked(self, connection: GuardedConnection, request: Request, viser_answers: Callable):
        """Wait until the server is guarded."""
        host, origin = request.headers.get("Host", ""), request.headers.get("Origin")
        await self._guarded.wait()
        if connection.transport.is_closing():  # it did not
            return plain_response(HTTPStatus.SERVICE_UNAVAILABLE, "gone")
        path = request.path.partition("?")[0]
        if path == "/health":
            report = json.dumps({"status": "ok", "clients": len(self.seats)})
            return plain_response(HTTPStatus.OK, report + "\n", "application/json")
        if path == "/lab" or path.startswith("/lab/"):
            if (page := await asyncio.to_thread(self._lab, path[5:])) is None:
                return plain_response(HTTPStatus.NOT_FOUND, "no such lesson")
            return plain_response(HTTPStatus.OK, page, "text/html", **LAB_HEADERS)
        try:
            answer = viser_answers(connection, request)
        except (OSError, ValueError):  # a path that no file can have
            answer = plain_response(HTTPStatus.NOT_FOUND, "not found")
        if answer is None:
            return self._refuse_seat(connection, host, origin)
        if answer.status_code == HTTPStatus.NOT_FOUND:
            answer = plain_response(HTTPStatus.NOT_FOUND, "not found")
        if answer.headers.get("Content-Type", "").startswith("text/html"):
            if no_seat := self._no_seat(connection):
                answer = plain_response(no_seat[0], NO_SEAT.format(why=no_seat[1]), Refresh="5")
            else:
                with_own_head(answer)
        answer.headers.update(LAB_HEADERS)
        answer.headers["Content-Security-Policy"] = page_policy(host)
        answer.headers["Cross-Origin-Opener-Policy"] = "same-origin"
        for name, value in (("Cache-Control", "no-cache"), ("Connection", "close")):
            answer.headers.pop(name, None)  # to set one that is there would add to it
            answer.headers[name] = value
        return answer

    def _refuse_seat(self, connection: GuardedConnection, host: str, origin: str | None) -> Response | None:
        if origin is not None and not is_own_page(Origin(origin), host, self._origins):
            connection.note(f"a page of {origin} on {host}; --origin {origin} would let it in")
            return plain_response(HTTPStatus.FORBIDDEN, "not from there")
        if no_seat := self._no_seat(connection):
            connection.note(f"a seat: {no_seat[1]}")
            return plain_response(no_seat[0], no_seat[1])
        connection.take_seat()
        return None
