"""A lecturer's own lesson on a server with several processes: each offers it first, and the tour after it."""

import re
import socket
import urllib.request
from contextlib import ExitStack

import pytest
from protocol import Client
from serving import Server, browser_of
from test_lesson_files import CHOICE, GOOD
from waiting import wait_until

pytestmark = pytest.mark.skipif(not hasattr(socket, "send_fds"), reason="processes cannot hand over sockets here")


def written(client):
    return "".join(client.html.values())


def begin(client, url, cookie):
    """The lesson that is offered, by its link → which process that leads to."""
    wait_until(lambda: "New here?</b> Mine, 1 min: A lesson of one step." in written(client))
    links = re.findall(r'href="(/touch/(\d)\.[^"]*/lesson/begin,([-\w]+))"', written(client))
    assert [name.split("-")[0] for *_, name in links][:2] == ["mine", "tour"]
    urllib.request.urlopen(urllib.request.Request(url + links[0][0], headers={"Cookie": cookie})).close()
    wait_until(lambda: 'data-screen="where"' in written(client))
    return links[0][1]


def test_every_process_offers_it_first(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD + CHOICE)
    server = Server("--workers", "2", "--lesson", str(path))
    workers = set()
    with ExitStack() as tabs:
        tabs.callback(server.stop)
        for _ in range(8):  # all stay, so that some go to the other process
            cookie = browser_of(server.url)
            client = tabs.enter_context(Client(server.url, cookie=cookie)).ready()
            workers.add(begin(client, server.url, cookie))
            if len(workers) == 2:
                break
    assert workers == {"0", "1"}
