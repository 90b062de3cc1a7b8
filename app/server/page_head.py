"""viser's page: its title, icon and script, and its content security policy. viser's page is one file: a script that
unpacks another one, with WebAssembly, and puts it into the document. The policy names the scripts of the page as it is
served by their hashes; they alone run, and what they make."""

import base64
import gzip
import hashlib
import re
from functools import cache, lru_cache
from pathlib import Path
from urllib.parse import quote

import viser
from websockets.http11 import Response

from viewimit.drawing.theme import ROLES

from ..static import PAGE_JS
from .web import content_policy

TITLE = "viewimit"
_BLUE, _ORANGE, _ARROW = (ROLES[role][0] for role in ("learner", "demonstrator", "residual"))
ICON = (  # a point of the learner, one of the demonstrator, and the residual between them
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32">'
    f'<path d="M9 23L22 10" stroke="{_ARROW}" stroke-width="4"/><circle cx="9" cy="23" r="7" fill="{_BLUE}"/>'
    f'<path d="M23 1l8 8-8 8-8-8z" fill="{_ORANGE}"/></svg>'
)
_TITLE = re.compile(rb"<title>[^<]*</title>")
_ICON = re.compile(rb'(<link\s+rel="icon"\s+href=")[^"]*"')


def with_own_head(response: Response) -> None:
    """Change a response that holds the page, packed by gzip or not."""
    response.body = _named(bytes(response.body), response.headers.get("Content-Encoding") == "gzip")
    del response.headers["Content-Length"]
    response.headers["Content-Length"] = str(len(response.body))


@lru_cache(4)  # viser keeps the page as one object, packed and not
def _named(body: bytes, packed: bool) -> bytes:
    page = gzip.decompress(body) if packed else body
    head = f"<title>{TITLE}</title><script>{PAGE_JS}</script>".encode()
    page = _TITLE.sub(lambda _: head, page, count=1)
    page = _ICON.sub(rb"\g<1>data:image/svg+xml,%s" % quote(ICON).encode() + b'"', page, count=1)
    return gzip.compress(page) if packed else page


PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
_SCRIPTS = re.compile(rb"<script[^>]*>(.*?)</script>", re.DOTALL)


def page_policy(host: str) -> str:
    """Return the content policy of the page. host: as the request names it."""
    scripts = " ".join(f"'sha256-{digest}'" for digest in script_hashes())
    # viser's loader makes a script, which evaluates
    return content_policy(host, f"{scripts} 'strict-dynamic' 'unsafe-eval'", "worker-src blob:")


@cache
def script_hashes() -> tuple[str, ...]:
    """Return the SHA-256 of each script in the page as it is served, in base 64."""
    page = _named(PAGE.read_bytes(), packed=False)
    return tuple(base64.b64encode(hashlib.sha256(script).digest()).decode() for script in _SCRIPTS.findall(page))
