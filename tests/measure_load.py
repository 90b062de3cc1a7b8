"""What a class costs: `python tests/measure_load.py --clients 30 --seconds 60`.

Clients that speak viser's protocol, from processes of their own, each with a session whose loop runs; as a browser
does, each says which tabs are not open. Of each: updates of poses, of the images and of the landscape that arrive, a
second. One more client moves its demonstrator by a slider and waits until the scene shows it. Of the server with all
its processes: processor time and memory.
"""

import argparse
import itertools
import json
import multiprocessing
import statistics
import sys
import time
from collections.abc import Iterator

import numpy as np
from drawn import IMAGE_PLANE, LEARNERS_PATH
from protocol import Client
from serving import Server

WARM_UP_S = 15.0
CLOSED = "Curves,Equations,Duel,Experiments,Follow"  # as a page begins; "none" draws all
PERIOD_S = 1.0  # of the slider
TARGETS = {"poses": 20.0, "panels": 10.0, "plots": 5.0}
MARKS = {"poses": b"SetOrientationMessage", "panels": IMAGE_PLANE.encode(), "plots": LEARNERS_PATH.encode()}
OPTIONS = ("--servo", "gradient-retuned", "--transfer", "epipolar", "--frames", "1", "--start", "25,-45")


class Counting(Client):
    """counts: frames with each kind of update. Once it is ready it only looks for them, and costs next to nothing."""

    def __init__(self, url: str, closed: str):
        self.counts = dict.fromkeys(TARGETS, 0)
        self.posed_at: list[float] = []  # s, when frames with poses arrived
        self._counting = False
        super().__init__(url)
        self.ready(120)
        self.act("unseen", closed)
        self._counting = True

    def _unpack(self, frame: bytes) -> list[dict]:
        if not self._counting:
            return super()._unpack(frame)
        inner = self._inner(frame)
        for kind, mark in MARKS.items():
            self.counts[kind] += mark in inner
        if MARKS["poses"] in inner:
            self.posed_at.append(time.monotonic())
        return []


def run_clients(url: str, count: int, speed: str, closed: str, begin, end, results) -> None:
    """Some clients in one process, each with a running loop; their updates between the two events."""
    clients = [Counting(url, closed) for _ in range(count)]
    for client in clients:
        client.put("Speed", speed)
        time.sleep(0.03)
        client.press("Play or pause")
    begin.wait()
    before, since = [dict(client.counts) for client in clients], time.monotonic()
    end.wait()
    seconds = time.monotonic() - since
    results.put(
        [
            {kind: (client.counts[kind] - old[kind]) / seconds for kind in TARGETS}
            for client, old in zip(clients, before)
        ]
    )


def slider_delays(client: Counting, until: float, angles: Iterator[float]) -> list[float]:
    """s from sending a slider's value to the arrival of the poses that follow it, PERIOD_S if none did in time."""
    delays = []
    while time.monotonic() < until:
        client.posed_at.clear()
        sent = time.monotonic()
        client.put("θ₂", next(angles))
        time.sleep(PERIOD_S)
        delays += [client.posed_at[0] - sent] if client.posed_at else [PERIOD_S]
    return delays


def measure(clients: int, seconds: float, speed: str, closed: str) -> dict:
    server = Server("--max-clients", str(clients + 1), *OPTIONS)
    context = multiprocessing.get_context("spawn")
    begin, end, results = context.Event(), context.Event(), context.Queue()
    shares = [len(part) for part in np.array_split(np.arange(clients), 2) if len(part)]
    arguments = [(server.url, share, speed, closed, begin, end, results) for share in shares]
    processes = [context.Process(target=run_clients, args=each, daemon=True) for each in arguments]
    for process in processes:
        process.start()
    probe = Counting(server.url, closed)
    time.sleep(WARM_UP_S)
    begin.set()
    cpu, since, memory = server.cpu_s, time.monotonic(), [(0.0, server.memory)]
    delays, angles = [], itertools.cycle((50.0, 45.0))
    while (passed := time.monotonic() - since) < seconds:
        delays += slider_delays(probe, time.monotonic() + min(5.0, seconds - passed), angles)
        memory.append((time.monotonic() - since, server.memory))
    used = (server.cpu_s - cpu) / (time.monotonic() - since)
    end.set()
    rates = [rate for _ in processes for rate in results.get()]
    for process in processes:
        process.join()
    probe.close()
    server.stop()
    return {
        "clients": clients,
        "closed": closed,
        "speed": speed,
        "seconds": round(seconds),
        **{kind: spread([rate[kind] for rate in rates]) for kind in TARGETS},
        "cores": round(used, 3),
        "cpu_ms_a_client_and_s": round(1e3 * used / (clients + 1), 1),
        "slider_to_wire_ms": {
            "median": round(1e3 * statistics.median(delays)),
            "p95": round(1e3 * float(np.quantile(delays, 0.95))),
            "missed": sum(delay >= PERIOD_S for delay in delays),
        },
        "memory_mb": [round(memory[int(share * (len(memory) - 1))][1]) for share in (0, 0.25, 0.5, 0.75, 1)],
    }


def spread(values: list[float]) -> dict[str, float]:
    return {"mean": round(statistics.mean(values), 2), "least": round(min(values), 2)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clients", type=int, default=30)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--speed", default="10 a second", help="of the loops, as the page has it (%(default)s)")
    parser.add_argument("--closed", default=CLOSED, help="tabs of each client that are not open (%(default)s)")
    args = parser.parse_args()
    json.dump(measure(args.clients, args.seconds, args.speed, args.closed), sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
