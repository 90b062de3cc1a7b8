"""A real nginx in front of servers: below a path, or with the configuration that is shipped."""

import base64
import getpass
import re
import shutil
import socket
import ssl
import subprocess
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from protocol import Client, Tab
from waiting import wait_until

PROGRAM = shutil.which("nginx") or shutil.which("nginx", path="/usr/sbin:/usr/local/sbin:/opt/homebrew/bin")
DEPLOY = Path(__file__).parents[1] / "deploy"
HOST = "class.example.org"
LOGIN = "student:chalk"
AUTHORIZATION = f"Basic {base64.b64encode(LOGIN.encode()).decode()}"
TRUSTING = ssl.create_default_context()
TRUSTING.check_hostname, TRUSTING.verify_mode = False, ssl.CERT_NONE  # the certificate is made by the test
# In 1.3 a server sends tickets after the handshake, and a client that reads them in one thread while it writes in
# another, as `Client` does, loses what it wrote, once in 500 times.
TRUSTING.maximum_version = ssl.TLSVersion.TLSv1_2
CONFIGURATION = """daemon off; pid {folder}/pid; error_log stderr; worker_processes 1;
events {{}}
http {{
  access_log off; client_body_temp_path {folder}/body; proxy_temp_path {folder}/proxy;
  fastcgi_temp_path {folder}/fastcgi; uwsgi_temp_path {folder}/uwsgi; scgi_temp_path {folder}/scgi;
  map $http_upgrade $connection_upgrade {{ default upgrade; '' close; }}
  server {{
    listen 127.0.0.1:{port};
    location /x/ {{
      proxy_pass {behind}/;
      proxy_http_version 1.1; proxy_set_header Host $http_host;
      proxy_set_header Upgrade $http_upgrade; proxy_set_header Connection $connection_upgrade;
    }}
  }}
}}
"""


@contextmanager
def below_a_path(behind: str, folder: Path) -> Iterator[str]:
    """Address of a server as nginx gives it, below /x/."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = one.getsockname()[1]
    (folder / "nginx.conf").write_text(CONFIGURATION.format(folder=folder, port=port, behind=behind))
    process = subprocess.Popen(
        [PROGRAM, "-p", str(folder), "-c", str(folder / "nginx.conf")], stderr=subprocess.DEVNULL
    )

    def answers():
        assert process.poll() is None
        with socket.socket() as one:
            return one.connect_ex(("127.0.0.1", port)) == 0

    try:
        wait_until(answers)
        yield f"http://127.0.0.1:{port}/x/"
    finally:
        process.terminate()
        process.wait(30)


def require_proxy() -> None:
    if PROGRAM is None or shutil.which("openssl") is None:
        pytest.skip("no nginx or openssl")


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def run(*command) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def certify(folder: Path) -> None:
    run("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=localhost",
        "-keyout", folder / "key.pem", "-out", folder / "certificate.pem")  # fmt: skip


class Proxy:
    """nginx with the configuration that is shipped: other ports, and servers of this machine. behind: the class's."""

    def __init__(self, folder: Path, port: int, replicas: Sequence[Any], behind: str = "http://127.0.0.1:1"):
        self.port = port
        shipped = (DEPLOY / "nginx.conf").read_text()
        self.plain_port = free_port()
        text = shipped.replace("listen 80;", f"listen 127.0.0.1:{self.plain_port};")
        text = text.replace("listen 443 ssl;", f"listen 127.0.0.1:{self.port} ssl;")
        assert text.count("127.0.0.1") == 2
        line = re.search(r" *server viewimit:8080.*\n", text)[0]
        places = [replica.url.removeprefix("http://") for replica in replicas] or ["127.0.0.1:1"]
        text = text.replace(line, "".join(line.replace("viewimit:8080", place) for place in places))
        text = text.replace("http://class:8080", behind)
        (folder / "nginx.conf").write_text(text)
        (folder / "host.conf").write_text((DEPLOY / "host.conf").read_text().replace("localhost", HOST))
        certify(folder)
        user, password = LOGIN.split(":")
        (folder / "users").write_text(f"{user}:{run('openssl', 'passwd', '-apr1', password)}")
        command = [PROGRAM, "-p", folder, "-c", folder / "nginx.conf", "-e", folder / "error.log"]
        settings = f"daemon off; pid {folder}/nginx.pid; user {getpass.getuser()};"  # who may read the folder
        self.process = subprocess.Popen([*command, "-g", settings], stderr=subprocess.DEVNULL)
        self.url = f"https://127.0.0.1:{self.port}"

    def stop(self) -> None:
        self.process.terminate()
        self.process.wait(10)

    def open(self, tab: Tab | None = None, login: str | None = LOGIN) -> Client:
        return Client(self.url, origin=self.url, tab=tab, login=login, ssl=TRUSTING)

    @property
    def answers(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0
