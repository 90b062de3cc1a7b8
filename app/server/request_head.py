"""The head of a request, before websockets reads it, which answers nothing but a GET of HTTP/1.1."""

import http
import re
from collections.abc import Generator
from dataclasses import dataclass

from websockets.exceptions import SecurityError
from websockets.http11 import Request
from websockets.streams import StreamReader

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
