"""Ten minutes of visitors at a server: no session may be lost.

PYTHONPATH=tests python tests/soak_sessions.py --minutes 10 --clients 12

Each visitor drags, makes motions, undoes and resets, leaves now and then and comes again with what its tab has kept. It
finds the same posture; in the end all that the tabs have kept is computed again, to the same posture to the last bit.
"""

import argparse
import random
import threading
import time
from contextlib import suppress

import numpy as np
from protocol import BEGINS_WITHIN_S, Client, Tab
from serving import Server
from viewimit.app.sessions.link import decode
from waiting import wait_until
from websockets.exceptions import InvalidHandshake

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

STAYS_S = 20.0  # on average, before a visitor reloads the page
BACK_WITHIN_S = 90.0


class Visitor(threading.Thread):
    """One tab. lost: what was not as it had been; pages, motions: counts; cut: connections that it lost."""

    def __init__(self, url: str, number: int, until: float):
        super().__init__(daemon=True)
        self._url, self._until, self._random = url, until, random.Random(number)
        self.tab, self.lost = Tab(), list[str]()
        self.pages = self.motions = self.cut = 0
        self.longest_s = 0.0  # without a page

    def run(self) -> None:
        try:
            self._visit()
        except BaseException as error:
            self.lost.append(repr(error))
            raise

    def _visit(self) -> None:
        while time.monotonic() < self._until:
            gone = time.monotonic()
            client = self._connected()
            if client is None:
                return
            with client:
                self._come_back(client)
                self.longest_s = max(self.longest_s, time.monotonic() - gone)
                self._work(client)

    def _connected(self) -> Client | None:
        while time.monotonic() < self._until + BACK_WITHIN_S:
            with suppress(OSError, InvalidHandshake, AssertionError, EOFError):
                return Client(self._url, tab=self.tab).ready(BEGINS_WITHIN_S)
            time.sleep(0.5)
        self.lost.append("no page came")
        return None

    def _come_back(self, client: Client) -> None:
        self.pages += 1
        if not self.tab.blocks:
            return
        kept = decode(self.tab.text, Settings.paper())
        cursor = kept.present.runs[0].cursor
        wanted = kept.settings.demonstrator_deg[0]
        try:
            is_back = lambda: (client.value("History"), client.value("θ₂")) == (cursor, round(wanted, 1))
            wait_until(lambda: client.closed(0) is not None or is_back(), BACK_WITHIN_S)
        except AssertionError:
            if client.closed(0) is None:
                found = client.value("History"), client.value("θ₂"), client.status
                self.lost.append(f"{found} in place of motion {cursor}, θ₂ = {wanted:g}")

    def _work(self, client: Client) -> None:
        leaves = time.monotonic() + self._random.expovariate(1 / STAYS_S)
        while time.monotonic() < min(leaves, self._until):
            if client.closed(0) is not None:
                self.cut += 1
                return
            what = self._random.random()
            if what < 0.5:
                client.press("Make one step")
                self.motions += 1
            elif what < 0.9:
                client.put("θ₂", self._random.randint(20, 140) / 2)
            elif what < 0.97:
                client.press("Undo one step; at a start, go back to what was before it")
            else:
                client.press("Reset to the start")
            time.sleep(self._random.uniform(0.1, 0.5))
        with suppress(AssertionError):
            client.keep(10.0)
            time.sleep(1.5)  # as a person reads before reloading


def computed_again(tab: Tab) -> bool:
    page = decode(tab.text, Settings.paper())
    session = Session(Settings.paper())
    session.play(page.present.runs[0].script)
    session.scrub(page.present.runs[0].cursor)
    return np.array_equal(session.snapshot.commanded, page.commanded)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--clients", type=int, default=12)
    asked = parser.parse_args()
    server = Server("--max-clients", str(2 * asked.clients + 8))
    began = time.monotonic()
    visitors = [Visitor(server.url, k, began + 60 * asked.minutes) for k in range(asked.clients)]
    for visitor in visitors:
        visitor.start()
    for visitor in visitors:
        visitor.join(60 * asked.minutes + 2 * BACK_WITHIN_S)
    lost = [what for visitor in visitors for what in visitor.lost]
    same = sum(computed_again(visitor.tab) for visitor in visitors if visitor.tab.blocks)
    kept = sum(bool(visitor.tab.blocks) for visitor in visitors)
    pages, motions, cut = (sum(getattr(v, name) for v in visitors) for name in ("pages", "motions", "cut"))
    largest, longest = max(len(v.tab.text) for v in visitors), max(v.longest_s for v in visitors)
    print(
        f"{pages} pages, {motions} motions, {cut} connections cut; {len(lost)} sessions lost; {same} of {kept} "
        f"computed again to the last bit; longest without a page {longest:.0f} s; {largest} characters at most"
    )
    print(*lost, sep="\n")
    print("Traceback in its log" if "Traceback" in server.log else "no traceback in its log")
    server.stop()
    return 1 if lost or same < kept else 0


if __name__ == "__main__":
    raise SystemExit(main())
