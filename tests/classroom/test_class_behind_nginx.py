"""A class works in an installed Firefox and in Chromium, below a path of a real nginx."""

import nginx
import pytest
from class_server import ClassServer

pytestmark = [pytest.mark.browser, pytest.mark.skipif(nginx.PROGRAM is None, reason="no nginx")]


def test_a_class_works_below_a_path(window, tmp_path):
    server = ClassServer()
    try:
        with nginx.below_a_path(server.url, tmp_path) as address:
            window.goto(address)
            window.wait_for("classroom.link.isOpen")
    finally:
        server.kill()
