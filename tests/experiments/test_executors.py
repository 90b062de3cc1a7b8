"""A study has the same digits wherever its runs are made, in whatever order, and however often it was interrupted."""

import contextlib
import os
import signal
import subprocess
import sys

import pytest
from waiting import wait_until

from viewimit.experiments import executors
from viewimit.experiments.bench import engine
from viewimit.experiments.bench.cases import ROBUSTNESS
from viewimit.experiments.executors import Study, StudyError, StudyFile

WHAT = {"command": "bench", "seed": 3}
METHODS = [("projective", "broyden"), ("projective", "kalman")]


def runs(study, progress=lambda share: None, count=6):
    how = {"methods": METHODS, "runs": count, "seed": 2, "max_motions": 30, "progress": progress}
    made = engine.run_cases(ROBUSTNESS, ROBUSTNESS.cases[:1], study, **how)
    return repr([engine.replace(run, cpu_s=0.0) for run in made])  # every digit, and NaN as NaN


def test_an_interrupted_study_goes_on_where_it_was_in_processes_and_finds_the_same_digits(tmp_path):
    path, expected = tmp_path / "kept", runs(Study())

    def interrupt(share):
        if share > 0.3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        runs(Study(file=StudyFile(path, WHAT)), interrupt)
    with path.open("a") as file:
        file.write('[11, {"case": "half a ru')
    goes_on = Study(2, file=StudyFile(path, WHAT))
    assert runs(goes_on) == expected and (goes_on.runs, goes_on.kept) == (12, 4)
    again = Study(file=StudyFile(path, WHAT))
    assert runs(again) == expected and again.kept == 12 and again.cpu_s == pytest.approx(goes_on.cpu_s)


def test_another_study_is_refused_in_a_line_that_says_what_differs(tmp_path):
    path = tmp_path / "kept"
    StudyFile(path, WHAT)
    with pytest.raises(StudyError, match="kept: holds another study, seed 3 and not 4: take another file"):
        StudyFile(path, {**WHAT, "seed": 4})
    for content in ("frame,x,y\n", "no line"):
        path.write_text(content)
        with pytest.raises(StudyError, match="holds no study: take another file"):
            StudyFile(path, WHAT)
        assert path.read_text() == content
    with pytest.raises(StudyError, match=str(tmp_path)):
        StudyFile(tmp_path, WHAT)


@pytest.fixture
def dask(monkeypatch):
    """Makes clusters on this machine, which end with the test."""
    distributed = pytest.importorskip("distributed")
    with contextlib.ExitStack() as stack:
        yield lambda workers: stack.enter_context(
            distributed.LocalCluster(n_workers=workers, threads_per_worker=1, processes=False, dashboard_address=":0",
                                     silence_logs=50)
        )  # fmt: skip


def test_a_cluster_goes_on_with_an_interrupted_study_and_without_a_worker_that_it_loses(dask, tmp_path):
    one, lost, expected = dask(2), [], runs(Study())

    def interrupt(share):
        if share > 0.6:
            raise KeyboardInterrupt

    def lose(share):
        if not lost:
            lost.append(one.sync(one.workers[0].close) or True)

    with pytest.raises(KeyboardInterrupt):
        runs(Study(dask=one.scheduler_address, file=StudyFile(tmp_path / "kept", WHAT)), interrupt)
    goes_on = Study(dask=one.scheduler_address, file=StudyFile(tmp_path / "kept", WHAT))
    assert runs(goes_on) == expected and goes_on.kept >= 7
    assert runs(Study(dask=one.scheduler_address), lose) == expected and lost


def test_a_cluster_that_cannot_be_used_is_said_in_a_line(dask, monkeypatch):
    monkeypatch.setattr(executors, "CONNECT_S", 0.3)
    for address in ("tcp://127.0.0.1:9", "nonsense://x"):
        with pytest.raises(StudyError, match=f"{address}: no Dask scheduler answers"):
            runs(Study(dask=address))
    one = dask(0)
    with pytest.raises(
        StudyError, match=f"that scheduler has no workers; start some: dask worker {one.scheduler_address}"
    ):
        runs(Study(dask=one.scheduler_address))
    monkeypatch.setattr(executors.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(StudyError, match=r"pip install 'viewimit\[cluster\]'"):
        runs(Study(dask="tcp://127.0.0.1:9"))


def test_a_worker_with_other_code_is_refused():
    with pytest.raises(StudyError, match="the study is of viewimit 0.0: install the same there"):
        executors.carry_out_elsewhere(b"", "viewimit 0.0")


def test_the_command_keeps_goes_on_and_refuses_another_study(ask, tmp_path):
    words = "bench", "success", "--servo", "kalman", "--transfer", "linear", "--runs", 3, "--out", tmp_path / "kept"
    first, again = ask(*words, "--jobs", 1), ask(*words)
    assert first[:2] == again[:2] and "3 of them kept before" in again[2] and "a run" in first[2]
    status, out, err = ask(*words, "--seed", 1)
    assert (status, out, err.count("\n")) == (2, "", 1) and "holds another study, seed 0 and not 1" in err


BUSY = """
from viewimit.experiments.bench import engine
from viewimit.experiments.bench.cases import SUCCESS
from viewimit.experiments.executors import Study
engine.run_cases(SUCCESS, SUCCESS.cases, Study(2), methods=[("linear", "gradient")], runs=5000,
                 progress=lambda share: print(share, flush=True))
"""


@pytest.mark.skipif(sys.platform == "win32", reason="groups of processes")
@pytest.mark.parametrize("ends", [signal.SIGINT, signal.SIGKILL])
def test_processes_end_with_the_one_that_they_work_for(ends):
    command = [sys.executable, "-I", "-c", BUSY]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    heed = lambda: signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell ignores it for what runs in the background
    busy = subprocess.Popen(command, start_new_session=True, preexec_fn=heed, **pipes)
    assert busy.stdout.readline() == f"{1 / 5000}\n"
    if ends == signal.SIGINT:
        os.killpg(busy.pid, ends)  # as a terminal does
    else:
        os.kill(busy.pid, ends)
    busy.communicate(timeout=60)
    wait_until(lambda: not group_lives(busy.pid))


def group_lives(group):
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True
