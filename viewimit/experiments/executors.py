"""Studies of many independent runs: in processes here or on a Dask cluster, their results kept in one file.

A script that asks for more than one local process needs `if __name__ == "__main__":`. Each worker of a cluster needs
the same viewimit and numpy, and one thread: `dask worker ADDRESS --nthreads 1`. Workers need a servo or transfer of
your own, too: name the file that assigns it to SERVOS or TRANSFERS by `--preload FILE`.
"""

import contextlib
import hashlib
import importlib.util
import json
import multiprocessing
import os
import pickle
import struct
import sys
import time
import zlib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import GenericAlias
from typing import Any, Protocol, get_type_hints

import msgspec
import numpy as np

from .. import __version__
from ..assets import ROOT
from ..estimation.transfers import TRANSFERS
from ..loop.settings import UnknownMethod
from ..processes import end_with_parent, ignore_interrupts, interrupts_withheld
from ..servo import SERVOS

CONNECT_S = 30.0  # time to find a scheduler, and then to find its first worker
MIN_BATCHES, MAX_BATCH_TASKS = 1000, 100  # of a study, before a batch has more than one task; of a batch
LIBRARY = Path(__file__).parents[1]
WITHOUT_EFFECT = {"app", "assets", "commands", "drawing"}  # packages that change no digit of a result
PRELOAD = "start it with --preload FILE, the .py file that assigns it to SERVOS or TRANSFERS"

Batch = Sequence[tuple[Any, ...]]  # of tasks, each the arguments of one call


class StudyError(Exception):
    """A study cannot be begun or go on; the message says why, where and what to do, in a line."""


@dataclass(frozen=True)
class Done:
    """A finished batch."""

    results: list[Any]  # one for each task, in order
    cpu_s: float  # CPU time of the whole batch on one core


def carry_out(work: Callable[..., Any], batch: Batch) -> Done:
    """Call work(*task) for every task, in this process."""
    began = time.thread_time()
    results = [work(*task) for task in batch]
    return Done(results, time.thread_time() - began)


def carry_out_elsewhere(packed: bytes, code: str, methods: dict[str, str]) -> Done:
    """Carry out a pickled (work, batch) in a worker. Raises StudyError if it lacks or has other code than the study."""
    where = "a worker of the study"
    if code_version() != code:
        raise StudyError(f"{where} has {code_version()}, and the study is of {code}: install the same there")
    here = own_methods()
    for name in methods.keys() & here.keys():
        if here[name] != methods[name]:
            raise StudyError(f"{where} has another {name}, of another file: start it again with the same file")
    try:
        return carry_out(*pickle.loads(packed))
    except UnknownMethod as error:
        raise StudyError(f"{where} has {error}: {PRELOAD}; in a script, assign it above `if __name__`") from None
    except (ImportError, AttributeError) as error:  # the latter: a function that its module does not have there
        raise StudyError(f"{where} lacks what the study needs ({error}): install it there, or {PRELOAD}") from None


class Workers(Protocol):
    """Where the runs of a study are made."""

    def open(self, batches: int) -> contextlib.AbstractContextManager[Executor | None]:
        """Return an executor for so many batches; None: this process. Raises StudyError."""
        ...


@dataclass(frozen=True)
class LocalPool:
    """Processes on this machine."""

    processes: int | None = None  # None: as many as processors; 1: this process

    @contextlib.contextmanager
    def open(self, batches: int) -> Iterator[Executor | None]:
        """See `Workers.open`."""
        workers = min(self.processes or os.cpu_count() or 1, batches)
        if workers <= 1:
            yield None
            return
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(workers, multiprocessing.get_context("spawn"), _start_worker)
        try:
            yield pool
        except BaseException:  # nothing is cancelled: the pool would fail on that when its workers end
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise
        finally:
            pool.shutdown()


def _start_worker() -> None:
    ignore_interrupts()
    end_with_parent()


@dataclass(frozen=True)
class Cluster:
    """A Dask cluster, which repeats what lost workers had taken."""

    address: str  # of its scheduler, such as tcp://10.0.0.1:8786

    @contextlib.contextmanager
    def open(self, batches: int) -> Iterator[Executor | None]:
        """See `Workers.open`."""
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
            except (TimeoutError, distributed.TimeoutError):
                advice = f"start some: dask worker {self.address} --nthreads 1"
                raise StudyError(f"{self.address}: that scheduler has no workers; {advice}") from None
            try:
                yield client.get_executor(pure=False)
            except CancelledError:
                raise StudyError(f"{self.address}: the scheduler is lost") from None
            except distributed.KilledWorker as error:
                raise StudyError(f"a batch loses every worker that takes it: {_line(error)}") from None


def _line(error: Exception) -> str:
    return " ".join(str(error).split()) or type(error).__name__


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


class StudyFile:
    """The file to which the batches of a study are appended, so that it goes on after an interruption.

    The first line says as JSON what the study is. Each batch follows as its length, its checksum and a msgpack of
    (stage, number, results, CPU seconds); a last one that was interrupted is cut off.

    Parameters
    ----------
    path : Path
        Made if need be.
    study : dict
        Everything that the results depend on, as JSON has it.

    Raises
    ------
    StudyError
        For a file that holds something else (the message says what differs), or that cannot be written.
    """

    HEAD = struct.Struct("<II")  # length and CRC-32 of what follows

    def __init__(self, path: Path, study: dict[str, Any]):
        self.path, first = path, json.dumps(study, ensure_ascii=False).encode() + b"\n"
        self._kept: dict[tuple[int, int], bytes] = {}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            content = path.read_bytes() if path.exists() else b""
            if content:
                self._require_same(content.partition(b"\n")[0], json.loads(first))
            else:
                content = first
                path.write_bytes(first)
            end = self._read(content, len(content.partition(b"\n")[0]) + 1)
            os.truncate(path, end)
        except OSError as error:
            raise StudyError(f"{path}: {error.strerror or error}") from None

    def read(self, stage: int, number: int, work: Callable[..., Any]) -> Done | None:
        """Return a batch of `work`, as the type that it declares to return; None if it is not there."""
        packed = self._kept.get((stage, number))
        if packed is None:
            return None
        kind = GenericAlias(list, get_type_hints(work)["return"])
        _, _, results, cpu_s = msgspec.msgpack.decode(packed, type=tuple[int, int, msgspec.Raw, float])
        return Done(msgspec.msgpack.decode(results, type=kind, dec_hook=_array), cpu_s)

    def keep(self, stage: int, number: int, done: Done) -> None:
        """Append a batch. Raises StudyError if it cannot be written."""
        packed = msgspec.msgpack.encode((stage, number, done.results, done.cpu_s), enc_hook=_plain)
        try:
            with self.path.open("ab") as file:
                file.write(self.HEAD.pack(len(packed), zlib.crc32(packed)) + packed)
        except OSError as error:
            raise StudyError(f"{self.path}: {error.strerror or error}; finished batches are kept") from None
        self._kept[stage, number] = packed

    def _read(self, content: bytes, at: int) -> int:
        """Read the batches from there on. Return where the last whole one ends."""
        while at + self.HEAD.size <= len(content):
            length, checksum = self.HEAD.unpack_from(content, at)
            packed = content[at + self.HEAD.size : at + self.HEAD.size + length]
            if len(packed) < length or zlib.crc32(packed) != checksum:
                break
            stage, number, *_ = msgspec.msgpack.decode(packed)
            self._kept[stage, number] = packed
            at += self.HEAD.size + length
        return at

    def _require_same(self, first: bytes, study: dict[str, Any]) -> None:
        try:
            other = json.loads(first)
        except ValueError:
            other = None
        if not isinstance(other, dict):
            raise StudyError(f"{self.path}: holds no study: take another file")
        for name in dict.fromkeys([*study, *other]):
            there, here = other.get(name), study.get(name)
            if there != here:
                raise StudyError(f"{self.path}: holds another study, {name} {there} and not {here}: take another file")


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
    """Runs tasks wherever its workers are, keeps results in a file, and counts what they cost."""

    workers: Workers = field(default_factory=LocalPool)
    file: StudyFile | None = None
    runs: int = 0  # finished so far; a list of results counts as that many
    kept: int = 0  # of these, read from the file
    cpu_s: float = 0.0  # CPU time of all runs on one core, wherever and whenever they were made
    _stages: int = 0

    def each(self, work: Callable[..., Any], tasks: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
        """Yield work(*task) for every task, in their order.

        With a file, the results must be described by the return type that `work` declares.
        """
        stage, self._stages = self._stages, self._stages + 1
        batches = in_batches(tasks)
        there = {} if self.file is None else {k: self.file.read(stage, k, work) for k in range(len(batches))}
        ready = {k: done for k, done in there.items() if done is not None}
        found = self._made(work, [(k, batch) for k, batch in enumerate(batches) if k not in ready])
        before = set(ready)
        for k in range(len(batches)):
            while k not in ready:
                new, done = next(found)
                if self.file is not None:
                    self.file.keep(stage, new, done)
                ready[new] = done
            done = ready.pop(k)
            runs = sum(len(result) if isinstance(result, list) else 1 for result in done.results)
            self.runs, self.cpu_s = self.runs + runs, self.cpu_s + done.cpu_s
            self.kept += runs if k in before else 0
            yield from done.results
        next(found, None)  # its workers end

    def _made(self, work: Callable[..., Any], batches: Sequence[tuple[int, Batch]]) -> Iterator[tuple[int, Done]]:
        """Yield each batch with its number when it is done, in any order."""
        if not batches:
            return
        with self.workers.open(len(batches)) as executor:
            if executor is None:
                yield from ((number, carry_out(work, batch)) for number, batch in batches)
                return
            code, methods = code_version(), own_methods()
            with interrupts_withheld():  # processes start
                made = {
                    executor.submit(carry_out_elsewhere, pickle.dumps((work, batch)), code, methods): number
                    for number, batch in batches
                }
            for future in as_completed(made):
                yield made.pop(future), future.result()


def in_batches(tasks: Sequence[tuple[Any, ...]]) -> list[Batch]:
    """Divide tasks into batches.

    They depend on the number of tasks alone, so that any executor goes on with those that another one has made.
    """
    size = min(max(len(tasks) // MIN_BATCHES, 1), MAX_BATCH_TASKS)
    return [tasks[first : first + size] for first in range(0, len(tasks), size)]
