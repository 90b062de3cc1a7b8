"""A study has the same digits wherever its runs are made, in whatever order, and however often it was interrupted."""

import importlib
import json
import math
import sys
from contextlib import contextmanager, nullcontext

import numpy as np
import pytest
from numpy.typing import NDArray
from waiting import wait_until

from viewimit.experiments import executors
from viewimit.experiments.bench import calibration, compare, robustness, scenes, success, tracking
from viewimit.experiments.bench.benchmark import Context
from viewimit.experiments.executors import Cluster, Done, LocalPool, Study, StudyError, StudyFile
from viewimit.servo import SERVOS, ServoStatus

WHAT = {"command": "bench", "seed": 3}
TASKS = [(k,) for k in range(7)]


def tenth(k: int) -> list[float]:
    return [k / 10, -k / 3]


RESULTS = [tenth(k) for k in range(7)]


class Failing:
    """`tenth`, but it is interrupted after so many calls."""

    def __init__(self, until):
        self.left = until

    def __call__(self, k: int) -> list[float]:
        if self.left == 0:
            raise KeyboardInterrupt
        self.left -= 1
        return tenth(k)


def kept_at(path):
    return StudyFile(path, WHAT)


def test_an_interrupted_study_goes_on_where_it_was(tmp_path):
    path = tmp_path / "kept"
    begun = Study(LocalPool(1), kept_at(path))
    with pytest.raises(KeyboardInterrupt):
        list(begun.each(Failing(3), TASKS))
    path.write_bytes(path.read_bytes() + b"\7\0\0\0half a batch")
    goes_on = Study(LocalPool(1), kept_at(path))
    assert list(goes_on.each(tenth, TASKS)) == RESULTS
    assert (goes_on.runs, goes_on.kept) == (14, 6)  # a list of two counts as two runs
    assert list(goes_on.each(tenth, TASKS[:2])) == RESULTS[:2]  # its next stage is another
    again = Study(LocalPool(1), kept_at(path))
    assert list(again.each(tenth, TASKS)) == RESULTS and again.kept == 14
    assert again.cpu_s == pytest.approx(goes_on.cpu_s, abs=0.01)


def test_batches_depend_on_the_number_of_tasks_alone_and_hold_them_all():
    for count in (0, 1, 999, 1000, 2500, 250_000):
        batches = executors.in_batches(range(count))
        assert [task for batch in batches for task in batch] == list(range(count))
        assert all(len(batch) <= 100 for batch in batches) and len(batches) < 2600


@pytest.mark.parametrize("at", [-1, -20, 60])
def test_what_is_damaged_is_made_again_and_what_stands_before_it_is_kept(tmp_path, at):
    path = tmp_path / "kept"
    assert list(Study(LocalPool(1), kept_at(path)).each(tenth, TASKS)) == RESULTS
    content = bytearray(path.read_bytes())
    content[at] ^= 1
    path.write_bytes(content)
    again = Study(LocalPool(1), kept_at(path))
    assert list(again.each(tenth, TASKS)) == RESULTS and again.kept < 14


def test_another_study_is_refused_in_a_line_that_says_what_differs(tmp_path):
    path = tmp_path / "kept"
    StudyFile(path, WHAT)
    with pytest.raises(StudyError, match="kept: holds another study, seed 3 and not 4: take another file"):
        StudyFile(path, {**WHAT, "seed": 4})
    path.write_text("frame,x,y\n")
    with pytest.raises(StudyError, match="holds no study: take another file"):
        StudyFile(path, WHAT)
    assert path.read_text() == "frame,x,y\n"
    with pytest.raises(StudyError, match=str(tmp_path)):
        StudyFile(tmp_path, WHAT)


def array() -> NDArray:
    return np.array([[0.1, np.nan], [-np.inf, 1 / 3]])


RESULTS_OF = {
    success.run_pair: [success.Run(3, True, {"own_minimum": 0.1}, {"own_minimum": 1 / 3}, math.nan)],
    calibration.run_once: calibration.Ending(ServoStatus.UNOBSERVABLE, 4, True, 1e-17, math.inf),
    robustness.run_once: (0.1, 2 / 3, 7, False),
    tracking.run_once: array(),
    scenes.run_scene: [scenes.Run(array()[0], array()[1], array()[0], array()[1], 5, np.bool_(True), np.float64(0.7))],
    compare.run_draw: [compare.Row("a", 3, "kalman", 9, ServoStatus.SETTLED, 0.1 + 0.2, math.nan, 5e-324)],
}


def test_what_a_run_finds_is_read_back_to_the_last_bit(tmp_path):
    plain = lambda found: repr(found).replace("np.True_", "True").replace("np.float64(0.7)", "0.7")
    for stage, (work, found) in enumerate(RESULTS_OF.items()):
        StudyFile(tmp_path / "kept", WHAT).keep(stage, 0, Done([found, found], 0.25))
        back = StudyFile(tmp_path / "kept", WHAT).read(stage, 0, work)
        assert back.cpu_s == 0.25 and [plain(one) for one in back.results] == [plain(found)] * 2, work
        for a, b in zip(np.ravel(found), np.ravel(back.results[0])):
            assert type(a) is type(b) and (a != a or not isinstance(a, float) or a == b), work


CASES = compare.CASES[:1]


def rows(workers, settings=None, servos=("broyden", "kalman"), runs=6, progress=None):
    settings = settings or compare.Settings.paper(transfer="projective")
    context = Context(Study(workers), progress) if progress else Context(Study(workers))
    return compare.run(settings, list(servos), runs, 2, 30, CASES, context)


@pytest.fixture
def dask(monkeypatch):
    """Makes clusters on this machine, which end with the test."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(executors, "CONNECT_S", 20.0)
    begun = []

    def begin(workers, processes=False, **more):
        more |= {"threads_per_worker": 1, "dashboard_address": ":0", "silence_logs": 50}
        begun.append(distributed.LocalCluster(n_workers=workers, processes=processes, **more))
        return begun[-1]

    yield begin
    for one in begun:
        one.close()


def test_processes_and_a_cluster_that_loses_a_worker_find_the_same_digits(dask):
    one, lost = dask(2), []

    def tell(share):
        if not lost:
            lost.append(one.sync(one.workers[0].close) or True)

    found = rows(Cluster(one.scheduler_address), progress=lambda name: nullcontext(tell))
    assert lost and repr(found) == repr(rows(LocalPool(2))) == repr(rows(LocalPool(1)))  # every digit, and NaN as NaN


def test_a_cluster_that_cannot_be_used_is_said_in_a_line(dask, monkeypatch):
    monkeypatch.setattr(executors, "CONNECT_S", 0.3)
    for address in ("tcp://127.0.0.1:9", "nonsense://x"):
        with pytest.raises(StudyError, match=f"{address}: no Dask scheduler answers"):
            rows(Cluster(address))
    one = dask(0)
    with pytest.raises(StudyError, match=f"no workers; start some: dask worker {one.scheduler_address}"):
        rows(Cluster(one.scheduler_address))
    monkeypatch.setattr(executors, "CONNECT_S", 20.0)
    one.scale(1)
    wait_until(lambda: len(one.scheduler_info["workers"]) == 1)
    versions, real = iter(["viewimit 0 (0), numpy 0"]), executors.code_version()  # of the study, of the workers
    monkeypatch.setattr(executors, "code_version", lambda: next(versions, real))
    with pytest.raises(StudyError, match="has viewimit .* and the study is of viewimit 0 .*: install the same there"):
        rows(Cluster(one.scheduler_address))
    monkeypatch.setattr(executors.importlib.util, "find_spec", lambda name: None)
    with pytest.raises(StudyError, match=r"needs dask.distributed: pip install 'viewimit\[cluster\]'"):
        rows(Cluster(one.scheduler_address))


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


def rows_of_mine(workers):
    settings = compare.Settings.paper(transfer="projective", servo="mine")  # workers lack it when they load the tasks
    return rows(workers, settings, ["mine"], 2)


def test_a_worker_that_lacks_a_servo_says_so_with_the_remedy(dask, own_servo):
    for workers in (Cluster(dask(1, True).scheduler_address), LocalPool(2)):
        with pytest.raises(StudyError, match="a worker of the study has no servo 'mine'; .* --preload FILE"):
            rows_of_mine(workers)
    with_file = Cluster(dask(1, True, preload=[str(own_servo)]).scheduler_address)
    assert repr(rows_of_mine(with_file)) == repr(rows_of_mine(LocalPool(1)))


def test_a_study_of_a_servo_that_was_edited_is_refused(own_servo, ask, monkeypatch, tmp_path):
    monkeypatch.setattr(compare.CompareBenchmark, "cases", CASES)
    monkeypatch.setattr(executors.os, "cpu_count", lambda: 1)
    words = "bench", "compare", "--servo", "mine", "--runs", 1, "--max-motions", 3, "--out", tmp_path / "kept"
    assert ask(*words)[0] == 0
    own_servo.write_text(OWN_SERVO + "# edited")
    status, _, err = ask(*words)
    assert status == 2 and "holds another study, methods {'servo mine': " in err


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
    status, again, err = ask(*BENCH, "--out", tmp_path / "kept", "--csv", tmp_path / "runs.csv")
    assert status == 0 and "4 runs, 4 of them kept before" in err
    told = [json.loads(words)["compare"] for words in (plain, first, again)]
    assert told[0] == told[1] == told[2]
    status, out, err = ask(*BENCH, "--seed", 1, "--out", tmp_path / "kept")
    assert (status, out) == (2, "") and "holds another study, seed 0 and not 1" in err and err.count("\n") == 1
    status, out, _ = ask("bench", "compare", tmp_path / "runs.csv", "--json")
    assert status == 0 and json.loads(out)["compare"] == told[0]


def test_the_command_says_how_an_interrupted_study_goes_on(ask, tmp_path, monkeypatch):
    @contextmanager
    def interrupted(self, batches):
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(LocalPool, "open", interrupted)
    status, out, err = ask(*BENCH, "--out", tmp_path / "kept")
    assert (status, out) == (130, "") and "kept keeps finished runs, and the same command goes on" in err


@pytest.mark.parametrize(
    "words, message",
    [
        (("speed", "--out", "x"), "bench speed: unrecognized arguments: --out x; see viewimit bench speed --help"),
        (("calibration", "x"), "bench calibration: unrecognized arguments: x"),
        (("compare", "/no/such.csv"), "PATH: /no/such.csv: No such file"),
        (("compare", __file__), "is no table of runs that --csv has written"),
        (("compare", __file__, "--out", "x"), "--cluster, --out: the runs of PATH are made already"),
    ],
)
def test_options_that_a_benchmark_does_not_have_are_refused(ask, words, message):
    status, out, err = ask("bench", *words)
    assert (status, out) == (2, "") and message in err and err.count("\n") == 1
