"""How the lecturer of a class is known: by an address with a secret, which is traded for a cookie.

    /lecturer/<secret>

The page itself then has no secret in its address. No answer and no line of the log tells a wrong secret from a right
one that is another server's.
"""

import hashlib
import hmac
import http
import re
import secrets
from collections.abc import Mapping

from websockets.http11 import Response

from .cookie import cookie_for, cookie_name, cookie_value, token_of
from .responses import plain_response

ROOT = "/lecturer/"
LEAST_SECRET, MOST_SECRET = 16, 200  # characters
_SECRET = re.compile(r"[\w.~-]+", re.ASCII)


def new_secret() -> str:
    return secrets.token_urlsafe(24)


def require_secret(secret: str) -> None:
    """Raises ValueError for one that can be guessed, or stands in no address."""
    if not LEAST_SECRET <= len(secret) <= MOST_SECRET or not _SECRET.fullmatch(secret):
        raise ValueError(
            f"a lecturer's secret has {LEAST_SECRET} to {MOST_SECRET} letters, digits, '-', '_', '.' or '~'"
        )


def class_name(secret: str) -> str:
    """Of the class, in a store that may have others; nobody can tell the secret from it."""
    return _derived(secret, "class")[:32]


class LecturerAccess:
    """secret: None where there is no lecturer."""

    def __init__(self, secret: str | None):
        self._secret = None if secret is None else secret.encode()
        self._cookie = "" if secret is None else _derived(secret, "cookie")

    def answer(self, path: str, headers: Mapping[str, str]) -> Response | None:
        """To who opens the lecturer's address; None to who has another secret."""
        said = path.removeprefix(ROOT).encode(errors="replace")
        if self._secret is None or not hmac.compare_digest(said, self._secret):
            return None
        answer = plain_response(http.HTTPStatus.SEE_OTHER, "", Location="/")
        answer.headers["Referrer-Policy"] = "no-referrer"
        answer.headers["Set-Cookie"] = cookie_for(headers, _name(headers), self._cookie)
        if token_of(headers) is None:
            answer.headers["Set-Cookie"] = cookie_for(headers)  # websockets sends both
        return answer

    def is_lecturer(self, headers: Mapping[str, str]) -> bool:
        """Whether a request comes from a browser that has opened the lecturer's address."""
        if self._secret is None:
            return False
        value = cookie_value(headers, _name(headers))
        return value is not None and hmac.compare_digest(value.encode(errors="replace"), self._cookie.encode())


def _name(headers: Mapping[str, str]) -> str:
    return cookie_name(headers).replace("viewimit", "lecturer")  # a proxy tells browsers apart by viewimit…


def _derived(secret: str, what: str) -> str:
    return hmac.new(secret.encode(), f"viewimit {what}".encode(), hashlib.sha256).hexdigest()
