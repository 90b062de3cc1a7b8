"""A study has the same digits wherever its runs are made, in whatever order, and however often it was interrupted."""

import hashlib
import importlib
import json
import math
import os
import signal
import sys
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from waiting import wait_until

from viewimit.estimation.transfers import TRANSFERS
from viewimit.estimation.transfers.registry import transfer_method
from viewimit.experiments import executors
from viewimit.experiments.bench import calibration, compare, robustness, scenes, success, tracking
from viewimit.experiments.bench.benchmark import Context
from viewimit.experiments.executors import Cluster, Done, LocalPool, Study, StudyError, StudyFolder, carry_out
from viewimit.servo import SERVOS, ServoStatus

WHAT = {"command": "bench", "seed": 3}
TASKS = [(k,) for k in range(7)]


def tenth(k: int) -> list[float]:
    return [k / 10, -k / 3]


RESULTS = [tenth(k) for k in range(7)]


@dataclass
class Backwards:
    """Makes the last batch first, in this process, and is interrupted after so many."""

    until: int | None = None
    made: int = 0

    def run(self, work, batches):
        for number, batch in reversed(batches):
            if self.made == self.until:
                raise KeyboardInterrupt
            self.made += 1
            yield number, carry_out(work, batch)


def test_results_come_in_the_order_of_the_tasks_whatever_the_executor():
    by = Study(Backwards())
    assert list(by.each(tenth, TASKS)) == RESULTS == list(Study(LocalPool(1)).each(tenth, TASKS))
    assert by.runs == 14 and by.kept == 0 and by.cpu_s >= 0  # a list of two counts as two runs
    assert list(Study(LocalPool(1)).each(tenth, [])) == []


def test_batches_depend_on_the_number_of_tasks_alone_and_hold_them_all():
    for count in (1, 999, 1000, 2500, 250_000):
        batches = executors.in_batches(range(count))
        assert [number for number, _ in batches] == list(range(len(batches)))
        assert [task for _, batch in batches for task in batch] == list(range(count))
        assert all(len(batch) <= 100 for _, batch in batches) and len(batches) < 2600


def test_what_is_done_is_kept_and_an_interrupted_study_goes_on(tmp_path):
    begun = Study(Backwards(until=3), StudyFolder(tmp_path / "kept", WHAT))
    with pytest.raises(KeyboardInterrupt):
        list(begun.each(tenth, TASKS))
    rest = Backwards()
    goes_on = Study(rest, StudyFolder(tmp_path / "kept", WHAT))
    assert list(goes_on.each(tenth, TASKS)) == RESULTS
    assert (rest.made, goes_on.runs, goes_on.kept) == (4, 14, 6)
    assert list(goes_on.each(tenth, TASKS[:2])) == RESULTS[:2] and rest.made == 6  # its next stage is another
    done = Study(Backwards(until=0), StudyFolder(tmp_path / "kept", WHAT))
    assert list(done.each(tenth, TASKS)) == RESULTS and done.cpu_s == pytest.approx(goes_on.cpu_s, abs=0.01)


@pytest.mark.parametrize("spoil", ["cut", "empty", "turned", "taken from another"])
def test_a_batch_that_cannot_be_read_is_made_anew(spoil, tmp_path):
    kept, other = tmp_path / "kept", tmp_path / "other"
    for folder, what in ((kept, WHAT), (other, {**WHAT, "seed": 4})):
        list(Study(LocalPool(1), StudyFolder(folder, what)).each(tenth, TASKS))
    path = sorted(kept.glob("*.batch"))[2]
    content = path.read_bytes()
    path.write_bytes(
        {
            "cut": content[:-5],
            "empty": b"",
            "turned": content[:-9] + bytes([content[-9] ^ 1]) + content[-8:],
            "taken from another": (other / path.name).read_bytes(),
        }[spoil]
    )
    again = Backwards()
    assert list(Study(again, StudyFolder(kept, WHAT)).each(tenth, TASKS)) == RESULTS
    assert again.made == 1 and not list(kept.glob("*.part"))


def test_another_study_is_refused_in_a_line_that_says_what_differs(tmp_path):
    StudyFolder(tmp_path / "kept", WHAT)
    with pytest.raises(StudyError, match="kept: holds another study, seed 3 and not 4: take another folder"):
        StudyFolder(tmp_path / "kept", {**WHAT, "seed": 4})
    (tmp_path / "kept" / "study.json").write_text("[")
    with pytest.raises(StudyError, match="is not readable: take another folder"):
        StudyFolder(tmp_path / "kept", WHAT)
    with pytest.raises(StudyError, match="is not empty and holds no study"):
        StudyFolder(tmp_path, WHAT)
    (tmp_path / "file").touch()
    with pytest.raises(StudyError, match="file"):
        StudyFolder(tmp_path / "file", WHAT)


def array() -> NDArray:
    return np.array([[0.1, np.nan], [-np.inf, 1 / 3]])


RESULTS_OF = {
    success.run_pair: [success.Run(3, True, {"own_minimum": 0.1}, {"own_minimum": 1 / 3}, math.nan)],
    calibration.run_once: calibration.Ending(ServoStatus.UNOBSERVABLE, 4, True, 1e-17, math.inf),
    robustness.run_once: (0.1, 2 / 3, 7, False),
    tracking.run_once: array(),
    scenes.run_scene: [scenes.Run(array()[0], array()[1], array()[0], 5, np.bool_(True), np.float64(0.7))],
    compare.run_draw: [compare.Row("a", 3, "kalman", 9, ServoStatus.SETTLED, 0.1 + 0.2, math.nan, 5e-324)],
}


@pytest.mark.parametrize("work", RESULTS_OF, ids=lambda work: work.__module__.rpartition(".")[2])
def test_what_a_run_finds_is_read_back_to_the_last_bit(work, tmp_path):
    folder, found = StudyFolder(tmp_path, WHAT), RESULTS_OF[work]
    folder.keep(0, 0, Done([found, found], 0.25))
    back = folder.read(0, 0, work)
    assert back.cpu_s == 0.25 and len(back.results) == 2
    assert repr(back.results[1]).replace("np.True_", "True").replace("np.float64(0.7)", "0.7") == repr(found).replace(
        "np.True_", "True"
    ).replace("np.float64(0.7)", "0.7")
    for a, b in zip(np.ravel(found), np.ravel(back.results[0])):
        assert type(a) is type(b) and (a != a or not isinstance(a, float) or a == b)


CASES = compare.CASES[:1]


def rows(study):
    return compare.run(
        compare.Settings.paper(transfer="projective"), ["broyden", "kalman"], 6, 2, 30, CASES, Context(study)
    )


@pytest.fixture
def dask(monkeypatch):
    """Makes clusters on this machine, which end with the test."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(executors, "CONNECT_S", 20.0)
    begun = []

    def begin(workers, processes=False, **more):
        begun.append(
            distributed.LocalCluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=processes,
                dashboard_address=":0",
                silence_logs=50,
                **more,
            )
        )
        return begun[-1]

    yield begin
    for one in begun:
        one.close()


def loses_a_worker(dask, processes, lose):
    one = dask(2, processes)
    lost = []

    def tell(share):
        if not lost:
            lost.append(lose(one))

    settings = compare.Settings.paper(transfer="projective")
    by = Study(Cluster(one.scheduler_address))
    found = compare.run(settings, ["broyden", "kalman"], 6, 2, 30, CASES, Context(by, lambda name: nullcontext(tell)))
    assert lost and repr(found) == repr(rows(Study(LocalPool(1))))  # every digit, and NaN as NaN
    assert by.runs == 12 and by.cpu_s > 0


def test_a_cluster_that_loses_a_worker_midway_finds_the_same_digits(dask):
    """In this process. With processes of their own, one of them killed, below."""
    loses_a_worker(dask, False, lambda one: one.sync(one.workers[0].close) or True)


@pytest.mark.slow
def test_a_cluster_of_processes_one_of_which_is_killed_midway_finds_the_same_digits(dask):
    def kill(one):
        os.kill(one.workers[0].pid, signal.SIGKILL)
        return True

    loses_a_worker(dask, True, kill)


def test_a_cluster_that_cannot_be_used_is_said_in_a_line(dask, monkeypatch):
    monkeypatch.setattr(executors, "CONNECT_S", 0.3)
    with pytest.raises(StudyError, match=r"tcp://127.0.0.1:9: no Dask scheduler answers"):
        rows(Study(Cluster("tcp://127.0.0.1:9")))
    with pytest.raises(StudyError, match=r"nonsense://x: no Dask scheduler answers"):
        rows(Study(Cluster("nonsense://x")))
    one = dask(0)
    with pytest.raises(StudyError, match=f"no workers; start some: dask worker {one.scheduler_address}"):
        rows(Study(Cluster(one.scheduler_address)))
    monkeypatch.setattr(executors, "CONNECT_S", 20.0)
    one.scale(1)
    wait_until(lambda: len(one.scheduler_info["workers"]) == 1)
    versions, real = iter(["viewimit 0 (0), numpy 0"]), executors.code_version()  # of the study, of the workers
    monkeypatch.setattr(executors, "code_version", lambda: next(versions, real))
    with pytest.raises(StudyError, match="has viewimit .* and the study is of viewimit 0 .*: install the same there"):
        rows(Study(Cluster(one.scheduler_address)))
    monkeypatch.setattr(executors.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(StudyError, match=r"needs dask.distributed: pip install 'viewimit\[cluster\]'"):
        rows(Study(Cluster(one.scheduler_address)))


OWN_SERVO = """
from viewimit import SERVOS
from viewimit.servo import Broyden

class Mine(Broyden):
    pass

SERVOS["mine"] = Mine()
"""


@pytest.fixture
def own_servo(tmp_path, monkeypatch):
    """A file that assigns a servo `mine`, imported here."""
    path = tmp_path / "my_servo.py"
    path.write_text(OWN_SERVO)
    monkeypatch.syspath_prepend(str(tmp_path))
    importlib.import_module("my_servo")
    yield path
    del SERVOS["mine"], sys.modules["my_servo"]


def rows_of_mine(executor):
    settings = compare.Settings.paper(transfer="projective", servo="mine")  # workers lack it when they load the tasks
    return compare.run(settings, ["mine"], 2, 2, 30, CASES, Context(Study(executor)))


def test_a_worker_that_lacks_a_servo_is_named_with_the_remedy_that_helps(dask, own_servo):
    one = dask(1, True)
    with pytest.raises(StudyError) as refused:
        rows_of_mine(Cluster(one.scheduler_address))
    (worker,) = one.scheduler_info["workers"]
    assert str(refused.value).startswith(f"the worker {worker} has no servo 'mine'; there are gradient, ")
    assert str(refused.value).endswith(
        "start it with --preload FILE, the .py file that assigns it to SERVOS or TRANSFERS"
    )
    other = dask(1, True, preload=[str(own_servo)])
    assert repr(rows_of_mine(Cluster(other.scheduler_address))) == repr(rows_of_mine(LocalPool(1)))


def test_a_worker_with_another_servo_of_that_name_is_refused(dask, own_servo, monkeypatch):
    hashes, real = iter([{"servo mine": "elsewhere"}]), executors.own_methods()
    assert list(real) == ["servo mine"]  # the library's own are not listed
    monkeypatch.setattr(executors, "own_methods", lambda: next(hashes, real))
    with pytest.raises(StudyError, match="the worker .* has another servo mine, of another file: start it again"):
        rows_of_mine(Cluster(dask(1).scheduler_address))


def test_processes_of_this_machine_that_lack_a_servo_are_reported(own_servo):
    with pytest.raises(StudyError, match="a process of the study has no servo 'mine'; .* above `if __name__"):
        rows_of_mine(LocalPool(2))


def test_a_worker_that_lacks_a_function_of_the_study_is_named(dask, own_servo):
    one, work = dask(1, True), sys.modules["my_servo"].Mine
    own_servo.unlink()
    with pytest.raises(StudyError, match="the worker tcp://.* lacks what the study needs .*my_servo.*: install it"):
        list(Study(Cluster(one.scheduler_address)).each(work, [()]))


def test_a_study_of_a_servo_that_was_edited_is_refused(own_servo, ask, monkeypatch, tmp_path):
    monkeypatch.setattr(compare.CompareBenchmark, "cases", CASES)
    monkeypatch.setattr(executors.os, "cpu_count", lambda: 1)
    words = "bench", "compare", "--servo", "mine", "--runs", 1, "--max-motions", 3, "--out", tmp_path / "kept"
    assert ask(*words)[0] == 0
    own_servo.write_text(OWN_SERVO + "# edited")
    status, _, err = ask(*words)
    assert status == 2 and "holds another study, methods {'servo mine': " in err


def test_a_transfer_of_ones_own_has_the_hash_of_its_file(own_servo, monkeypatch):
    monkeypatch.setitem(TRANSFERS, "mine", transfer_method(sys.modules["my_servo"].Mine().start))
    assert executors.own_methods().keys() == {"servo mine"}  # the function is the library's own
    monkeypatch.setitem(TRANSFERS, "mine", transfer_method(tenth))
    found = executors.own_methods()
    assert found["transfer mine"] == hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:12]


def test_the_fingerprint_is_of_code_that_changes_results(tmp_path, monkeypatch):
    for room in ("servo", "drawing"):
        (tmp_path / room).mkdir()
        (tmp_path / room / "a.py").write_text("1")
    monkeypatch.setattr(executors, "LIBRARY", tmp_path)
    first = executors.code_version.__wrapped__()
    (tmp_path / "drawing" / "a.py").write_text("2")
    assert executors.code_version.__wrapped__() == first and np.__version__ in first
    (tmp_path / "servo" / "a.py").write_text("2")
    assert executors.code_version.__wrapped__() != first


BENCH = "bench", "compare", "--runs", 2, "--max-motions", 4, "--servo", "broyden", "--json"


def test_the_command_keeps_goes_on_and_refuses_another_study(ask, tmp_path, monkeypatch):
    monkeypatch.setattr(compare.CompareBenchmark, "cases", CASES)
    monkeypatch.setattr(executors.os, "cpu_count", lambda: 1)
    status, plain, _ = ask(*BENCH)
    status, first, err = ask(*BENCH, "--out", tmp_path / "kept")
    assert status == 0 and "4 runs: " in err and "ms a run; 1,000,000 such runs need" in err
    monkeypatch.setattr(executors, "carry_out", None)  # nothing is left to do
    status, again, err = ask(*BENCH, "--out", tmp_path / "kept", "--csv", tmp_path / "runs.csv")
    assert status == 0 and "4 runs, 4 of them kept before" in err
    told = [json.loads(words)["compare"] for words in (plain, first, again)]
    assert told[0] == told[1] == told[2]
    status, out, err = ask(*BENCH, "--seed", 1, "--out", tmp_path / "kept")
    assert (status, out) == (2, "") and "holds another study, seed 0 and not 1" in err and err.count("\n") == 1
    status, out, _ = ask("bench", "compare", tmp_path / "runs.csv", "--json")
    assert status == 0 and json.loads(out)["compare"] == told[0]


def test_the_command_says_how_an_interrupted_study_goes_on(ask, tmp_path, monkeypatch):
    monkeypatch.setattr(LocalPool, "run", Backwards(until=0).run)
    status, out, err = ask(*BENCH, "--out", tmp_path / "kept")
    assert (status, out) == (130, "") and "kept keeps finished runs, and the same command goes on" in err


@pytest.mark.parametrize(
    "words, message",
    [
        (("speed", "--out", "x"), "bench speed: unrecognized arguments: --out x; see viewimit bench speed --help"),
        (("all", "--cluster", "x"), "bench all: unrecognized arguments: --cluster x"),
        (("calibration", "--csv", "x"), "bench calibration: unrecognized arguments: --csv x"),
        (("calibration", "x"), "bench calibration: unrecognized arguments: x"),
        (("calibration", "--scene", "iiwa"), "bench calibration: unrecognized arguments: --scene iiwa"),
        (("tracking", "--servo", "broyden"), "bench tracking: unrecognized arguments: --servo broyden"),
        (("compare", "/no/such.csv"), "PATH: /no/such.csv: No such file"),
        (("compare", __file__), "is no table of runs that --csv has written"),
        (("compare", __file__, "--out", "x"), "--cluster, --out: the runs of PATH are made already"),
    ],
)
def test_options_that_a_benchmark_does_not_have_are_refused(ask, words, message):
    status, out, err = ask("bench", *words)
    assert (status, out) == (2, "") and message in err and err.count("\n") == 1
