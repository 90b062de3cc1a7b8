"""Experiments in processes of their own: in order, told as they go on, ended at once, never in anybody's way."""

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
from viewimit.app.jobs.experiments import ExperimentWorker, Request
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
    assert shares == sorted(shares) and any(0 < share < 1 for share in shares) and shares[-1] == 1
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


def test_one_at_a_time_in_the_order_asked_and_a_page_that_leaves_makes_room(worker):
    told = {page: Told() for page in (1, 2, 3, 4)}
    finished = []
    worker.ask(1, LONG, told[1])
    pid = running_pid(told[1])
    worker.ask(2, LONG, told[2])
    for page in (3, 4):
        done = lambda run, page=page: (told[page](run), finished.append(page) if run.state == "done" else None)
        worker.ask(page, SHORT, done)
    with pytest.raises(ValueError, match="still runs"):
        worker.ask(1, SHORT, told[1])
    assert len(processes()) == 1
    worker.cancel(2)
    worker.forget(1)
    for page in (3, 4):
        told[page].wait_for("done", "failed")
    assert finished == [3, 4] and ended(pid)
    assert told[1].states == ["waiting", "running"] and told[2].states == ["waiting", "cancelled"]


def test_the_process_is_polite_and_loads_nothing_of_the_page(worker):
    told = Told()
    worker.ask(1, LONG, told)
    pid = running_pid(told)
    if hasattr(os, "getpriority"):
        assert os.getpriority(os.PRIO_PROCESS, pid) >= min(os.getpriority(os.PRIO_PROCESS, 0) + 10, LEAST_PRIORITY)
    modules = {"viewimit.app.jobs.child": {"numpy", "viser"}, "viewimit.experiments": {"viser"}}
    for module, unwanted in modules.items():  # numpy would fix the number of threads before it is set
        command = [sys.executable, "-I", "-c", f"import {module}, sys; print(*sys.modules)"]
        loaded = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
        assert module in loaded and not unwanted & set(loaded)
