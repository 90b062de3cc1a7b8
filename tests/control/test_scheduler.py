"""One task for all pages: each ticks, one that fails does not stop the others."""

import threading
import time

from viewimit.app.control.scheduler import FAULTS_EVERY, Scheduler
from viewimit.app.jobs.landscapes import LandscapeWorker
from waiting import stays, wait_until


def no_heartbeat() -> None:
    pass


class Counting:
    def __init__(self, fault=None):
        self.ticks, self.fault, self.failed, self.threads = 0, fault, [], set()

    def steps(self, now):
        self.ticks += 1
        self.threads.add(threading.get_ident())
        yield
        if self.fault:
            raise self.fault

    def fail(self, error):
        self.failed.append(error)


def test_a_failing_page_is_told_and_the_others_go_on(caplog, event_loop):
    scheduler = Scheduler(no_heartbeat)
    good, bad, fault = Counting(), Counting(RuntimeError("broken")), None
    scheduler.add(bad)
    scheduler.add(good)
    scheduler.start(event_loop)
    wait_until(lambda: good.ticks >= 5)
    fault = bad.failed[0]
    scheduler.remove(bad)
    wait_until(lambda: good.ticks >= 8)
    scheduler.stop()
    ticks = good.ticks
    stays(lambda: good.ticks == ticks, 0.15)
    assert str(fault) == "broken" and len(good.threads) == 1
    assert "RuntimeError('broken') at test_scheduler.py" in caplog.messages[0]


def test_pages_that_fail_at_every_tick_fill_no_log(caplog, event_loop):
    scheduler, bad = Scheduler(no_heartbeat), Counting(RuntimeError("broken"))
    for page in (bad, *(Counting(RuntimeError("as well")) for _ in range(9))):
        scheduler.add(page)
    began = time.monotonic()
    scheduler.start(event_loop)
    wait_until(lambda: bad.ticks >= 30)
    seconds = time.monotonic() - began
    scheduler.stop()
    assert 1 <= len(caplog.messages) <= 1 + seconds / FAULTS_EVERY
    assert not any("\n" in message for message in caplog.messages)


def test_the_newest_request_for_a_landscape_wins():
    worker, gate, made = LandscapeWorker(), threading.Event(), []
    worker.ask(0, lambda: gate.wait(5), lambda _: None)
    for k in range(5):
        worker.ask(1, lambda k=k: k, made.append)
    worker.ask(2, lambda: "other", made.append)
    gate.set()
    wait_until(lambda: len(made) == 2)
    assert made == [4, "other"]


def test_a_failing_landscape_does_not_end_the_worker(capsys):
    worker, made = LandscapeWorker(), []
    worker.ask(0, lambda: 1 / 0, made.append)
    worker.ask(1, lambda: "next", made.append)
    wait_until(lambda: len(made) == 2)
    assert isinstance(made[0], ZeroDivisionError) and made[1] == "next"  # its page gets the fault, to say it
    assert "ZeroDivisionError" in capsys.readouterr().err


def test_a_page_that_cannot_say_its_fault_is_ticked_no_more(caplog, event_loop):
    scheduler, good, bad = Scheduler(no_heartbeat), Counting(), Counting(RuntimeError("broken"))
    bad.fail = lambda error: 1 / 0
    scheduler.add(bad)
    scheduler.add(good)
    scheduler.start(event_loop)
    wait_until(lambda: good.ticks >= 5)
    scheduler.stop()
    assert bad.ticks == 1 and "ZeroDivisionError" in caplog.messages[-1]


class Stepping:
    """Tells in `made` each of its two steps."""

    def __init__(self, name, made):
        self.name, self.made = name, made

    def steps(self, now):
        self.made.append((self.name, 1))
        yield
        self.made.append((self.name, 2))


def test_pages_make_each_step_of_a_tick_one_after_the_other(event_loop):
    scheduler, made = Scheduler(no_heartbeat), []
    for name in "ab":
        scheduler.add(Stepping(name, made))
    scheduler.start(event_loop)
    wait_until(lambda: len(made) >= 8)
    scheduler.stop()
    assert made[:8] == 2 * [("a", 1), ("b", 1), ("a", 2), ("b", 2)]


def test_a_page_that_is_removed_makes_no_further_step(event_loop):
    scheduler, made = Scheduler(no_heartbeat), []
    page, other = Stepping("page", made), Stepping("other", made)
    leaves = other.steps

    def steps(now):
        for _ in leaves(now):
            scheduler.remove(page)
            yield

    other.steps = steps
    scheduler.add(page)
    scheduler.add(other)
    scheduler.start(event_loop)
    wait_until(lambda: made.count(("other", 2)) >= 2)
    scheduler.stop()
    assert made[:3] == [("page", 1), ("other", 1), ("other", 2)] and ("page", 2) not in made
