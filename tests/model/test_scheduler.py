"""One task for all pages: each ticks, one that fails does not stop the others."""

import asyncio
import contextlib
import itertools
import threading
import time
from functools import partial

import pytest
from viewimit.app.jobs.threads import LandscapeWorker
from viewimit.app.page.scheduler import FAULTS_EVERY, FEW, TICK, Scheduler
from waiting import stays, wait_until


def no_heartbeat() -> None:
    pass


class Counting:
    def __init__(self, fault=None):
        self.ticks, self.fault, self.failed, self.threads = 0, fault, [], set()

    held = staticmethod(contextlib.nullcontext)

    def tick(self, now):
        self.ticks += 1
        self.threads.add(threading.get_ident())
        if self.fault:
            raise self.fault

    def drawings(self):
        return ()

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
    scheduler.stop()
    seconds = time.monotonic() - began
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


class Drawn(Counting):
    """drawn: what all of these have drawn, in order. while_drawing: by kind, what happens in it."""

    def __init__(self, name, kinds, drawn, while_drawing=()):
        super().__init__()
        self.name, self.kinds, self.drawn, self.while_drawing = name, kinds, drawn, dict(while_drawing)

    def drawings(self):
        return [(kind, partial(self.draw, kind)) for kind in self.kinds]

    def draw(self, kind):
        self.drawn.append(f"{kind} of {self.name}")
        self.while_drawing.get(kind, lambda: None)()


def one_round(event_loop, *pages, before=lambda scheduler: None):
    """Of a new scheduler, after before(scheduler). Its second heartbeat removes the pages, before they tick again."""
    beats, done = itertools.count(), threading.Event()

    def beat():
        if next(beats):
            for page in pages:
                scheduler.remove(page)
            done.set()

    scheduler = Scheduler(beat)
    before(scheduler)
    for page in pages:
        scheduler.add(page)
    scheduler.start(event_loop)
    assert done.wait(20)
    scheduler.stop()


def test_what_is_alike_is_drawn_page_by_page_after_all_have_ticked(event_loop):
    drawn = []
    pages = [Drawn("a", ("scene", "images"), drawn), Drawn("b", ("scene", "curves", "images"), drawn)]
    one_round(event_loop, *pages)
    assert drawn == ["scene of a", "scene of b", "images of a", "images of b", "curves of b"]
    assert [page.ticks for page in pages] == [1, 1]


def test_a_drawing_that_fails_is_told_to_its_page_and_all_others_are_drawn(event_loop):
    drawn = []
    bad = Drawn("a", ("scene", "images"), drawn, {"scene": lambda: 1 / 0})
    good = Drawn("b", ("scene", "images"), drawn)
    one_round(event_loop, bad, good)
    assert [type(error) for error in bad.failed] == [ZeroDivisionError] and not good.failed
    assert drawn == ["scene of a", "scene of b", "images of a", "images of b"]


def test_a_page_that_has_gone_meanwhile_is_not_drawn(event_loop):
    drawn, gone = [], Drawn("b", ("scene",), [])
    first = Drawn("a", ("scene", "images"), drawn)
    leaves = lambda scheduler: first.while_drawing.update(scene=lambda: scheduler.remove(gone))
    one_round(event_loop, first, gone, before=leaves)
    assert gone.ticks == 1 and gone.drawn == [] and drawn == ["scene of a", "images of a"]


class Sent(Drawn):
    @contextlib.contextmanager
    def held(self):
        yield
        self.drawn.append(f"{self.name} is sent")


def test_poses_do_not_wait_for_drawings_of_which_there_are_too_many(event_loop):
    drawn = []
    pages = [Sent("a", ("scene",), drawn), Sent("b", ("scene",), drawn)]
    one_round(event_loop, *pages, before=lambda scheduler: setattr(scheduler.shedding, "strain", 0.1))
    assert drawn == ["a is sent", "b is sent", "scene of a", "a is sent", "scene of b", "b is sent"]


def test_drawings_that_a_tick_has_no_time_for_come_first_in_the_next(event_loop):
    drawn = []
    pages = [Drawn(name, ("scene",), drawn, {"scene": partial(time.sleep, TICK)}) for name in "abcdefg"]
    scheduler = Scheduler(no_heartbeat)
    scheduler.shedding.strain = 2.0
    for page in pages:
        scheduler.add(page)
    scheduler.start(event_loop)
    wait_until(lambda: len(drawn) >= 4 * FEW)
    scheduler.stop()
    rounds = pages[0].ticks  # in each of which few are drawn, as the first of these takes all of its time
    assert [one[-1] for one in drawn] == [name for _, name in zip(drawn, itertools.cycle("abcdefg"))]
    assert FEW * (rounds - 1) <= len(drawn) <= FEW * rounds
    assert all(rounds - 1 <= page.ticks <= rounds for page in pages)


class Clock:
    """time, for a scheduler whose pages take as long as they say."""

    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        return self.now


class Timed(Counting):
    """Its drawing, which is due in every second tick, takes so many s."""

    def __init__(self, clock, takes):
        super().__init__()
        self.clock, self.takes, self.due, self.spent = clock, takes, False, 0.0

    def tick(self, now):
        super().tick(now)
        self.due |= self.ticks % 2 == 1

    def drawings(self):
        return [("scene", self.draw)] if self.due else []

    def draw(self):
        self.due = False
        self.clock.now += self.takes
        self.spent += self.takes


def rounds(event_loop, monkeypatch, share, seconds):
    """Of 16 pages that draw in the same tick, which has no time for all of them, and take that share of two ticks. →
    the scheduler, all that the rounds counted and all that drawing took, s."""
    clock = Clock()
    monkeypatch.setattr("viewimit.app.page.scheduler.time", clock)
    scheduler, counted = Scheduler(no_heartbeat), 0.0
    scheduler.shedding.strain = 0.5
    pages = [Timed(clock, share * 2 * TICK / 16) for _ in range(16)]
    for page in pages:
        scheduler.add(page)
    for k in range(round(seconds / TICK)):
        clock.now = max(clock.now, k * TICK)
        busy = asyncio.run_coroutine_threadsafe(scheduler.round(pages, (k + 1) * TICK), event_loop).result(20)
        counted += busy
        scheduler.shedding.ticked(busy)
    return scheduler, counted, sum(page.spent for page in pages)


@pytest.mark.parametrize("share", [0.5, 0.85, 0.95])
def test_while_there_is_time_for_all_each_drawing_is_counted_once_and_nothing_gives_way(event_loop, monkeypatch, share):
    scheduler, counted, spent = rounds(event_loop, monkeypatch, share, 40.0)
    assert scheduler.shedding.strain < 0.1
    _, counted, spent = rounds(event_loop, monkeypatch, share, 1.0)
    assert counted == pytest.approx(spent) == pytest.approx(share)


@pytest.mark.parametrize("share", [1.2, 1.6, 3.0])
def test_what_there_is_no_time_for_gives_way_within_seconds(event_loop, monkeypatch, share):
    scheduler, counted, spent = rounds(event_loop, monkeypatch, share, 8.0)
    assert scheduler.shedding.strain == 2.0 and counted > 1.05 * spent


def test_a_page_that_has_gone_while_its_drawings_waited_holds_up_no_other(event_loop):
    drawn = []
    pages = [Drawn(name, ("scene",), drawn, {"scene": partial(time.sleep, TICK)}) for name in "abcdefg"]
    leaves, rounds = pages[FEW], itertools.count()
    scheduler = Scheduler(lambda: scheduler.remove(leaves) if next(rounds) == 1 else None)
    scheduler.shedding.strain = 2.0
    for page in pages:
        scheduler.add(page)
    scheduler.start(event_loop)
    wait_until(lambda: {one[-1] for one in drawn} == set("abcdefg") - {leaves.name})
    scheduler.stop()
    assert leaves.ticks == 1


def test_a_page_is_sent_with_its_last_drawing_and_at_once_without_any(event_loop):
    drawn = []
    pages = [Sent("a", ("scene",), drawn), Sent("b", (), drawn), Sent("c", ("scene", "images"), drawn)]
    one_round(event_loop, *pages)
    scenes = ["scene of a", "a is sent", "scene of c"]
    assert drawn == ["b is sent", *scenes, "images of c", "c is sent"]
