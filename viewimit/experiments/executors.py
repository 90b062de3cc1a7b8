"""Studies of many independent runs: in processes here or on a Dask cluster, their results appended to one file.

A script that asks for more than one local process needs `if __name__ == "__main__":`. Each worker of a cluster needs
the same viewimit and numpy, one thread (`dask worker ADDRESS --nthreads 1`), and your own servos, transfers and cases:
name their file by `--preload FILE`.
"""

import contextlib
import hashlib
import importlib.util
import json
import multiprocessing
import os
import pickle
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any, get_type_hints

import msgspec
import numpy as np

from .. import __version__
from ..assets import ROOT
from ..loop.settings import UnknownMethod
from ..processes import end_with_parent, ignore_interrupts, interrupts_withheld

CONNECT_S = 30.0  # time to find a scheduler, and then to find its first worker
LIBRARY = Path(__file__).parents[1]
WITHOUT_EFFECT = {"app", "assets", "commands", "drawing"}  # packages that change no digit of a result
Task = tuple[Any, ...]  # the arguments of one call
Workers = tuple[Callable[..., Any], Callable[[Any], Iterator[Any]]]  # submit a call; futures in the order they end


class StudyError(Exception):
    """A study cannot be begun or go on; the message says why, where and what to do, in a line."""


@contextlib.contextmanager
def processes(count: int | None, tasks: int) -> Iterator[Workers | None]:
    """Open processes on this machine, by default one a processor; None for a single one, which is this one."""
    count = min(count or os.cpu_count() or 1, tasks)
    if count == 1:
        yield None
        return
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _start_worker)
    try:
        yield pool.submit, as_completed
    finally:
        pool.shutdown(cancel_futures=True)


def _start_worker() -> None:
    ignore_interrupts()
    end_with_parent()


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Workers]:
    """Open the Dask cluster of this scheduler, which repeats what lost workers had taken. Raises StudyError."""
    if importlib.util.find_spec("distributed") is None:
        raise StudyError(f"{address}: a cluster needs dask.distributed: pip install 'viewimit[cluster]'")
    import distributed

    line = lambda error: " ".join(str(error).split()) or type(error).__name__
    try:
        client = distributed.Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise StudyError(f"{address}: no Dask scheduler answers ({line(error)})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECT_S)
        except (TimeoutError, distributed.TimeoutError):
            advice = f"start some: dask worker {address} --nthreads 1"
            raise StudyError(f"{address}: that scheduler has no workers; {advice}") from None
        try:
            # Its `get_executor` fails where a worker is lost just as its result is fetched
            yield partial(client.submit, pure=False), partial(distributed.as_completed, loop=client.loop)
        except CancelledError:
            raise StudyError(f"{address}: the scheduler is lost") from None
        except distributed.KilledWorker as error:
            raise StudyError(f"a run loses every worker that takes it: {line(error)}") from None


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


def carry_out(work: Callable[..., Any], task: Task) -> tuple[Any, float]:
    """Call work(*task), and return its result and CPU time [s]."""
    began = time.thread_time()
    return work(*task), time.thread_time() - began


def carry_out_elsewhere(packed: bytes, code: str) -> tuple[Any, float]:
    """Carry out a pickled (work, task) in a worker. Raises StudyError if it has other code, or lacks what is asked."""
    if code_version() != code:
        raise StudyError(f"a worker has {code_version()}, and the study is of {code}: install the same there")
    try:
        return carry_out(*pickle.loads(packed))
    except (UnknownMethod, ImportError, AttributeError) as error:
        remedy = "start it with --preload FILE, the .py file that has it, or install that there"
        raise StudyError(f"a worker lacks what the study needs ({error}): {remedy}") from None


class StudyFile:
    """The file to which the results of a study are appended, a line of JSON each, so that it can go on.

    The first line says all that the results depend on. A last line that was interrupted is cut off. Raises StudyError
    for a file of another study, and names what differs, or one that cannot be written.
    """

    def __init__(self, path: Path, study: dict[str, Any]):
        self.path, study = path, json.loads(json.dumps(study))
        with self._naming():
            path.parent.mkdir(parents=True, exist_ok=True)
            content = path.read_bytes() if path.exists() else b""
        first, *lines = content.split(b"\n")
        try:
            there = json.loads(first) if content else study
        except ValueError:
            there = None
        if not isinstance(there, dict):
            raise StudyError(f"{path}: holds no study: take another file")
        for name in dict.fromkeys([*study, *there]):
            if there.get(name) != study.get(name):
                differs = f"{name} {there.get(name)} and not {study.get(name)}"
                raise StudyError(f"{path}: holds another study, {differs}: take another file")
        self.kept = {number: (result, cpu_s) for number, result, cpu_s in map(json.loads, lines[:-1])}
        with self._naming():
            if not lines:
                self._append(study)
            elif lines[-1]:
                os.truncate(path, len(content) - len(lines[-1]))

    def keep(self, number: int, result: Any, cpu_s: float) -> None:
        """Append the result of a task. Raises StudyError."""
        with self._naming("; finished runs are kept"):
            self._append([number, msgspec.to_builtins(result), cpu_s])

    def _append(self, line: Any) -> None:
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(line, ensure_ascii=False) + "\n")

    @contextlib.contextmanager
    def _naming(self, more: str = "") -> Iterator[None]:
        """Name this file in errors of the system."""
        try:
            yield
        except OSError as error:
            raise StudyError(f"{self.path}: {error.strerror or error}{more}") from None


@dataclass
class Study:
    """Where runs are made, the file that keeps them, and what they cost. Results do not depend on it.

    jobs: processes here, None for one a processor; dask: the address of a Dask scheduler instead.
    """

    jobs: int | None = 1
    dask: str | None = None
    file: StudyFile | None = None
    runs: int = 0  # finished so far
    kept: int = 0  # of these, read from the file
    cpu_s: float = 0.0  # CPU time of all runs on one core, wherever and whenever they were made

    def map(
        self, work: Callable[..., Any], tasks: Sequence[Task], progress: Callable[[float], None] = lambda share: None
    ) -> list[Any]:
        """Return work(*task) for every task, in their order. `work` declares the type of its result."""
        kept, kind = self.file.kept if self.file else {}, get_type_hints(work)["return"]
        found = {number: msgspec.convert(result, kind) for number, (result, _) in kept.items()}
        self.runs, self.kept, self.cpu_s = len(kept), len(kept), sum(cpu_s for _, cpu_s in kept.values())
        left = {number: task for number, task in enumerate(tasks) if number not in found}
        with contextlib.ExitStack() as stack:
            for number, (result, cpu_s) in self._made(work, left, stack) if left else ():
                if self.file:
                    self.file.keep(number, result, cpu_s)
                found[number] = result
                self.runs, self.cpu_s = self.runs + 1, self.cpu_s + cpu_s
                progress(len(found) / len(tasks))
        return [found[number] for number in range(len(tasks))]

    def _made(
        self, work: Callable[..., Any], tasks: dict[int, Task], stack: contextlib.ExitStack
    ) -> Iterator[tuple[int, tuple[Any, float]]]:
        """Yield each result with its number when it is there, in any order."""
        workers = stack.enter_context(cluster(self.dask) if self.dask else processes(self.jobs, len(tasks)))
        if workers is None:
            yield from ((number, carry_out(work, task)) for number, task in tasks.items())
            return
        submit, completed = workers
        with interrupts_withheld():  # processes start
            packed = ((number, pickle.dumps((work, task))) for number, task in tasks.items())
            made = {submit(carry_out_elsewhere, one, code_version()): number for number, one in packed}
        for future in completed(list(made)):
            yield made.pop(future), future.result()
