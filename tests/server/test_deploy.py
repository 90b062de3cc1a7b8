"""Past one machine: two replicas behind the proxy of deploy/nginx.conf, one of which is killed under its class."""

import contextlib
import threading
import time
from http.client import HTTPConnection, HTTPSConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace

import pytest
from nginx import AUTHORIZATION, HOST, TRUSTING, Proxy, free_port, require_proxy
from serving import Server
from test_faults import once_drawn
from waiting import wait_until
from websockets.exceptions import InvalidStatus


class Replica(BaseHTTPRequestHandler):
    """Answers, but closes the connection on whoever asks for /closed."""

    def do_GET(self) -> None:
        if self.path != "/closed":
            self.send_response(200)
            self.send_header("Content-Length", "0")
            self.end_headers()

    do_HEAD = do_GET

    def log_message(self, *_) -> None:
        pass


class Replicas(contextlib.ExitStack):
    """Of the proxy's, where it alone is tried. asked: sends requests on one connection → their status."""

    def __init__(self, folder: Path, count: int):
        super().__init__()
        self._servers = [self.enter_context(ThreadingHTTPServer(("127.0.0.1", 0), Replica)) for _ in range(count)]
        for server in self._servers:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            self.callback(server.shutdown)
        places = [SimpleNamespace(url=f"http://127.0.0.1:{server.server_address[1]}") for server in self._servers]
        self.proxy = Proxy(folder, free_port(), places)
        self.callback(self.proxy.stop)

    def asked(self, method: str, path: str, times: int = 1, login: str = AUTHORIZATION) -> list[int]:
        connection = HTTPSConnection("127.0.0.1", self.proxy.port, context=TRUSTING, timeout=20)
        found = []
        for _ in range(times):
            connection.request(method, path, headers={"Authorization": login})
            with connection.getresponse() as answer:
                answer.read()
                found.append(answer.status)
        connection.close()
        return found


@pytest.fixture
def deployed(tmp_path):
    require_proxy()
    replicas: list[Server] = []
    port = free_port()
    origin = f"https://127.0.0.1:{port}"
    for _ in range(2):
        replicas.append(Server("--origin", origin))
    proxy = Proxy(tmp_path, port, replicas)
    yield proxy, replicas
    proxy.stop()
    for replica in replicas:
        replica.process.kill()


@pytest.mark.parametrize("students", [4, pytest.param(30, marks=pytest.mark.slow)])
def test_students_of_a_replica_that_is_killed_go_on_at_the_other(deployed, students):
    proxy, replicas = deployed
    wait_until(lambda: proxy.answers)
    with pytest.raises(InvalidStatus) as refused:
        proxy.open(login=None)
    assert refused.value.response.status_code == 401
    clients = [proxy.open().ready(60) for _ in range(students)]
    assert sum(replica.seated for replica in replicas) == len(clients)
    angles = [20.0 + 2 * k % 60 for k in range(len(clients))]
    for client, angle in zip(clients, angles):
        client.put("θ₂", angle)
        client.put("Speed", "10 a second")
        time.sleep(0.05)
        client.press("Play or pause")
    wait_until(lambda: all((client.value("History") or 0) >= 3 for client in clients), 60)
    for client in clients:
        client.press("Play or pause")
    wait_until(lambda: not any("Moving" in client.status for client in clients))
    motions, tabs = [once_drawn(client)["History"] for client in clients], [client.keep() for client in clients]
    first, second = sorted(replicas, key=lambda replica: -replica.seated)
    moved = first.seated
    first.process.kill()
    wait_until(lambda: sum(client.closed(0) is not None for client in clients) == moved)
    for k, client in enumerate(clients):
        if client.closed(0) is not None:
            again = proxy.open(tabs[k]).ready(60)
            wait_until(lambda again=again, k=k: again.value("History") == motions[k])
            assert again.value("θ₂") == angles[k]
        else:
            assert client.value("History") == motions[k]
    assert second.seated == len(clients)


def test_no_replica_is_taken_out_by_requests_on_which_it_closes(tmp_path):
    require_proxy()
    with Replicas(tmp_path, 2) as replicas:
        wait_until(lambda: replicas.proxy.answers)
        for _ in range(4):
            assert replicas.asked("HEAD", "/closed") == [502]
            assert replicas.asked("GET", "/") == [200]


def test_the_proxy_takes_no_other_methods_and_no_flood_but_a_class_at_once(tmp_path):
    require_proxy()
    with Replicas(tmp_path, 1) as replicas:
        wait_until(lambda: replicas.proxy.answers)
        for method in ("POST", "OPTIONS", "DELETE"):
            assert replicas.asked(method, "/") == [405]
        assert set(replicas.asked("GET", "/", 600)) == {200}
        assert 429 in replicas.asked("GET", "/", 3000, login="")  # which nginx answers alone: faster than 100 a second


def redirected(port: int) -> str:
    """Where a request over plain HTTP is sent that names a host of its own."""
    connection = HTTPConnection("127.0.0.1", port, timeout=20)
    connection.request("GET", "/a?b", headers={"Host": "evil.example"})
    with connection.getresponse() as answer:
        assert answer.status == 301
        return answer.headers["Location"]


def test_the_proxy_redirects_to_its_own_host_alone_and_browsers_keep_to_https(tmp_path):
    require_proxy()
    with Replicas(tmp_path, 1) as replicas:
        wait_until(lambda: replicas.proxy.answers)
        assert redirected(replicas.proxy.plain_port) == f"https://{HOST}/a?b"
        for login, status in ((AUTHORIZATION, 200), ("", 401)):
            connection = HTTPSConnection("127.0.0.1", replicas.proxy.port, context=TRUSTING, timeout=20)
            connection.request("GET", "/", headers={"Authorization": login})
            with connection.getresponse() as answer:
                assert answer.status == status
                assert answer.headers["Strict-Transport-Security"] == "max-age=31536000"
                assert answer.headers["Server"] == "nginx"  # without a version
