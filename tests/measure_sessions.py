"""What sessions that tabs keep cost: ten minutes of dragging, and a link beside two hostile ones.

PYTHONPATH=tests python tests/measure_sessions.py    # --links: without the dragging
"""

import argparse
import time

import numpy as np
from page_fakes import Hands
from protocol import Client
from quiet_page import QuietPage
from serving import Server
from viewimit.app.sessions.link import Branch, Run, SavedPage, encode_link
from waiting import wait_until

from viewimit.loop.script import Script, Steps
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings

VALUES = 12_000  # of a slider that is dragged for ten minutes, 20 a second
MOTIONS_A_SECOND = 2
PATIENCE_S = 300


def drag(settings: Settings) -> None:
    page, rng, angle = QuietPage(settings), np.random.default_rng(0), 45.0
    page.restore()
    hands = Hands(page.page.model)
    for k in range(VALUES):
        angle = float(np.clip(angle + 0.5 * rng.integers(-3, 4), 5, 80))
        hands.set("joint0", angle)
        if k % (20 // MOTIONS_A_SECOND) == 0:
            hands.act("step")
    kept, again = page.kept, Session(settings)
    began = time.process_time()
    again.play(page.page.model.session.script)
    spent = time.process_time() - began
    found = np.array_equal(again.snapshot.theta, page.page.model.session.snapshot.theta)
    print(
        f"{settings.servo}: ten minutes of dragging, {page.page.model.session.cursor} motions: {len(kept)} characters "
        f"in the tab, {len(encode_link(page.page.model.linked()))} as a link, {spent:.1f} s of CPU to play, "
        f"{'the same to the last bit' if found else 'ANOTHER POSTURE'}"
    )


def link_to(settings: Settings, steps: int) -> str:
    run = Run(script=Script(settings, (Steps(steps),)), cursor=0)
    return encode_link(SavedPage(present=Branch(runs=(run,)), settings=settings))


def opens_within(server: Server) -> float:
    """s from sending a link of three motions to its posture on the page."""
    with Client(server.url).ready() as client:
        began = time.monotonic()
        client.act("link", link_to(Settings.paper(seed=99), 3))
        wait_until(lambda: client.value("Seed") == 99, PATIENCE_S)
        return time.monotonic() - began


def beside_hostile_links() -> None:
    server = Server()
    alone = [opens_within(server) for _ in range(3)]
    hostile = link_to(Settings.paper(noise_px=5.0, frames=100, missing=0.3, outliers=0.3, servo="trust-region"), 10**6)
    clients = [Client(server.url).ready() for _ in range(2)]
    for client in clients:
        client.act("link", hostile)
    wait_until(lambda: all("Computing" in client.status for client in clients), 30)
    beside = [opens_within(server) for _ in range(5)]
    assert all("Computing" in client.status for client in clients), "they are still played"
    for client in clients:
        client.close()
    server.stop()
    print(f"a link opens within {max(alone):.2f} s alone, {max(beside):.2f} s beside two hostile ones (median "
          f"{np.median(beside):.2f} s)")  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--links", action="store_true", help="only a good link beside two hostile ones")
    for begun in () if parser.parse_args().links else (Settings.paper(), Settings()):
        drag(begun)
    beside_hostile_links()
