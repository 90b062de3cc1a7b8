"""The random token by which a browser is known again: a cookie that scripts cannot read and other sites do not send."""

import re
import secrets
from collections.abc import Mapping
from email.message import Message

MAX_AGE = 24 * 3600  # s
_TOKEN = re.compile(r"[\w-]{32}")
Headers = Mapping[str, str] | Message  # of a request; both know names in any case


def cookie_for(headers: Headers, name: str | None = None, value: str | None = None) -> str:
    """Set-Cookie, if nothing else is said, with a new token."""
    secure = "; Secure" if headers.get("X-Forwarded-Proto") == "https" else ""
    value = value or secrets.token_urlsafe(24)
    return f"{name or cookie_name(headers)}={value}; Path=/; Max-Age={MAX_AGE}; HttpOnly; SameSite=Strict{secure}"


def token_of(headers: Headers) -> str | None:
    """The token of a request, None without a good one."""
    value = cookie_value(headers, cookie_name(headers))
    return value if value is not None and _TOKEN.fullmatch(value) else None


def cookie_value(headers: Headers, name: str) -> str | None:
    """Of the cookie of that name, as it was sent: ours are never quoted. http.cookies takes time with the square of a
    quoted value's length."""
    for cookie in (headers.get("Cookie", "") or "").split(";"):
        found, equals, value = cookie.strip().partition("=")
        if equals and found == name:
            return value
    return None


def cookie_name(headers: Headers) -> str:
    """Cookies do not tell ports apart: two servers on one machine must not take each other's."""
    port = re.search(r":(\d{1,5})$", headers.get("Host", "") or "")
    return f"viewimit-{port.group(1)}" if port else "viewimit"
