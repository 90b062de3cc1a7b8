"""What gives way when there is too much to do, in which order, and that it comes back."""

import contextlib
import itertools
import time

import pytest
from viewimit.app.model.player import Player
from viewimit.app.model.services import AIM, SLOWEST, STEPS, LoadShedding, ToDraw
from viewimit.app.page.scheduler import TICK, Scheduler
from viewimit.app.server.seats import Seats
from waiting import wait_until

from viewimit.loop.session import Session
from viewimit.loop.settings import Settings


def after(load: LoadShedding, ticks: int, busy: float) -> tuple[float, float]:
    for _ in range(ticks):
        load.ticked(busy * TICK)
    return load.plots, load.panels


def test_plots_give_way_first_then_panels_and_panels_recover_first():
    load = LoadShedding(TICK)
    assert after(load, 1000, busy=0.5) == (1.0, 1.0)
    plots, panels = after(load, 60, busy=AIM + 0.35)
    assert 1 < plots < SLOWEST and panels == 1.0
    plots, panels = after(load, 60, busy=AIM + 0.35)
    assert plots == SLOWEST and 1 < panels < SLOWEST
    assert after(load, 1000, busy=9.0) == (SLOWEST, SLOWEST)
    plots, panels = after(load, 80, busy=AIM - 0.55)
    assert plots > 1 and panels == 1.0
    assert after(load, 1000, busy=0.2) == (1.0, 1.0)


def test_sessions_that_run_as_fast_as_they_compute_share_the_time_for_it():
    load = LoadShedding(TICK)
    for _ in range(2):  # from the second tick on it is known how many there are
        budgets = [load.step_budget() for _ in range(8)]
        load.ticked(0.0)
    assert sum(budgets) == pytest.approx(STEPS * TICK)
    assert load.step_budget() == pytest.approx(STEPS * TICK / 8)
    load.ticked(0.0)
    load.ticked(0.0)
    assert load.step_budget() == pytest.approx(STEPS * TICK)


def test_a_player_keeps_to_its_budget():
    looked = itertools.count()  # each look at the clock takes 4 ms
    player = Player(Session(Settings.paper(servo="gradient")), lambda: 0.004 * next(looked))
    player.speed = 0
    player.toggle()
    player.advance(0.0, lambda: 0.0)
    assert player.cursor == 0
    player.advance(0.0, lambda: 0.018)
    assert player.cursor == 4  # it was asked at 4, 8, 12 and 16 ms


class Slow:
    """A page whose panels and plots cost too much for the tick, as a real one draws them."""

    def __init__(self, load: LoadShedding):
        self.load, self.poses, self.panels, self.next = load, 0, 0, 0.0

    held = staticmethod(contextlib.nullcontext)

    def tick(self, now: float) -> None:
        self.poses += 1
        self.now = now

    def drawings(self) -> list[ToDraw]:
        if self.now < self.next:
            return []
        self.next = self.now + 0.1 * self.load.panels
        return [("panels", self.draw)]

    def draw(self) -> None:
        self.panels += 1
        time.sleep(0.04)

    def fail(self, error: Exception) -> None:
        raise error


def test_poses_recover_their_pace_by_slower_panels(event_loop):
    counts = Seats()
    scheduler = Scheduler(counts.rows[0].live, counts.rows[0].clear)
    pages = [Slow(scheduler.shedding) for _ in range(4)]  # 1.6 of the time there is
    for page in pages:
        scheduler.add(page)
    scheduler.start(event_loop)

    def poses_prevail() -> bool:
        poses, panels = pages[0].poses, pages[0].panels
        wait_until(lambda: pages[0].poses >= poses + 20)
        return pages[0].poses - poses > 2 * (pages[0].panels - panels)

    wait_until(poses_prevail, 30)
    wait_until(lambda: scheduler.shedding.panels > 1.5, 30)  # at 1.6 they take the time there is
    assert counts.well
    scheduler.stop()
    assert not counts.well
