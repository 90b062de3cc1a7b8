"""Past one machine: two replicas behind the proxy of deploy/nginx.conf, one of which is killed under its class."""

import base64
import contextlib
import fnmatch
import getpass
import os
import re
import shutil
import socket
import ssl
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from http.client import HTTPConnection, HTTPSConnection
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from protocol import Client, Tab
from serving import Server
from test_faults import once_drawn
from waiting import wait_until
from websockets.exceptions import InvalidStatus

DEPLOY = Path(__file__).parents[2] / "deploy"
HOST = "class.example.org"
LOGIN = "student:chalk"
AUTHORIZATION = f"Basic {base64.b64encode(LOGIN.encode()).decode()}"
TRUSTING = ssl.create_default_context()
TRUSTING.check_hostname, TRUSTING.verify_mode = False, ssl.CERT_NONE  # the certificate is made by the test
# In 1.3 a server sends tickets after the handshake, and a client that reads them in one thread while it writes in
# another, as `Client` does, loses what it wrote, once in 500 times.
TRUSTING.maximum_version = ssl.TLSVersion.TLSv1_2


def found(program: str) -> str | None:
    return shutil.which(program, path=f"{os.environ['PATH']}:/usr/sbin:/usr/local/sbin")


def require(*programs: str) -> None:
    for program in programs:
        if not found(program):
            pytest.skip(f"no {program}")


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def run(*command) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def certify(folder: Path) -> None:
    run("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost",
        "-keyout", folder / "key.pem", "-out", folder / "certificate.pem")  # fmt: skip


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

    def asked(self, method: str, path: str, times: int = 1) -> list[int]:
        connection = HTTPSConnection("127.0.0.1", self.proxy.port, context=TRUSTING, timeout=20)
        found = []
        for _ in range(times):
            connection.request(method, path, headers={"Authorization": AUTHORIZATION})
            with connection.getresponse() as answer:
                answer.read()
                found.append(answer.status)
        connection.close()
        return found


class Proxy:
    """nginx with the configuration that is shipped: other ports, and replicas of this machine."""

    def __init__(self, folder: Path, port: int, replicas: list[Server]):
        program = found("nginx")
        self.port = port
        shipped = (DEPLOY / "nginx.conf").read_text()
        self.plain_port = free_port()
        text = shipped.replace("listen 80;", f"listen 127.0.0.1:{self.plain_port};")
        text = text.replace("listen 443 ssl;", f"listen 127.0.0.1:{self.port} ssl;")
        assert text.count("127.0.0.1") == 2
        (folder / "nginx.conf").write_text(text)
        (folder / "host.conf").write_text((DEPLOY / "host.conf").read_text().replace("localhost", HOST))
        line = (DEPLOY / "replicas.conf").read_text()
        (folder / "replicas.conf").write_text(
            "\n".join(line.replace("viewimit:8080", r.url.removeprefix("http://")) for r in replicas)
        )
        certify(folder)
        user, password = LOGIN.split(":")
        (folder / "users").write_text(f"{user}:{run('openssl', 'passwd', '-apr1', password)}")
        command = [program, "-p", folder, "-c", folder / "nginx.conf", "-e", folder / "error.log"]
        settings = f"daemon off; pid {folder}/nginx.pid; user {getpass.getuser()};"  # who may read the folder
        self.process = subprocess.Popen([*command, "-g", settings], stderr=subprocess.DEVNULL)
        self.url = f"https://127.0.0.1:{self.port}"

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait(10)

    def open(self, tab: Tab | None = None, login: str | None = LOGIN) -> Client:
        return Client(self.url, origin=self.url, tab=tab, login=login, ssl=TRUSTING)


@pytest.fixture
def deployed(tmp_path):
    require("nginx", "openssl")
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
    wait_until(lambda: _answers(proxy))
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
    require("nginx", "openssl")
    with Replicas(tmp_path, 2) as replicas:
        wait_until(lambda: _answers(replicas.proxy))
        for _ in range(4):
            assert replicas.asked("HEAD", "/closed") == [502]
            assert replicas.asked("GET", "/") == [200]


def test_the_proxy_takes_no_other_methods_and_no_flood_but_a_class_at_once(tmp_path):
    require("nginx", "openssl")
    with Replicas(tmp_path, 1) as replicas:
        wait_until(lambda: _answers(replicas.proxy))
        for method in ("POST", "OPTIONS", "DELETE"):
            assert replicas.asked(method, "/") == [405]
        assert set(replicas.asked("GET", "/", 120)) == {200}
        assert 429 in replicas.asked("GET", "/", 1000)


def redirected(port: int) -> str:
    """Where a request over plain HTTP is sent that names a host of its own."""
    connection = HTTPConnection("127.0.0.1", port, timeout=20)
    connection.request("GET", "/a?b", headers={"Host": "evil.example"})
    with connection.getresponse() as answer:
        assert answer.status == 301
        return answer.headers["Location"]


def test_the_proxy_redirects_to_its_own_host_alone_and_browsers_keep_to_https(tmp_path):
    require("nginx", "openssl")
    with Replicas(tmp_path, 1) as replicas:
        wait_until(lambda: _answers(replicas.proxy))
        assert redirected(replicas.proxy.plain_port) == f"https://{HOST}/a?b"
        for login, status in ((AUTHORIZATION, 200), ("", 401)):
            connection = HTTPSConnection("127.0.0.1", replicas.proxy.port, context=TRUSTING, timeout=20)
            connection.request("GET", "/", headers={"Authorization": login})
            with connection.getresponse() as answer:
                assert answer.status == status
                assert answer.headers["Strict-Transport-Security"] == "max-age=31536000"
                assert answer.headers["Server"] == "nginx"  # without a version


SERVICES = yaml.safe_load((DEPLOY.parent / "compose.yaml").read_text())["services"]


@pytest.mark.parametrize("service", SERVICES)
def test_a_container_has_the_least_that_it_needs(service):
    said = SERVICES[service]
    assert said["read_only"] and said["cap_drop"] == ["ALL"] and said["security_opt"] == ["no-new-privileges:true"]
    assert said["mem_limit"] and said["pids_limit"] > 0
    assert set(said.get("cap_add", ())) <= {"NET_BIND_SERVICE", "CHOWN", "SETGID", "SETUID", "DAC_OVERRIDE"}
    assert ("ports" in said) is ("outside" in said["networks"]) is (service == "proxy")


def test_git_and_docker_ignore_the_files_with_keys_and_users():
    mounted = [volume.split(":")[0] for volume in SERVICES["proxy"]["volumes"]]
    secret = [path.removeprefix("./") for path in mounted if not Path(DEPLOY.parent, path).exists() or "key" in path]
    assert {"deploy/certificate.pem", "deploy/key.pem", "deploy/users"} <= {*secret, "deploy/users"}
    for file in (".gitignore", ".dockerignore"):
        patterns = [line.lstrip("/") for line in (DEPLOY.parent / file).read_text().split()]
        for path in (*secret, "deploy/users.cfg", ".env"):
            assert any(fnmatch.fnmatch(path, pattern) for pattern in patterns), f"{file}: {path}"


def test_the_service_of_systemd_is_valid_and_begins_the_server_with_options_that_it_has(tmp_path, ask):
    text = (DEPLOY / "viewimit.service").read_text()
    program, *words = re.search("^ExecStart=(.*)$", text, re.MULTILINE)[1].split()
    _, said, _ = ask("serve", "--help")
    assert program == "/opt/viewimit/bin/viewimit" and words[0] == "serve"
    assert {word for word in words if word.startswith("--")} <= set(re.findall(r"--[\w-]+", said))
    if not found("systemd-analyze"):
        pytest.skip("no systemd-analyze")
    (tmp_path / "viewimit.service").write_text(text.replace(program, sys.executable))
    done = subprocess.run(["systemd-analyze", "verify", tmp_path / "viewimit.service"], capture_output=True, text=True)
    assert done.returncode == 0 and "viewimit.service" not in done.stderr, done.stderr


class Balancer:
    """HAProxy with the configuration that is shipped: other ports, and one replica of this machine."""

    def __init__(self, folder: Path, port: int, replica: Server):
        certify(folder)
        (folder / "certificate.pem").write_text(
            (folder / "certificate.pem").read_text() + (folder / "key.pem").read_text()
        )
        user, password = LOGIN.split(":")
        (folder / "users.cfg").write_text(f"userlist people\n  user {user} insecure-password {password}\n")
        self.plain_port = free_port()
        text = (DEPLOY / "haproxy.cfg").read_text().replace("bind :80\n", f"bind 127.0.0.1:{self.plain_port}\n")
        text = text.replace("bind :443 ", f"bind 127.0.0.1:{port} ")
        text = text.replace("server-template replica 8 viewimit:8080", f"server one {replica.url[7:]}")
        text = text.replace(" init-addr none resolvers docker", "").replace("inter 2s", "inter 200ms")
        text = text.replace("global\n", "global\n  stats socket unix@state.sock\n")
        (folder / "haproxy.cfg").write_text(text)
        self.port, self.url, self._state = port, f"https://127.0.0.1:{port}", folder / "state.sock"
        command = [found("haproxy"), "-db", "-f", "haproxy.cfg", "-f", "users.cfg"]
        self.process = subprocess.Popen(command, cwd=folder, env=os.environ | {"VIEWIMIT_HOST": HOST})

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait(10)

    @property
    def checked(self) -> dict[str, str]:
        """What the health check has found of the replica."""
        with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX) as asked:
            asked.connect(str(self._state))
            asked.sendall(b"show stat\n")
            head, *rows = asked.makefile().read().strip("# \n").split("\n")
            stats = [dict(zip(head.split(","), row.split(","))) for row in rows]
            return next(row for row in stats if row["svname"] == "one")
        return {}


def test_haproxy_finds_a_replica_well_by_its_own_check_and_brings_a_class_to_it(tmp_path):
    require("haproxy", "openssl")
    port = free_port()
    url = f"https://127.0.0.1:{port}"
    replica = Server("--origin", url)
    balancer = Balancer(tmp_path, port, replica)
    wait_until(lambda: balancer.checked.get("check_status") == "L7OK")
    assert balancer.checked["check_code"] == "200" and balancer.checked["status"] == "UP"
    with Client(url, origin=url, login=LOGIN, ssl=TRUSTING) as student:
        student.ready()
    with pytest.raises(urllib.error.HTTPError, match="405"):
        urllib.request.urlopen(urllib.request.Request(url, b"", {"Authorization": AUTHORIZATION}), context=TRUSTING)
    with pytest.raises(InvalidStatus, match="401"):
        Client(url, origin=url, ssl=TRUSTING)
    assert redirected(balancer.plain_port) == f"https://{HOST}/a?b"
    with pytest.raises(urllib.error.HTTPError, match="401") as refused:
        urllib.request.urlopen(url, context=TRUSTING)
    assert refused.value.headers["Strict-Transport-Security"] == "max-age=31536000"
    assert replica.stop() == 0
    wait_until(lambda: balancer.checked["status"] == "DOWN")
    balancer.stop()


def _answers(proxy: Proxy) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", proxy.port)) == 0
