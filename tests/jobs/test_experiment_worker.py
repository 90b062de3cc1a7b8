"""Experiments in processes of their own: in order, told as they go on, ended at once, never in anybody's way."""

import contextlib
import io
import json
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import tempfile
import threading
import zipfile

import numpy as np
import pytest
from viewimit.app.jobs.experiment_child import FIGURE_EVERY, SHARE_EVERY, Progress
from viewimit.app.jobs.experiments import ExperimentWorker, Request
from viewimit.app.server.scheduler import Scheduler
from waiting import wait_until

from viewimit.experiments.paper import fig9
from viewimit.loop.settings import Settings

SHORT = Request("fig9", Settings.paper(), {"starts": (1, 1), "max_motions": 20})
LONG = Request("fig9", Settings.paper(), {"starts": (9, 9)})
PATIENCE = 180.0  # s, on a busy machine, for processes that let all others go first
LEAST_PRIORITY = 19  # no process can be more polite


@pytest.fixture
def worker(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    worker = ExperimentWorker()
    yield worker
    worker.stop()
    assert processes() == [] and list(tmp_path.iterdir()) == []  # whatever happened


class Told(list):
    """What one page has been told, in order."""

    def __init__(self):
        self._news = threading.Condition()

    def __call__(self, run):
        with self._news:
            self.append(run)
            self._news.notify_all()

    def wait(self, condition):
        with self._news:
            assert self._news.wait_for(lambda: bool(self) and condition(self[-1]), PATIENCE), self[-1:]
        return self[-1]

    def wait_for(self, *states):
        return self.wait(lambda run: run.state in states)

    @property
    def states(self):
        return list(dict.fromkeys(run.state for run in self))


def processes():
    return [process for process in multiprocessing.active_children() if process.name == "viewimit-experiment"]


def ended(pid):
    """Not even a zombie."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    return False


def running_pid(told):
    told.wait(lambda run: run.state == "running" and run.share > 0)
    (process,) = processes()
    return process.pid


def test_a_run_tells_its_share_its_figure_its_verdict_and_its_files(worker):
    told = Told()
    worker.ask(1, Request("fig9", Settings.paper(), {"starts": (1, 1), "max_motions": 500}), told)
    last = told.wait_for("done", "failed")
    assert told.states == ["waiting", "running", "writing", "done"]
    shares = [run.share for run in told]
    assert shares == sorted(shares) and len({share for share in shares if 0 < share < 1}) > 3 and shares[-1] == 1
    partial = {run.figure for run in told if run.state == "running" and run.figure}
    assert partial and last.figure not in partial and "0 of 1" in min(partial, key=len)
    again = fig9.run(Settings.paper(), starts=(1, 1), max_motions=500)
    assert list(last.claims) == list(again.claims) != []
    assert not any(run.claims for run in told if run.state == "running")
    with zipfile.ZipFile(io.BytesIO(last.archive)) as archive:
        assert {"fig9.npz", "fig9.json", "fig9-motions.csv", "fig9-arrivals.csv"} <= set(archive.namelist())
        assert json.loads(archive.read("fig9.json"))["settings"]["demonstrator_deg"] == [45, -90]
        drawn = [re.findall(r' d="([^"]+)"', figure) for figure in (archive.read("fig9.svg").decode(), last.figure)]
        assert drawn[0] == drawn[1] != []  # the figure that is shown
        arrays = np.load(io.BytesIO(archive.read("fig9.npz")))
        np.testing.assert_array_equal(arrays["motions.E_px2"], np.concatenate([run.E for run in again.runs]))
    assert 0 < last.seconds < PATIENCE


def test_cancel_ends_a_process_that_answers_nothing(worker, tmp_path):
    told = Told()
    worker.ask(1, LONG, told)
    pid = running_pid(told)
    os.kill(pid, signal.SIGSTOP)  # whatever it is busy with
    worker.cancel(1)
    assert told[-1].state == "cancelled" and told[-1].share > 0
    wait_until(lambda: ended(pid) and not list(tmp_path.iterdir()))
    told.clear()
    worker.ask(1, SHORT, told)
    assert told.wait_for("done", "failed").state == "done"
    assert "cancelled" not in told.states


def test_what_an_experiment_refuses_is_told_to_its_page_alone(worker, capfd):
    told, other = Told(), Told()
    worker.ask(1, Request("fig10", Settings.paper(missing=0.9)), told)
    worker.ask(2, Request("fig9", Settings.paper(), {"speed": 3}), other)
    assert "too few points" in told.wait_for("failed", "done").problem
    assert re.match(r"TypeError: .*'speed'", other.wait_for("failed", "done").problem)
    assert "too few points" not in "".join(run.problem for run in other)
    assert "unexpected keyword argument 'speed'" in capfd.readouterr().err  # the operator sees where


def test_a_process_that_dies_is_told_as_failed_and_the_next_one_runs(worker):
    told, other = Told(), Told()
    worker.ask(1, LONG, told)
    worker.ask(2, SHORT, other)
    os.kill(running_pid(told), signal.SIGKILL)
    assert "ended unexpectedly" in told.wait_for("failed", "done").problem
    assert other.wait_for("done", "failed").state == "done"


def test_one_at_a_time_in_the_order_asked_and_one_a_page(worker):
    told = {page: Told() for page in (1, 2, 3)}
    finished = []
    worker.ask(1, LONG, told[1])
    running_pid(told[1])
    worker.ask(2, LONG, told[2])
    worker.ask(3, SHORT, lambda run: (told[3](run), finished.append(3) if run.state == "done" else None))
    assert [told[page][-1].before for page in (2, 3)] == [1, 2]
    worker.ask(2, SHORT, lambda run: (told[2](run), finished.append(2) if run.state == "done" else None))
    assert [told[page][-1].before for page in (2, 3)] == [1, 2]  # the newer wish keeps the place
    with pytest.raises(ValueError, match="still runs"):
        worker.ask(1, SHORT, told[1])
    assert len(processes()) == 1
    worker.cancel(1)
    for page in (2, 3):
        told[page].wait_for("done", "failed")
    assert finished == [2, 3] and [run.before for run in told[3] if run.state == "waiting"][-1] == 1
    assert told[1][-1].state == "cancelled"


def test_a_page_that_leaves_is_told_nothing_more_and_makes_room(worker):
    told = {page: Told() for page in (1, 2, 3)}
    worker.ask(1, LONG, told[1])
    pid = running_pid(told[1])
    worker.ask(2, LONG, told[2])
    worker.ask(3, SHORT, told[3])
    for page in (2, 1):
        worker.forget(page)
    assert told[3].wait_for("done", "failed").state == "done"
    assert ended(pid) and told[1].states == ["waiting", "running"] and told[2].states == ["waiting"]


def test_a_waiting_wish_can_be_cancelled(worker):
    told, other = Told(), Told()
    worker.ask(1, LONG, told)
    running_pid(told)
    worker.ask(2, LONG, other)
    worker.cancel(2)
    assert other.states == ["waiting", "cancelled"] and told[-1].state == "running"


@pytest.mark.parametrize("early", [True, False], ids=["while it starts", "while it runs"])
def test_stopping_leaves_no_process(tmp_path, monkeypatch, early):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    worker, told = ExperimentWorker(), Told()
    worker.ask(1, LONG, told)
    worker.ask(2, SHORT, Told())
    told.wait_for("running") if early else running_pid(told)
    worker.stop()
    assert processes() == [] and list(tmp_path.iterdir()) == []
    assert told[-1].state == "running"  # nobody is left to be told


def test_sessions_go_on_while_an_experiment_runs(worker, event_loop):
    ticks = []

    class Page:
        held = staticmethod(contextlib.nullcontext)

        def tick(self, now, budget):
            ticks.append(now)

        def draw(self):
            pass

    scheduler, told = Scheduler(), Told()
    scheduler.add(Page())
    scheduler.start(event_loop)
    worker.ask(1, LONG, told)
    running_pid(told)
    ticks.clear()
    wait_until(lambda: len(ticks) > 60)
    assert told[-1].state == "running"  # all of them have come during it
    scheduler.stop()


def test_the_process_is_polite_and_loads_nothing_of_the_page(worker):
    told = Told()
    worker.ask(1, LONG, told)
    pid = running_pid(told)
    if hasattr(os, "getpriority"):
        assert os.getpriority(os.PRIO_PROCESS, pid) >= min(os.getpriority(os.PRIO_PROCESS, 0) + 10, LEAST_PRIORITY)
    code = "import {}, sys; print(*sys.modules)"
    modules = {
        "viewimit.app.jobs.experiment_child": {"numpy", "viser"},
        "viewimit.experiments": {"viser"},
    }
    for module, unwanted in modules.items():  # numpy would fix the number of threads before it is set
        command = [sys.executable, "-I", "-c", code.format(module)]
        loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
        assert module in loaded and not unwanted & set(loaded)


class TestProgress:
    def told(self, calls):
        """calls: (time, share, partial) → what is sent, with the time."""
        sent, now = [], [0.0]
        progress = Progress(lambda message: sent.append((now[0], *message)), str, lambda: now[0])
        for now[0], share, partial in calls:
            progress.tell(share, partial)
        return sent

    def test_no_more_than_a_page_can_show(self):
        sent = self.told([(0.01 * k, k / 1000, k) for k in range(1000)])
        for kind, period in (("share", SHARE_EVERY), ("figure", FIGURE_EVERY)):
            times = [time for time, what, _ in sent if what == kind]
            assert np.diff(times).min() > period - 1e-9 and len(times) >= 10 / (period + 0.011)

    def test_a_figure_that_came_too_soon_is_drawn_later_unless_a_newer_one_comes(self):
        sent = self.told([(0.0, 0.0, "a"), (0.05, 0.1, "b"), (0.1, 0.2, "c"), (0.4, 0.3, None), (0.9, 0.4, None)])
        assert [(time, what) for time, kind, what in sent if kind == "figure"] == [(0.0, "a"), (0.4, "c")]

    def test_all_that_is_done_is_drawn_once_at_the_end(self):
        sent = self.told([(0.0, 0.5, "half"), (9.0, 1.0, "all")])
        assert [what for _, kind, what in sent if kind == "figure"] == ["half"] and sent[-1][1:] == ("share", 1.0)
