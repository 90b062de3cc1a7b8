"""Answers that are not a page."""

import http

from websockets.datastructures import Headers
from websockets.http11 import Response


def plain_response(status: http.HTTPStatus, text: str, kind: str = "text/plain", **more: str) -> Response:
    """more: further headers. The connection ends with it."""
    body = text.encode()
    headers = Headers({"Content-Type": f"{kind}; charset=utf-8", "Content-Length": str(len(body)), **more})
    headers["Connection"] = "close"
    headers["Cache-Control"] = "no-store"
    return Response(status.value, status.phrase, headers, body)
