"""The browser's tab says what it shows."""

import gzip
import urllib.request
from urllib.parse import quote

import pytest
from viewimit.app.server.page_head import ICON


@pytest.mark.parametrize("packed", [False, True])
def test_the_page_has_a_title_and_an_icon_of_its_own(server, packed):
    asked = urllib.request.Request(server, headers={"Accept-Encoding": "gzip"} if packed else {})
    with urllib.request.urlopen(asked) as answer:
        body, length = answer.read(), int(answer.headers["Content-Length"])
        assert answer.headers.get("Content-Encoding") == ("gzip" if packed else "identity")
    assert length == len(body)
    page = gzip.decompress(body) if packed else body
    assert page.count(b"<title>viewimit</title>") == 1 and b"<title>Viser" not in page
    assert page.count(quote(ICON).encode()) == 1
