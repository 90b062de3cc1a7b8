"""Studies of many independent runs, and the executors that carry them out: processes here, or a Dask cluster.

A study goes to its executor batch by batch, and a folder can keep the finished batches. A script that asks for more
than one local process needs `if __name__ == "__main__":`. On a cluster, the scheduler distributes the batches and
repeats those of lost workers. Each worker needs the same viewimit and numpy, and one thread:
`dask worker ADDRESS --nthreads 1`. Workers need a servo or transfer of your own, too: name the file that assigns it to
SERVOS or TRANSFERS by `--preload FILE`.
"""

import asyncio
import hashlib
import importlib.util
import json
import multiprocessing
import os
import pickle
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import GenericAlias
from typing import Any, Protocol, get_type_hints

import msgspec
import numpy as np
import zstandard

from .. import __version__
from ..assets import ROOT
from ..estimation.transfers import TRANSFERS
from ..loop.settings import UnknownMethod
from ..processes import end_with_parent, ignore_interrupts, interrupts_withheld
from ..servo import SERVOS

Batch = Sequence[tuple[Any, ...]]  # of tasks, each the arguments of one call

QUEUED_BATCHES = 2  # for each process, so that it never waits for the next


class StudyError(Exception):
    """A study cannot be begun or go on; the message says why, where and what to do, in a line."""


@dataclass(frozen=True)
class Done:
    """A finished batch."""

    results: list[Any]  # one for each task, in order
    cpu_s: float  # CPU time of the whole batch on one core


class Executor(Protocol):
    """Carries out the tasks of a study."""

    def run(self, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        """Call work(*task) for every task.

        Parameters
        ----------
        work : callable
            Carries out one task. Its exception ends the study.
        batches : sequence of (int, sequence of tuple)
            Tasks, in numbered batches.

        Yields
        ------
        (int, Done)
            Each batch with its number when it is done, in any order.

        Raises
        ------
        StudyError
            If the batches cannot be run.
        """
        ...


def carry_out(work: Callable[..., Any], batch: Batch) -> Done:
    """Call work(*task) for every task, in this process."""
    began = time.thread_time()
    results = [work(*task) for task in batch]
    return Done(results, time.thread_time() - began)


def _carry_out_packed(packed: bytes) -> Done:
    """Carry out a pickled (work, batch) in another process. Raises ImportError if this process lacks the work."""
    try:
        work, batch = pickle.loads(packed)
    except AttributeError as error:  # a function that its module does not have here
        raise ImportError(str(error)) from None
    return carry_out(work, batch)


@dataclass(frozen=True)
class LocalPool:
    """Executor that uses processes on this machine."""

    processes: int | None = None  # None: as many as processors; 1: this process

    def run(self, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        """See `Executor.run`."""
        workers = min(self.processes or os.cpu_count() or 1, len(batches))
        if workers <= 1:
            yield from ((number, carry_out(work, batch)) for number, batch in batches)
            return
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _start_worker)
        try:
            left, running = iter(batches), dict[Future, int]()
            while True:
                for number, batch in left:
                    with interrupts_withheld():
                        running[pool.submit(_carry_out_packed, pickle.dumps((work, batch)))] = number
                    if len(running) >= (1 + QUEUED_BATCHES) * workers:
                        break
                if not running:
                    break
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    yield running.pop(future), _result(future)
        except BaseException:  # nothing is cancelled: the pool would fail on that when its workers end
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise
        finally:
            pool.shutdown()


def _result(future: Future) -> Done:
    try:
        return future.result()
    except UnknownMethod as error:
        advice = 'assign it in your script above `if __name__ == "__main__":`'
        raise StudyError(f"a process of the study has {error}: {advice}") from None


def _start_worker() -> None:
    ignore_interrupts()
    end_with_parent()


CONNECT_S = 30.0  # time to find a scheduler, and then to find its first worker
MAX_RESUBMISSIONS = 3  # of a batch that the scheduler has given up, each after 4 lost workers
LIBRARY = Path(__file__).parents[1]
WITHOUT_EFFECT = {"app", "assets", "commands", "drawing"}  # packages that change no digit of a result
PRELOAD = "start it with --preload FILE, the .py file that assigns it to SERVOS or TRANSFERS"


class UnfitWorker(Exception):
    """A worker cannot make the runs of a study; the message says which worker, why, and what to do."""


@cache
def code_version() -> str:
    """Return what the digits of a result depend on, besides its settings: this library's code and numpy's version.

    Such as "viewimit 0.1.0 (3f0c9a81d2b4), numpy 2.1.0", with a hash of the library's sources and scenes.
    """
    found = hashlib.sha256()
    sources = [path for path in LIBRARY.rglob("*.py") if path.relative_to(LIBRARY).parts[0] not in WITHOUT_EFFECT]
    for path in [*sorted(sources), *sorted(ROOT.rglob("*.toml")), *sorted(ROOT.rglob("*.urdf"))]:
        found.update(path.name.encode() + b"\0" + path.read_bytes().replace(b"\r\n", b"\n"))
    return f"viewimit {__version__} ({found.hexdigest()[:12]}), numpy {np.__version__}"


def own_methods() -> dict[str, str]:
    """Return a hash of the file of each servo and transfer that is not of this library, such as {"servo mine": "3f…"}.

    A method that was typed in, without a file, is left out.
    """
    modules = {f"servo {name}": type(method.servo).__module__ for name, method in SERVOS.items()}
    modules |= {f"transfer {name}": method.fit.__module__ for name, method in TRANSFERS.items()}
    found = {}
    for name, module in modules.items():
        file = Path(getattr(sys.modules.get(module), "__file__", None) or "").resolve()
        if file.is_file() and LIBRARY not in file.parents:
            found[name] = hashlib.sha256(file.read_bytes()).hexdigest()[:12]
    return found


@dataclass(frozen=True)
class Cluster:
    """Executor that uses a Dask cluster."""

    address: str  # of its scheduler, such as tcp://10.0.0.1:8786

    def run(self, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        """See `Executor.run`."""
        if not batches:
            return
        if importlib.util.find_spec("distributed") is None:
            raise StudyError(f"{self.address}: a cluster needs dask.distributed: pip install 'viewimit[cluster]'")
        import distributed

        try:
            client = distributed.Client(self.address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise StudyError(f"{self.address}: no Dask scheduler answers ({_line(error)})") from None
        with client:
            try:
                client.wait_for_workers(1, timeout=CONNECT_S)
            except asyncio.TimeoutError:  # another class on Python 3.10
                advice = f"start some: dask worker {self.address} --nthreads 1"
                raise StudyError(f"{self.address}: that scheduler has no workers; {advice}") from None
            yield from _run(client, work, batches)


def _run(client: Any, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
    import distributed

    left, running, lost = iter(batches), dict[Any, tuple[int, bytes]](), dict[int, int]()
    done, version, methods = distributed.as_completed(loop=client.loop), code_version(), own_methods()

    def submit(number: int, packed: bytes) -> None:
        """Pickled, so that Dask does not look for tasks of its own among the tuples."""
        future = client.submit(_carry_out, packed, version, pure=False)
        running[future] = number, packed
        done.add(future)

    def fill() -> None:
        most = (1 + QUEUED_BATCHES) * max(sum(client.nthreads().values()), 1)
        while len(running) < most and (following := next(left, None)) is not None:
            submit(following[0], pickle.dumps((methods, pickle.dumps((work, following[1])))))

    fill()
    for future in done:
        number, packed = running.pop(future)
        try:
            found = future.result()
        except distributed.KilledWorker as error:
            lost[number] = lost.get(number, 0) + 1
            if lost[number] > MAX_RESUBMISSIONS:
                raise StudyError(f"batch {number} loses every worker that takes it: {_line(error)}") from None
            submit(number, packed)
            continue
        except distributed.client.FutureCancelledError as error:
            raise StudyError(f"the scheduler at {client.scheduler.address} is lost: {_line(error)}") from None
        except UnfitWorker as error:
            raise StudyError(_line(error)) from None
        fill()
        yield number, found


def _carry_out(packed: bytes, expected: str) -> Done:
    """Make the runs of a batch, on a worker.

    Other versions of this library have the same two arguments, and so report that their `code_version` is another.
    """
    import distributed

    worker = f"the worker {distributed.get_worker().address}"
    if code_version() != expected:
        raise UnfitWorker(f"{worker} has {code_version()}, and the study is of {expected}: install the same there")
    methods, packed = pickle.loads(packed)
    here = own_methods()
    for name in methods.keys() & here.keys():
        if here[name] != methods[name]:
            raise UnfitWorker(f"{worker} has another {name}, of another file: start it again with the same file")
    try:
        return _carry_out_packed(packed)
    except UnknownMethod as error:
        raise UnfitWorker(f"{worker} has {error}: {PRELOAD}") from None
    except ImportError as error:
        raise UnfitWorker(f"{worker} lacks what the study needs ({error}): install it there, or {PRELOAD}") from None


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


MIN_BATCHES, MAX_BATCH_TASKS = 1000, 100  # of a study, before a batch has more than one task; of a batch
STUDY_FILE = "study.json"


class StudyFolder:
    """A folder that keeps the batches of a study, so that it goes on after an interruption.

    Parameters
    ----------
    folder : Path
        Made if need be.
    study : dict
        Everything that the results depend on, as JSON.

    Raises
    ------
    StudyError
        For a folder that holds another study or other files (the message says what differs), or is not writable.
    """

    def __init__(self, folder: Path, study: dict[str, Any]):
        self.folder, self._key = folder, hashlib.sha256(_json(study)).hexdigest()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            path = folder / STUDY_FILE
            if path.exists():
                _require_same(folder, path.read_bytes(), study)
            elif any(folder.iterdir()):
                raise StudyError(f"{folder}: is not empty and holds no study: take another folder")
            else:
                _write(path, _json(study))
        except OSError as error:
            raise StudyError(f"{folder}: {error.strerror or error}") from None

    def read(self, stage: int, number: int, work: Callable[..., Any]) -> Done | None:
        """Read a batch of `work`; None if it is missing or damaged, as after an interrupted write."""
        try:
            content = zstandard.ZstdDecompressor().decompress(self._path(stage, number).read_bytes())
            key, results, cpu_s = msgspec.msgpack.decode(content, type=tuple[str, msgspec.Raw, float])
            if key != self._batch_key(stage, number):
                return None
            result = get_type_hints(work)["return"]
            return Done(msgspec.msgpack.decode(results, type=GenericAlias(list, result), dec_hook=_array), cpu_s)
        except (OSError, zstandard.ZstdError, msgspec.MsgspecError):
            return None

    def keep(self, stage: int, number: int, done: Done) -> None:
        """Write a batch, all or nothing. Raises StudyError if it cannot be written."""
        results = msgspec.Raw(msgspec.msgpack.encode(done.results, enc_hook=_plain))
        content = msgspec.msgpack.encode((self._batch_key(stage, number), results, done.cpu_s))
        path = self._path(stage, number)
        try:
            _write(path, zstandard.ZstdCompressor(write_checksum=True).compress(content))
        except OSError as error:
            raise StudyError(f"{path}: {error.strerror or error}; finished batches are kept") from None

    def _path(self, stage: int, number: int) -> Path:
        return self.folder / f"{stage:02}-{number:06}.batch"

    def _batch_key(self, stage: int, number: int) -> str:
        """Kept inside the file: it rejects a file that was renamed or comes from another study."""
        return f"{self._key}-{stage}-{number}"


def _require_same(folder: Path, kept: bytes, study: dict[str, Any]) -> None:
    try:
        other = json.loads(kept)
    except ValueError:
        other = None
    if not isinstance(other, dict):
        raise StudyError(f"{folder / STUDY_FILE}: is not readable: take another folder")
    for name in dict.fromkeys([*study, *other]):
        if other.get(name) != json.loads(_json(study)).get(name):
            there, here = other.get(name), study.get(name)
            raise StudyError(f"{folder}: holds another study, {name} {there} and not {here}: take another folder")


def _write(path: Path, content: bytes) -> None:
    """Write atomically."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    with part.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(part, path)


def _json(study: dict[str, Any]) -> bytes:
    return json.dumps(study, indent=1, ensure_ascii=False).encode() + b"\n"


def _plain(value: Any) -> Any:
    """A numpy scalar as Python's, an array as its type, shape and bytes."""
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.shape, value.tobytes()
    raise NotImplementedError(f"cannot keep a {type(value).__name__}")


def _array(kind: Any, kept: Any) -> Any:
    if getattr(kind, "__origin__", kind) is not np.ndarray:
        raise NotImplementedError(f"cannot read a {kind}")
    dtype, shape, content = kept
    return np.frombuffer(content, dtype).reshape(shape)


@dataclass
class Study:
    """Runs tasks on an executor, keeps results in a folder, and counts what they cost."""

    executor: Executor = field(default_factory=LocalPool)
    folder: StudyFolder | None = None
    runs: int = 0  # finished so far; a list of results counts as that many
    kept: int = 0  # of these, read from the folder
    cpu_s: float = 0.0  # CPU time of all runs on one core, wherever and whenever they were made
    _stages: int = 0

    def each(self, work: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """Yield work(*task) for every task, in their order.

        With a folder, the results must be described by the return type that `work` declares.
        """
        stage, self._stages = self._stages, self._stages + 1
        batches = in_batches(tasks)
        there = {number for number, _ in batches if self._read(stage, number, work) is not None}
        found = self.executor.run(work, [batch for batch in batches if batch[0] not in there])
        ready: dict[int, Done] = {}
        for number, _ in batches:
            done = self._read(stage, number, work) if number in there else None
            while done is None and number not in ready:
                new, made = next(found)
                if self.folder is not None:
                    self.folder.keep(stage, new, made)
                ready[new] = made
            done = done or ready.pop(number)
            runs = sum(len(result) if isinstance(result, list) else 1 for result in done.results)
            self.runs, self.cpu_s = self.runs + runs, self.cpu_s + done.cpu_s
            self.kept += runs if number in there else 0
            yield from done.results
        assert next(found, None) is None  # all batches are done; the executor ends its workers

    def _read(self, stage: int, number: int, work: Callable[..., Any]) -> Done | None:
        return None if self.folder is None else self.folder.read(stage, number, work)


def in_batches(tasks: Sequence[tuple[Any, ...]]) -> list[tuple[int, Batch]]:
    """Divide tasks into numbered batches.

    Batches depend on the number of tasks alone, so that any executor goes on with those that another one has kept.
    """
    size = min(max(len(tasks) // MIN_BATCHES, 1), MAX_BATCH_TASKS)
    return [(k, tasks[first : first + size]) for k, first in enumerate(range(0, len(tasks), size))]
