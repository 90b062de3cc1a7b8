"""Servers of one's own: in a process, as a user starts them, or in this one, so that a test can break them."""

import contextlib
import io
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import urllib.request
from collections.abc import Collection
from contextlib import suppress

import viser
from viewimit.app import viser_private
from viewimit.app.server.access import AccessControl
from viewimit.app.server.limits import Limits, ServerOptions
from viewimit.app.server.pages import App
from viewimit.app.server.scheduler import Scheduler
from waiting import wait_until

from viewimit.loop.session import Session

STARTS_WITHIN_S = 90  # on a busy machine
ENDS_WITHIN_S = 10
PATIENT = Limits()


class Server:
    """A `viewimit serve` on a free port, once it says that it listens, and what it says."""

    def __init__(self, *options: str):
        isolated = [sys.executable, "-I"]  # what is installed, not the folder that happens to be the current one
        command = [*isolated, "-m", "viewimit.commands.cli", "serve", "--port", "0", *options]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.lines: list[str] = []
        self._news, self._ended = threading.Condition(), False
        threading.Thread(target=self._read, daemon=True).start()  # always, so that the pipe never fills
        address = self._hear(r"http://\S+", STARTS_WITHIN_S)
        if address is None:
            self.process.kill()
            raise RuntimeError(f"viewimit serve did not start:\n{self.log}")
        self.url = address.group()

    def _read(self) -> None:
        with self.process.stdout as said:
            for line in said:
                with self._news:
                    self.lines.append(line)
                    self._news.notify_all()
        with self._news:
            self._ended = True
            self._news.notify_all()

    def _hear(self, pattern: str, seconds: float) -> re.Match | None:
        """The first match in its log; None if it ends or the time passes without one."""
        with self._news:
            self._news.wait_for(lambda: re.search(pattern, self.log) or self._ended, seconds)
            return re.search(pattern, self.log)

    @property
    def log(self) -> str:
        return "".join(list(self.lines))

    def lines_about(self, ports: Collection[int], since: int) -> list[str]:
        """What it has said from the since-th line on, but for what is about connections from other ports of this
        machine: who came before may still have a line to come."""
        said = [(line, re.search(r" 127\.0\.0\.1:(\d+): ", line)) for line in list(self.lines)[since:]]
        return [line for line, whose in said if whose is None or int(whose[1]) in ports]

    @property
    def memory(self) -> float:
        """MB that it and the processes that it began have in memory; what they share counts in each."""
        pages = 0
        for pid in processes_of(self.process.pid):
            with suppress(OSError), open(f"/proc/{pid}/statm") as numbers:
                pages += int(numbers.read().split()[1])
        return pages * os.sysconf("SC_PAGE_SIZE") / 2**20

    @property
    def cpu_s(self) -> float:
        """Processor time of it and of the processes that it began, s."""
        ticks = 0
        for pid in processes_of(self.process.pid):
            with suppress(OSError):
                fields = stat_of(pid)
                ticks += int(fields[11]) + int(fields[12])
        return ticks / os.sysconf("SC_CLK_TCK")

    @property
    def seated(self) -> int:
        """Connections that have a seat."""
        with urllib.request.urlopen(self.url + "/health", timeout=5) as health:
            return int(re.search(r'"clients": (\d+)', health.read().decode())[1])

    def stop(self, by: int = signal.SIGTERM) -> int:
        """As a user would. Its exit status."""
        self.process.send_signal(by)
        try:
            return self.process.wait(ENDS_WITHIN_S)
        finally:
            self.process.kill()

    @contextlib.contextmanager
    def says(self, text: str):
        """Inside, it puts exactly one line with this text into its log."""
        before = self.log.count(text)
        yield
        wait_until(lambda: self.log.count(text) == before + 1)


class Attended(Scheduler):
    """A scheduler that tells which pages are there."""

    def __init__(self):
        super().__init__()
        self.present: list = []

    def add(self, page) -> None:
        self.present.append(page)
        super().add(page)

    def remove(self, page) -> None:
        super().remove(page)
        self.present.remove(page)


class Here:
    """The server in this process, so that a test can break it."""

    def __init__(self, limits: Limits = PATIENT):
        self._scheduler = Attended()
        self.access = AccessControl(limits, ())
        with contextlib.redirect_stdout(io.StringIO()), viser_private.serving_with(self.access.serve):
            self.viser = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        self.app = App(self.viser, ServerOptions(), self._scheduler, {})
        self.access.guard(self.viser)
        self.url = f"http://127.0.0.1:{self.viser.get_port()}"

    @property
    def pages(self) -> int:
        """How many visitors have one."""
        return len(self._scheduler.present)

    @property
    def sessions(self) -> list[Session]:
        """Of the visitors, as they came."""
        return [page.model.session for page in self._scheduler.present]

    def stop(self) -> None:
        self.app.stop()
        with contextlib.redirect_stdout(io.StringIO()):
            self.viser.stop()


class Relay:
    """A network between a client and a server that can fall silent without closing anything."""

    def __init__(self, url: str):
        self._to = ("127.0.0.1", int(url.rsplit(":", 1)[1]))
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.url = f"http://127.0.0.1:{self._listener.getsockname()[1]}"
        self.silent, self._sockets = threading.Event(), []
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                near = self._listener.accept()[0]
                try:
                    far = socket.create_connection(self._to)
                except ConnectionRefusedError:  # its server is gone
                    near.close()
                    continue
                self._sockets += [near, far]
                for source, sink in ((near, far), (far, near)):
                    threading.Thread(target=self._pump, args=(source, sink), daemon=True).start()

    def _pump(self, source: socket.socket, sink: socket.socket) -> None:
        with suppress(OSError):
            while not self.silent.is_set() and (data := source.recv(65536)):
                if not self.silent.is_set():
                    sink.sendall(data)

    def lead_to(self, url: str) -> None:
        """Lead new connections to another server."""
        self._to = ("127.0.0.1", int(url.rsplit(":", 1)[1]))

    def cut(self) -> None:
        """Close all connections that are open."""
        for each in self._sockets:
            with suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
            each.close()
        self._sockets = []

    def close(self) -> None:
        for each in [self._listener, *self._sockets]:
            each.close()


def processes_of(pid: int) -> list[int]:
    """A process, and all that it and those have begun."""
    parents = {}
    for name in filter(str.isdigit, os.listdir("/proc")):
        with suppress(OSError):
            parents[int(name)] = int(stat_of(int(name))[1])
    found = [pid]
    for one in found:
        found += [child for child, parent in parents.items() if parent == one]
    return found


def tell_all(pids: list[int], what: int) -> None:
    """A signal to each process of these that has not ended."""
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, what)


def stat_of(pid: int) -> list[str]:
    """What the system counts of a process, from its state on (proc(5))."""
    with open(f"/proc/{pid}/stat") as stat:
        return stat.read().rsplit(")", 1)[1].split()
