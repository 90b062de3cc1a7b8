"""viser's page: its title, icon and script, and its content security policy.

viser's page is one file: a script that unpacks another one, with WebAssembly, and puts it into the document. Both and
the page's own are named in the policy by their hashes, so that no other script runs.
"""

import base64
import gzip
import hashlib
import re
from functools import cache, lru_cache
from pathlib import Path
from urllib.parse import quote

import numpy as np
import viser
import zstandard
from websockets.http11 import Response

from viewimit.drawing.theme import ROLES

from ..static import PAGE_JS

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
DIGITS = r"!#$%()*+,-./0123456789:;=?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\]^_abcdefghijklmnopqrstuvwxyz{|}~"  # of base 88
_LOADER = re.compile(
    r'<script data-p="(?P<packed>[^"]*)"\s+data-ss="(?P<style>\d+)"\s+data-cs="(?P<code>\d+)">(?P<script>.*?)</script>',
    re.DOTALL,
)


def content_policy(host: str) -> str:
    """host: as the request names it. The page may talk to that one alone."""
    itself = f" ws://{host} wss://{host}" if re.fullmatch(r"[\w.:\[\]-]+", host) else ""
    scripts = " ".join(f"'sha256-{digest}'" for digest in script_hashes())
    return "; ".join(
        (
            "default-src 'none'",
            f"script-src {scripts} 'unsafe-eval'",  # with which the page's WebAssembly binds its functions
            "worker-src blob:",
            "style-src 'unsafe-inline'",
            "img-src 'self' data: blob:",
            "font-src data:",
            f"connect-src 'self' data: blob:{itself}",
            "base-uri 'none'",
            "form-action 'none'",
            "frame-ancestors 'self'",
        )
    )


@cache
def script_hashes() -> tuple[str, ...]:
    """SHA-256 of the page's own script and of those of viser's page, in base 64. Raises RuntimeError for a page that is
    built otherwise."""
    page = PAGE.read_text("utf-8")
    loader = _LOADER.search(page)
    if loader is None or page.count("<script") != 1:
        raise RuntimeError("viser's page is built in a way that its content security policy is not known for")
    sizes = int(loader["style"]), int(loader["code"])
    unpacked = zstandard.ZstdDecompressor().decompress(_from_base_88(loader["packed"]), max_output_size=sum(sizes))
    return tuple(_hash(script) for script in (PAGE_JS.encode(), loader["script"].encode(), unpacked[sizes[0] :]))


def _hash(script: bytes) -> str:
    return base64.b64encode(hashlib.sha256(script).digest()).decode()


def _from_base_88(text: str) -> bytes:
    """Decode: five digits are four bytes, the most significant first; n digits at the end are n - 1 bytes."""
    values = np.full(128, 0, np.uint64)
    values[np.frombuffer(DIGITS.encode(), np.uint8)] = np.arange(len(DIGITS))
    digits = values[np.frombuffer(text.encode(), np.uint8)]
    whole = len(digits) // 5 * 5
    powers = np.uint64(88) ** np.arange(4, -1, -1, dtype=np.uint64)
    words = (digits[:whole].reshape(-1, 5) * powers).sum(-1).astype(">u4").tobytes()
    rest = 0
    for digit in digits[whole:]:
        rest = rest * 88 + int(digit)
    return words + (rest.to_bytes(len(digits) - whole - 1, "big") if whole < len(digits) else b"")
