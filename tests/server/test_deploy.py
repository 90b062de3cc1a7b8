"""Past one machine: two replicas behind the proxy of deploy/nginx.conf, one of which is killed under its class."""

import base64
import getpass
import shutil
import socket
import ssl
import subprocess
import time
import urllib.request
from pathlib import Path

import pytest
from protocol import Client
from serving import Server, kept_of
from waiting import wait_until
from websockets.exceptions import InvalidStatus

DEPLOY = Path(__file__).parents[2] / "deploy"
LOGIN = "student:chalk"
TRUSTING = ssl.create_default_context()
TRUSTING.check_hostname, TRUSTING.verify_mode = False, ssl.CERT_NONE  # the certificate is made by the test


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Proxy:
    """nginx with the configuration that is shipped: other ports, and replicas of this machine."""

    def __init__(self, folder: Path, port: int, replicas: list[Server]):
        program = shutil.which("nginx", path="/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin")
        self.port = port
        shipped = (DEPLOY / "nginx.conf").read_text()
        text = shipped.replace("listen 80;", f"listen 127.0.0.1:{free_port()};")
        text = text.replace("listen 443 ssl;", f"listen 127.0.0.1:{self.port} ssl;")
        assert text.count("127.0.0.1") == 2
        (folder / "nginx.conf").write_text(text)
        lines = [f"server {r.url.removeprefix('http://')} max_fails=1 fail_timeout=5s;" for r in replicas]
        (folder / "replicas.conf").write_text("\n".join(lines))
        self._run("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost",
                  "-keyout", folder / "key.pem", "-out", folder / "certificate.pem")  # fmt: skip
        user, password = LOGIN.split(":")
        (folder / "users").write_text(f"{user}:{self._run('openssl', 'passwd', '-apr1', password)}")
        command = [program, "-p", folder, "-c", folder / "nginx.conf", "-e", folder / "error.log"]
        settings = f"daemon off; pid {folder}/nginx.pid; user {getpass.getuser()};"  # who may read the folder
        self.process = subprocess.Popen([*command, "-g", settings], stderr=subprocess.DEVNULL)
        self.url = f"https://127.0.0.1:{self.port}"

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait(10)

    @staticmethod
    def _run(*command) -> str:
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    def browser(self) -> str:
        """The cookie of a browser that opens the page."""
        request = urllib.request.Request(self.url)
        request.add_header("Authorization", f"Basic {base64.b64encode(LOGIN.encode()).decode()}")
        with urllib.request.urlopen(request, context=TRUSTING) as page:
            assert "Secure" in page.headers["Set-Cookie"]
            return page.headers["Set-Cookie"].split(";")[0]

    def open(self, cookie: str | None = None, login: str | None = LOGIN) -> Client:
        return Client(self.url, origin=self.url, cookie=cookie, login=login, ssl=TRUSTING)


@pytest.fixture
def deployed(tmp_path, redis_url):
    for program in ("nginx", "openssl"):
        if not shutil.which(program, path="/usr/sbin:/usr/local/sbin:/usr/bin:/usr/local/bin"):
            pytest.skip(f"no {program}")
    replicas: list[Server] = []
    port = free_port()
    origin = f"https://127.0.0.1:{port}"
    for _ in range(2):
        replicas.append(Server("--store", redis_url, "--origin", origin))
    proxy = Proxy(tmp_path, port, replicas)
    yield proxy, replicas
    proxy.stop()
    for replica in replicas:
        replica.process.kill()


@pytest.mark.parametrize("students", [4, pytest.param(30, marks=pytest.mark.slow)])
def test_students_of_a_replica_that_is_killed_go_on_at_the_other(deployed, redis_url, students):
    proxy, (first, second) = deployed
    wait_until(lambda: _answers(proxy))
    with pytest.raises(InvalidStatus) as refused:
        proxy.open(login=None)
    assert refused.value.response.status_code == 401
    cookies, clients = [], []
    while len(clients) < students or not (first.seated and second.seated):
        cookies.append(proxy.browser())
        clients.append(proxy.open(cookies[-1]).ready(60))
        assert len(clients) < 3 * students, "all went to one replica"
    assert first.seated + second.seated == len(clients)
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
    shown = lambda: [client.value("History") for client in clients]
    kept = lambda: [kept_of(redis_url, cookie) for cookie in cookies]
    wait_until(lambda: [page and page.cursor for page in kept()] == shown())
    motions = shown()
    moved = first.seated
    first.process.kill()
    wait_until(lambda: sum(client.closed(0) is not None for client in clients) == moved)
    for k, client in enumerate(clients):
        if client.closed(0) is not None:
            again = proxy.open(cookies[k]).ready(60)
            wait_until(lambda again=again, k=k: again.value("History") == motions[k])
            assert again.value("θ₂") == angles[k]
        else:
            assert client.value("History") == motions[k]
    assert second.seated == len(clients)


def _answers(proxy: Proxy) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", proxy.port)) == 0
