"""A class for a while, with what goes wrong: `PYTHONPATH=tests python tests/server/soak.py --clients 30`.

Two replicas of two workers each share a store: a Redis where there is a redis-server, else a folder. Clients come,
play, leave and come back; in the course of it a worker is killed, the Redis is restarted, and a replica is stopped. Who
comes back has to find all that was done, but for the last 5 s before a kill and the last one before a restart. In the
end every session is held against a computation of the same motions by the library alone, to the last bit. Exit status 1
if one was lost or wrong.
"""

import argparse
import contextlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import msgspec
from protocol import Client
from serving import Server, browser_of, workers_of
from viewimit.app.sessions.saved import SavedSession, decoded
from viewimit.app.sessions.stores import open_store
from waiting import wait_until

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

OPTIONS = ("--servo", "gradient-retuned", "--transfer", "epipolar", "--frames", "1", "--workers", "2")
STARTS = (-50.0, -40.0, -30.0, -20.0, -10.0)  # degrees of θ₄, one a client in turn
SPEED = 10.0  # motions a second
KILLED_S, RESTARTED_S = 5.0, 1.0  # of work that may be lost: of a process that is killed, in a restart of the Redis
STAYS_S, AWAY_S = (20.0, 60.0), (1.0, 4.0)
TRIES_S = 60.0  # in which a client that was cut off is to have its page again
NOTICED_S = 1.0  # after which a client knows that it is cut off, and what it shows does not stand any more
SHOWN_S = 15.0  # in which a page that has come shows how many motions it has
WRITTEN_S = 10.0  # until all that was done is in the store


def _within(seconds: float, holds: Callable[[], bool], end: threading.Event) -> bool:
    until = time.monotonic() + seconds
    while not (there := holds()) and time.monotonic() < until and not end.is_set():
        end.wait(0.2)
    return there


class Redis:
    """One of one's own that keeps what it has over a restart."""

    def __init__(self, folder: str):
        self.url, self._socket = f"unix://{folder}/redis.sock", Path(folder, "redis.sock")
        self._command = ["redis-server", "--port", "0", "--unixsocket", str(self._socket), "--dir", folder]
        self._command += ["--save", "", "--appendonly", "yes", "--appendfsync", "everysec"]
        self._start()

    def _start(self) -> None:
        self._process = subprocess.Popen(self._command, stdout=subprocess.DEVNULL)
        wait_until(self._socket.exists, 20)

    def restart(self) -> None:
        self.stop()
        self._start()

    def stop(self) -> None:
        self._process.terminate()
        self._process.wait(20)


class Faults:
    """What was done to the servers, and what that may cost."""

    def __init__(self):
        self._costs: list[tuple[float, float]] = []

    def happen(self, cost_s: float, what: Callable[[], object]) -> None:
        what()
        self._costs.append((time.monotonic(), cost_s))

    def cost_since(self, when: float) -> float:
        """s of work that may be lost of a page that was last looked at then."""
        return max((cost_s for at, cost_s in self._costs if at >= when - NOTICED_S), default=0.0)


class Student(threading.Thread):
    """Comes, plays, leaves and comes back until the end. counts: what it met with."""

    def __init__(self, number: int, urls: list[str], end: threading.Event, faults: Faults):
        super().__init__(daemon=True)
        self._faults = faults
        self.start_deg, self._urls, self._end = STARTS[number % len(STARTS)], urls, end
        self._url, self._random, self._seen, self._seen_at = urls[number % len(urls)], random.Random(number), 0, 0.0
        self.token, self.counts, self.began = browser_of(self._url).split("=")[1], Counter(), False

    def run(self) -> None:
        while not self._end.is_set():
            client = self._come()
            if client is None:
                continue
            with client, contextlib.suppress(KeyError, RuntimeError):
                self._stay(client)
            self._end.wait(self._random.uniform(*AWAY_S))

    @property
    def _cookie(self) -> str:
        """As behind a proxy, where both replicas are the same host to a browser; here each has its port in the name."""
        return f"viewimit-{self._url.rsplit(':', 1)[1]}={self.token}"

    def _come(self) -> Client | None:
        """A page; the other replica's if its own is gone."""
        until = time.monotonic() + TRIES_S
        while not self._end.is_set() and time.monotonic() < until:
            try:
                client = Client(self._url, cookie=self._cookie)
                try:
                    client.ready(20)
                    self.counts["came"] += 1
                    return client
                except AssertionError:
                    client.close()
            except Exception:
                self._url = self._random.choice(self._urls)
            self.counts["tries in vain"] += 1
            self._end.wait(1.0)
        self.counts["no page"] += not self._end.is_set()
        return None

    def _stay(self, client: Client) -> None:
        if not self.began:
            client.put("Start θ₄", self.start_deg)
            self._end.wait(1.0)
            self.began = True
        else:
            due = self._seen - self._faults.cost_since(self._seen_at) * SPEED
            shown = lambda: self._motions(client) >= due
            lost = not _within(SHOWN_S, shown, self._end)
            if lost and not self._end.is_set():
                self.counts["sessions lost"] += 1
                print(f"{self._motions(client)} motions where {self._seen} were seen, {due:g} due", file=sys.stderr)
        client.put("Speed", "10 a second")
        self._end.wait(0.2)
        client.press("Play or pause")
        until = time.monotonic() + self._random.uniform(*STAYS_S)
        while time.monotonic() < until and not self._end.is_set():
            if client.closed(0.5) is not None:
                self.counts["cut off"] += 1
                return
            self._look(client)
            client.received.clear()
        client.press("Play or pause")
        time.sleep(0.5)
        self._look(client)

    def _look(self, client: Client) -> None:
        self._seen_at, self._seen = time.monotonic(), self._motions(client)

    @staticmethod
    def _motions(client: Client) -> int:
        return int(client.value("History") or 0)


def kept(url: str, token: str) -> SavedSession | None:
    """What the store has of a browser's tab with most motions."""
    store, found = open_store(url), []
    for place in range(8):
        parts = store.read(f"{token}.{place}")
        begun = parts and msgspec.convert(msgspec.msgpack.decode(parts["head"])["begun"], Settings)
        session = decoded(parts, begun) if parts else None
        found += [session] if session is not None else []
    store.close()
    return max(found, key=lambda session: session.head.cursor, default=None)


def same_as_computed(sessions: list[SavedSession]) -> list[bool]:
    """Of sessions of one start: whether posture, images and E are those that the library comes to by itself."""
    session, wanted = Session(sessions[0].history[0].settings), {saved.head.cursor for saved in sessions}
    at = {0: session.snapshot}
    while session.cursor < max(wanted) and session.step():
        at[session.cursor] = session.snapshot if session.cursor in wanted else None
    return [_same(saved.history[saved.head.cursor], at.get(saved.head.cursor)) for saved in sessions]


def _same(one, other) -> bool:
    if other is None:
        return False
    arrays = [(one.theta, other.theta), (one.views.own, other.views.own), (one.views.demo, other.views.demo)]
    return one.E == other.E and all(a.tobytes() == b.tobytes() for a, b in arrays)


def soak(minutes: float, count: int, folder: str) -> list[tuple[str, object]]:
    """The table's rows; the last three are what may not be."""
    redis = Redis(folder) if shutil.which("redis-server") else None
    store = folder if redis is None else redis.url
    options = (*OPTIONS, "--max-clients", str(2 * count), "--store", store)
    servers, end = [Server(*options), Server(*options)], threading.Event()
    faults, urls = Faults(), [server.url for server in servers]
    students = [Student(k, urls, end, faults) for k in range(count)]
    began, cpu, memory = time.monotonic(), 0.0, []
    for student in students:
        student.start()
        time.sleep(0.2)
    until = lambda share: time.sleep(max(began + 60 * minutes * share - time.monotonic(), 0.0))
    until(0.25)
    faults.happen(KILLED_S, lambda: os.kill(workers_of(servers[0])[0], signal.SIGKILL))
    memory.append(servers[0].memory)
    until(0.5)
    if redis is not None:
        faults.happen(RESTARTED_S, redis.restart)
    until(0.75)
    memory.append(servers[0].memory)
    cpu += servers[1].cpu_s
    status = servers[1].stop()
    until(1.0)
    memory.append(servers[0].memory)
    end.set()
    for student in students:
        student.join(30)
    time.sleep(WRITTEN_S)
    cpu += servers[0].cpu_s
    seconds = time.monotonic() - began
    found = {student: kept(store, student.token) for student in students}
    status |= servers[0].stop()
    lines = sum(len(server.lines) for server in servers)
    if redis is not None:
        redis.stop()
    missing = sum(session is None for session in found.values())
    wrong, motions = 0, 0
    alike: dict[Settings, list[SavedSession]] = {}
    for session in filter(None, found.values()):
        alike.setdefault(session.history[0].settings, []).append(session)
    for sessions in alike.values():
        wrong += same_as_computed(sessions).count(False)
        motions += sum(session.head.cursor for session in sessions)
    met = sum((student.counts for student in students), Counter())
    return [
        ("minutes", round(seconds / 60, 1)),
        ("clients", count),
        ("store", "SQLite" if redis is None else "Redis"),
        ("pages that were opened", met["came"]),
        ("pages cut off", met["cut off"]),
        ("tries in vain", met["tries in vain"]),
        ("clients without a page for a minute", met["no page"]),
        ("motions kept", motions),
        ("cores", round(cpu / seconds, 2)),
        ("memory of the replica that stays, MB", " ".join(f"{one:.0f}" for one in memory)),
        ("lines of log", lines),
        ("exit status of the servers", status),
        ("sessions that were not found in the end", missing),
        ("sessions lost", met["sessions lost"]),
        ("answers wrong", wrong),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--clients", type=int, default=30)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="viewimit-soak-") as folder:
        rows = soak(args.minutes, args.clients, folder)
    for name, value in rows:
        print(f"{name:40}{value}")
    sys.exit(any(value for _, value in rows[-3:]))


if __name__ == "__main__":
    main()
