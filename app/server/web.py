"""HTTP and websockets on one port, by websockets' own server: what the Workbench's connections and a class's share."""

import logging
import re
import socket
from collections.abc import Callable, Sequence
from http import HTTPStatus
from typing import Any

from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from .limits import Limits, PendingConnections, network_of

AS_GET = re.compile(rb"(?:GET|HEAD) (\S+) HTTP/1\.[01](?=\r\n)")  # websockets reads GET of HTTP/1.1 alone
UNSENT = 1 << 18  # bytes that the system keeps for a client: a ping does not wait long behind them
TAKES_WITHIN = 60_000  # ms, in which a client takes something of what is sent to it (Linux)
HOST = re.compile(r"[\w.:\[\]-]{1,255}")
OF_CLIENTS = "opening handshake failed"  # websockets logs it of clients that ask for nothing, or not for a websocket
log = logging.getLogger("viewimit.websockets")
log.addFilter(lambda record: record.getMessage() != OF_CLIENTS)


class Connection(ServerConnection):
    """A connection that also answers HEAD and HTTP/1.0, and counts as pending until it is admitted. network: where it
    comes from."""

    is_head_request = False

    def __init__(self, pending: PendingConnections, *args, **limits):
        super().__init__(*args, **limits)
        self.pending, self.network = pending, network_of(None)

    def connection_made(self, transport) -> None:
        super().connection_made(transport)
        self.network = network_of(self.remote_address)
        self.pending.add(self, self.network, transport.abort)
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
        self.pending.discard(self)
        super().connection_lost(exc)


def plain_response(status: HTTPStatus, text: str, kind: str = "text/plain", **more: str) -> Response:
    """Return an answer with which the connection ends. more: further headers."""
    body = text.encode()
    headers = Headers({"Content-Type": f"{kind}; charset=utf-8", "Content-Length": str(len(body)), **more})
    headers["Connection"] = "close"
    headers["Cache-Control"] = "no-store"
    return Response(status.value, status.phrase, headers, body)


def content_policy(host: str, scripts: str, *more: str, ancestors: Sequence[str] = ()) -> str:
    """Return the content policy of a page that may talk to its own host alone. host: as the request names it; scripts:
    its sources; more: further rules; ancestors: origins of pages that may show it in a frame."""
    sockets = f" ws://{host} wss://{host}" if HOST.fullmatch(host) else ""
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {scripts}",
            "style-src 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "font-src data:",
            f"connect-src 'self' data: blob:{sockets}",
            "base-uri 'none'",
            "form-action 'none'",
            " ".join(("frame-ancestors 'self'", *ancestors)),
            *more,
        )
    )


def serving_options(create: Callable, answer: Callable, max_size: int, limits: Limits) -> dict[str, Any]:
    """Return options for `websockets.asyncio.server.serve`. create: makes a `Connection`; answer(connection, request):
    a response, or None for a websocket."""
    return {
        "create_connection": create,
        "process_request": answer,
        "process_response": _without_body,
        "max_size": max_size,
        "ping_interval": limits.ping_every,
        "ping_timeout": limits.pong_within,
        "open_timeout": limits.head_within,
        "close_timeout": limits.closed_within,
        "server_header": None,
        "logger": log,
    }


def _without_body(connection: Connection, _request: Request, response: Response) -> None:
    if connection.is_head_request:
        response.body = b""
