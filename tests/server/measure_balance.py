"""How a class spreads over workers: `PYTHONPATH=tests python tests/server/measure_balance.py --clients 30`.

Tabs, each of another browser, come at once, within some seconds, and as browsers come, with connections beside the
page's own; each time half of one worker's tabs then leave, and half as many as came first come new. Tabs whose network
falls silent, unseen by the server, come back on another. In the end a worker is killed while all play. Told are the
tabs of each worker; how many that came back have their session, after how long, and what they lost; and how long
somebody who is new waits for an answer meanwhile.
"""

import argparse
import http.client
import json
import os
import re
import signal
import socket
import statistics
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from urllib.error import HTTPError

from measure_load import OPTIONS
from protocol import Client
from serving import Relay, Server, browser_of, workers_of
from waiting import wait_until
from websockets.exceptions import WebSocketException

COME_WITHIN_S, READY_WITHIN_S = 5.0, 60.0
FILES, IDLE = 4, 2  # connections of a browser: for a file each, and opened in advance, on which nothing is asked
PLAYED_S = 8.0  # longer than between two writes to the store
AGAIN_AFTER_S = 1.0  # as viser's page tries
NOTICED_WITHIN_S = 3.0  # that a connection is cut off
ASKED_EVERY_S = 0.1


class Tab(Client):
    """worker: number of the process that its page is at, as its links have it."""

    def __init__(self, url: str, cookie: str | None = None):
        self.url, self.cookie = url, cookie or browser_of(url)
        super().__init__(url, cookie=self.cookie)
        self.ready(READY_WITHIN_S)
        self.worker = int(wait_until(lambda: re.search(r"/touch/(\d+)\.", "".join(list(self.html.values()))))[1])


def browse(url: str) -> Tab:
    """As a browser comes, which would keep its connections."""
    place = url.removeprefix("http://").split(":")
    idle = [socket.create_connection(place) for _ in range(IDLE)]
    files = [http.client.HTTPConnection(*place) for _ in range(FILES)]
    for one in files:
        one.request("GET", "/", headers={"Connection": "keep-alive"})
    cookies = [one.getresponse().headers["Set-Cookie"].split(";")[0] for one in files]
    tab = Tab(url, cookies[0])
    for one in (*files, *idle):
        one.close()
    return tab


def come(url: str, count: int, within: float, how: Callable[[str], Tab]) -> list[Tab]:
    def one(k: int) -> Tab:
        time.sleep(within * k / count)
        return how(url)

    with ThreadPoolExecutor(count) as threads:
        return list(threads.map(one, range(count)))


def at_workers(tabs: list[Tab], workers: int) -> list[int]:
    at = Counter(tab.worker for tab in tabs)
    return [at[worker] for worker in range(workers)]


def balance(clients: int, workers: int, within: float, how: Callable[[str], Tab]) -> dict[str, list[int]]:
    server = Server("--workers", str(workers), "--max-clients", str(2 * clients), *OPTIONS)
    tabs = come(server.url, clients, within, how)
    came, first = at_workers(tabs, workers), [tab for tab in tabs if tab.worker == 0]
    for tab in first[: len(first) // 2]:
        tab.close()
        tabs.remove(tab)
    wait_until(lambda: server.seated == len(tabs))
    left = at_workers(tabs, workers)
    tabs += come(server.url, clients // 2, within, how)
    for tab in tabs:
        tab.close()
    server.stop()
    return {"came": came, "left": left, "after": at_workers(tabs, workers)}


def silent(count: int, workers: int) -> dict:
    """One after the other, each with one motion done."""
    server, took = Server("--workers", str(workers), *OPTIONS), []
    for _ in range(count):
        relay, cookie = Relay(server.url), browser_of(server.url)
        with Tab(relay.url, cookie.replace(*(url.rsplit(":", 1)[1] for url in (server.url, relay.url)))) as tab:
            tab.press("Step: one motion")
            wait_until(lambda: tab.value("History") == 1)  # noqa: B023
            time.sleep(PLAYED_S)
            relay.silent.set()
            time.sleep(AGAIN_AFTER_S)
            since = time.monotonic()
            with Tab(server.url, cookie) as again:
                if again.value("History") == 1:
                    took.append(time.monotonic() - since)
        relay.close()
    server.stop()
    return {"came": count, "have their session": len(took), "after s": summary(took) if took else None}


def killed(clients: int, workers: int) -> dict:
    server = Server("--workers", str(workers), "--max-clients", str(clients + 10), *OPTIONS)
    tabs = come(server.url, clients, COME_WITHIN_S, Tab)
    before = at_workers(tabs, workers)
    for tab in tabs:
        tab.put("Speed", "10 a second")
        tab.press("Play or pause")
    time.sleep(PLAYED_S)
    waited, end = [], threading.Event()
    asking = threading.Thread(target=ask, args=(server.url, waited, end))
    asking.start()
    motions, at = [tab.value("History") for tab in tabs], time.monotonic()
    os.kill(workers_of(server)[0], signal.SIGKILL)
    with ThreadPoolExecutor(clients) as threads:
        again = list(threads.map(come_back, tabs))
    end.set()
    asking.join()
    back = [(tab, when - at, had) for (tab, when), had in zip(again, motions) if when is not None]
    lost = [had - tab.value("History") for tab, _, had in back]
    for tab, _ in again:
        tab.close()
    server.stop()
    return {
        "before": before,
        "after": at_workers([tab for tab, _ in again], workers),
        "cut off": len(back),
        "back after s": summary([seconds for _, seconds, _ in back]),
        "motions lost": summary(lost),
        "answered after s": summary(waited),
    }


def come_back(tab: Tab) -> tuple[Tab, float | None]:
    """The tab that takes its place, and when; itself, and None, if it is not cut off."""
    if tab.closed(NOTICED_WITHIN_S) is None:
        return tab, None
    until = time.monotonic() + READY_WITHIN_S
    while time.monotonic() < until:
        time.sleep(AGAIN_AFTER_S)
        with suppress(OSError, EOFError, WebSocketException):
            return Tab(tab.url, tab.cookie), time.monotonic()
    raise TimeoutError(f"a tab is not back after {READY_WITHIN_S:g} s")


def ask(url: str, waited: list[float], end: threading.Event) -> None:
    """As who has never been here, again and again. waited: s, for each answer."""
    while not end.wait(ASKED_EVERY_S):
        asked = time.monotonic()
        with suppress(HTTPError):  # that there is no seat is an answer too
            browser_of(url)
        waited.append(time.monotonic() - asked)


def summary(values: list[float]) -> dict[str, float]:
    return {"median": round(statistics.median(values), 2), "most": round(max(values), 2)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--clients", type=int, default=30)
    parser.add_argument("--workers", type=int, default=2, help="processes of the server (%(default)s)")
    parser.add_argument("--silent", type=int, default=6, help="tabs whose network falls silent (%(default)s)")
    args = parser.parse_args()
    class_of = args.clients, args.workers
    figures = {
        "at once": balance(*class_of, 0.0, Tab),
        "within some seconds": balance(*class_of, COME_WITHIN_S, Tab),
        "as browsers": balance(*class_of, COME_WITHIN_S, browse),
        "a silent network": silent(args.silent, args.workers),
        "a worker killed": killed(*class_of),
    }
    json.dump(figures, sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
