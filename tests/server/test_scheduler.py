"""One task for all pages: each ticks, one that fails does not stop the others, and drawings give way to poses."""

import contextlib
import threading

import pytest
from viewimit.app.model.queue import CommandQueue, Worker
from viewimit.app.server import scheduler as scheduler_module
from viewimit.app.server.scheduler import PATIENCE, TICK, Scheduler
from waiting import stays, wait_until


class Counting:
    def __init__(self, fault=None):
        self.ticks, self.fault, self.failed, self.threads = 0, fault, [], set()

    held = staticmethod(contextlib.nullcontext)

    def tick(self, now, budget):
        self.ticks += 1
        self.threads.add(threading.get_ident())
        if self.fault:
            raise self.fault

    def draw(self):
        pass

    def fail(self, error):
        self.failed.append(error)


def test_a_failing_page_is_told_and_the_others_go_on(caplog, event_loop):
    scheduler = Scheduler()
    good, bad, fault = Counting(), Counting(RuntimeError("broken")), None
    scheduler.add(bad)
    scheduler.add(good)
    scheduler.start(event_loop)
    wait_until(lambda: good.ticks >= 5)
    fault = bad.failed[0]
    event_loop.call_soon_threadsafe(scheduler.remove, bad)
    wait_until(lambda: good.ticks >= 8)
    scheduler.stop()
    ticks = good.ticks
    stays(lambda: good.ticks == ticks, 0.15)
    assert str(fault) == "broken" and len(good.threads) == 1
    assert "RuntimeError('broken') at test_scheduler.py" in caplog.messages[0]


def test_a_failing_landscape_does_not_end_the_worker(capsys):
    worker, queue, made = Worker(), CommandQueue({}), []
    worker.ask(queue, "one", lambda: 1 / 0, made.append)
    worker.ask(queue, "two", lambda: "next", made.append)
    wait_until(lambda: not [entry.apply(None, 0.0) for entry in queue.take()] and len(made) == 2)
    assert isinstance(made[0], ZeroDivisionError) and made[1] == "next"  # its page gets the fault, to say it
    assert "ZeroDivisionError" in capsys.readouterr().err


class Clock:
    """time, for pages that take as long as they say."""

    now = 1000.0

    def monotonic(self):
        return self.now


class Timed(Counting):
    """Ticks and drawings take so many s of a clock. drawn: when it drew."""

    def __init__(self, clock, tick_s, draw_s):
        super().__init__()
        self.clock, self.tick_s, self.draw_s, self.drawn = clock, tick_s, draw_s, []

    def tick(self, now, budget):
        super().tick(now, budget)
        self.clock.now += self.tick_s

    def draw(self):
        self.clock.now += self.draw_s
        self.drawn.append(self.clock.now)


@pytest.mark.parametrize(
    "count, tick_s, draw_s", [(40, 0.0005, 0.005), (40, 0.002, 0.005), (60, 0.0009, 0.01), (7, 0.0, TICK)]
)
def test_poses_keep_their_pace_and_late_drawings_come_in_turn(event_loop, monkeypatch, count, tick_s, draw_s):
    clock = Clock()
    monkeypatch.setattr(scheduler_module, "time", clock)
    scheduler, pages = Scheduler(), [Timed(clock, tick_s, draw_s) for _ in range(count)]
    for page in pages:
        scheduler.add(page)
    scheduler.start(event_loop)
    wait_until(lambda: clock.now > 1020)
    scheduler.stop()
    round_s = max(TICK, count * tick_s + min(count * draw_s * TICK / PATIENCE, TICK) + draw_s)
    assert min(page.ticks for page in pages) >= 20 / round_s / 2
    for page in pages:
        waits = [later - earlier for earlier, later in zip(page.drawn, page.drawn[1:])]
        assert max(waits) < PATIENCE + 4 * count * draw_s
    drawn = [len(page.drawn) for page in pages]
    assert max(drawn) < 2 * min(drawn)
