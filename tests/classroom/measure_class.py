"""What a class costs: `python tests/classroom/measure_class.py --clients 30 --seconds 60`.

Two servers at the same time, one with a lecturer's page and one without, each with as many clients whose loops run: so
that whatever else the machine does, it does to both. Of each: processor time of the server with all its processes.
"""

import argparse
import http.client
import json
import multiprocessing
import re
import sys
import time
from pathlib import Path

sys.path.append(str(Path(__file__).parent.parent))  # also where processes of its own begin

from measure_load import OPTIONS, WARM_UP_S, Counting, run_clients  # noqa: E402
from protocol import Client  # noqa: E402
from serving import Server  # noqa: E402
from waiting import wait_until  # noqa: E402


def lecturer_of(server: Server) -> Client:
    """Its page, with all that arrives only counted."""
    path = wait_until(lambda: re.search(r"the lecturer opens http://[^/]+(\S+)\n", server.log))[1]
    connection = http.client.HTTPConnection(server.url.removeprefix("http://"))
    connection.request("GET", path)
    cookies = connection.getresponse().headers.get_all("Set-Cookie")
    return Lecturer(server.url, "; ".join(one.split(";")[0] for one in cookies))


class Lecturer(Counting):
    def __init__(self, url: str, cookie: str):
        self.counts, self.posed_at, self._counting = dict.fromkeys(("poses", "panels", "plots"), 0), [], False
        Client.__init__(self, url, cookie=cookie)
        self.ready(120)
        self._counting = True


def measure(clients: int, seconds: float, speed: str, workers: int) -> dict:
    options = ("--workers", str(workers), "--max-clients", str(clients + 1), *OPTIONS)
    servers = {"without": Server(*options), "with": Server(*options, "--lecturer")}
    context = multiprocessing.get_context("spawn")
    begin, end, results = context.Event(), context.Event(), context.Queue()
    processes = [
        context.Process(target=run_clients, args=(server.url, clients, speed, begin, end, results), daemon=True)
        for server in servers.values()
    ]
    for process in processes:
        process.start()
    others = [Counting(servers["without"].url), lecturer_of(servers["with"])]  # as many pages here as there
    time.sleep(WARM_UP_S)
    begin.set()
    before, since = {name: server.cpu_s for name, server in servers.items()}, time.monotonic()
    time.sleep(seconds)
    passed = time.monotonic() - since
    cores = {name: (server.cpu_s - before[name]) / passed for name, server in servers.items()}
    end.set()
    rates = [results.get() for _ in processes]
    for process in processes:
        process.join()
    for one in others:
        one.close()
    for server in servers.values():
        server.stop()
    poses = [round(sum(rate["poses"] for rate in each) / len(each), 2) for each in rates]
    return {
        "clients": clients,
        "speed": speed,
        "workers": workers,
        "cores": {name: round(used, 3) for name, used in cores.items()},
        "poses_a_second": poses,
        "more_percent": round(100 * (cores["with"] / cores["without"] - 1), 1),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clients", type=int, default=30)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--workers", type=int, default=2, help="processes of each server (%(default)s)")
    parser.add_argument("--speed", default="1 a second", help="of the loops, as the page has it (%(default)s)")
    args = parser.parse_args()
    json.dump(measure(args.clients, args.seconds, args.speed, args.workers), sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
