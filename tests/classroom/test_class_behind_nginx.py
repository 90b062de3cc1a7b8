"""A class works in an installed Firefox and in Chromium, below a path of a real nginx."""

import contextlib
import urllib.request

import nginx
import pytest
from class_server import ClassServer
from waiting import wait_until
from websockets.sync.client import connect


@pytest.mark.browser
@pytest.mark.skipif(nginx.PROGRAM is None, reason="no nginx")
def test_a_class_works_below_a_path(window, tmp_path):
    server = ClassServer()
    try:
        with nginx.below_a_path(server.url, tmp_path) as address:
            window.goto(address)
            window.wait_for("classroom.link.isOpen")
            window.goto("about:blank")  # else it misses its server
    finally:
        server.kill()


def test_a_class_of_two_hundred_behind_one_router_is_let_in_without_a_login(tmp_path):
    nginx.require_proxy()
    port = nginx.free_port()
    address = f"https://127.0.0.1:{port}/class/"
    behind = ClassServer("--trust-proxy", "*")
    proxy = nginx.Proxy(tmp_path, port, [], behind.url)
    wait_until(lambda: proxy.answers)
    with urllib.request.urlopen(address, context=nginx.TRUSTING, timeout=90) as page:
        assert page.status == 200
    with contextlib.ExitStack() as room:
        for _ in range(200):
            student = connect(address.replace("https", "wss") + "socket", ssl=nginx.TRUSTING, origin=address[:-7])
            room.enter_context(student)
    proxy.stop()
    behind.kill()
