"""Links in a page's drawings: followed by a click or by Enter, they reach the page as a GET, without a script.

    /touch/<worker>.<secret>/<control>/<value>

A GET that changes something needs what nobody else has: the secret of one tab, and its browser's cookie.
"""

import http
import re
import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ..sessions.link import MOST_CHARS
from .cookie import token_of
from .message_schema import Refused
from .rate_limits import TokenBucket

TOUCHES_A_SECOND, TOUCHES_AT_ONCE = 5, 30  # of one tab
ROOT = "/touch/"
_WORKER = re.compile(rb"GET /touch/(\d{1,3})\.")
_TOUCH = re.compile(r"(/touch/\d{1,3}\.[\w-]{32})/([a-z]{1,20})/([-+.,\w]+)", re.ASCII)
_MOST_CHARS = {"link": MOST_CHARS, "unseen": 120}  # of a value; of all others 40


class NotTouched(Refused):
    """A request that touches nothing. status: with which it is answered."""

    def __init__(self, status: http.HTTPStatus, what: str):
        super().__init__(what)
        self.status = status


@dataclass(frozen=True)
class _Tab:
    """touch(control, value): whether the page has that control; token: of its browser."""

    touch: Callable[[str, str], bool]
    token: str
    bucket: TokenBucket = field(default_factory=lambda: TokenBucket(TOUCHES_A_SECOND, TOUCHES_AT_ONCE))


class Touches:
    """Tabs of one process by the address that their links begin with. worker: number of the process."""

    def __init__(self, worker: int):
        self._worker = worker
        self._tabs: dict[str, _Tab] = {}

    def new_address(self) -> str:
        return f"{ROOT}{self._worker}.{secrets.token_urlsafe(24)}"

    def open(self, address: str, touch: Callable[[str, str], bool], token: str) -> None:
        self._tabs[address] = _Tab(touch, token)

    def close(self, address: str | None) -> None:
        if address is not None:
            self._tabs.pop(address, None)

    def follow(self, path: str, headers: Mapping[str, str]) -> None:
        """Hand a request to the page that it is of. Raises NotTouched."""
        asked = _TOUCH.fullmatch(path)
        if asked is None or len(asked[3]) > _MOST_CHARS.get(asked[2], 40):
            raise NotTouched(http.HTTPStatus.NOT_FOUND, "a touch of an address that no link has")
        # Browsers tell this on https and on their own machine only; elsewhere secret and cookie must do
        site = headers.get("Sec-Fetch-Site", "same-origin")
        if site != "same-origin":
            raise NotTouched(http.HTTPStatus.FORBIDDEN, f"a touch from a page elsewhere ({site[:20]})")
        if "Sec-Purpose" in headers:
            raise NotTouched(http.HTTPStatus.FORBIDDEN, "a touch that nobody has made: it was fetched beforehand")
        address, control, value = asked.groups()
        tab = self._tabs.get(address)
        if tab is None or token_of(headers) != tab.token:
            raise NotTouched(http.HTTPStatus.FORBIDDEN, "a touch of a page that this browser does not have")
        if not tab.bucket.take():
            raise NotTouched(http.HTTPStatus.TOO_MANY_REQUESTS, "too many touches")
        if not tab.touch(control, value):
            raise NotTouched(http.HTTPStatus.NOT_FOUND, f"a touch of {control!r}, which no page has")


def worker_of(head: bytes) -> int | None:
    """Number of the process whose page a request's head is for; None for what is no touch."""
    found = _WORKER.match(head)
    return None if found is None else int(found[1])
