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
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, Executor, ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, get_type_hints

import msgspec
import numpy as np

from .. import __version__
from ..assets import ROOT
from ..processes import end_with_parent, ignore_interrupts, interrupts_withheld

CONNECT_S = 30.0  # time to find a scheduler, and then to find its first worker
LIBRARY = Path(__file__).parents[1]
WITHOUT_EFFECT = {"app", "assets", "commands", "drawing"}  # packages that change no digit of a result
Task = tuple[Any, ...]  # the arguments of one call


class StudyError(Exception):
    """A study cannot be begun or go on; the message says why, where and what to do, in a line."""


@contextlib.contextmanager
def processes(count: int | None) -> Iterator[Executor | None]:
    """Open processes on this machine, by default one a processor; None for a single one, which is this one."""
    count = count or os.cpu_count() or 1
    if count == 1:
        yield None
        return
    pool = ProcessPoolExecutor(count, multiprocessing.get_context("spawn"), _start_worker)
    try:
        yield pool
    finally:
        pool.shutdown(cancel_futures=True)


def _start_worker() -> None:
    ignore_interrupts()
    end_with_parent()


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Executor]:
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
            yield client.get_executor(pure=False)
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


def carry_out(work: Callable[..., Any], task: Task, code: str) -> tuple[Any, float]:
    """Call work(*task), and return its result and CPU time [s]. Raises StudyError if a worker has other code."""
    if code and code_version() != code:
        raise StudyError(f"a worker has {code_version()}, and the study is of {code}: install the same there")
    began = time.thread_time()
    return work(*task), time.thread_time() - began


class StudyFile:
    """The file to which the results of a study are appended, a line of JSON each, so that it can go on.

    The first line says what the study is. A last line that was interrupted is cut off.

    Parameters
    ----------
    path : Path
        Made if need be.
    study : dict
        Everything that the results depend on, as JSON has it.

    Raises
    ------
    StudyError
        For a file of another study (the message says what differs), or that cannot be written.
    """

    def __init__(self, path: Path, study: dict[str, Any]):
        self.path, self.kept = path, dict[int, tuple[Any, float]]()
        study = json.loads(json.dumps(study))
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            content = path.read_bytes() if path.exists() else b""
            whole = content[: content.rfind(b"\n") + 1]
            if whole != content:
                os.truncate(path, len(whole))
        except OSError as error:
            raise StudyError(f"{path}: {error.strerror or error}") from None
        first, *lines = whole.splitlines() or [b""]
        if first:
            self._require_same(first, study)
            self.kept = {number: (result, cpu_s) for number, result, cpu_s in map(json.loads, lines)}
        elif content:
            self._require_same(content, study)
        else:
            self._append(study)

    def keep(self, number: int, result: Any, cpu_s: float) -> None:
        """Append the result of a task. Raises StudyError."""
        self._append([number, msgspec.to_builtins(result), cpu_s])

    def _append(self, line: Any) -> None:
        try:
            with self.path.open("a", encoding="utf-8") as file:
                file.write(json.dumps(line, ensure_ascii=False) + "\n")
        except OSError as error:
            raise StudyError(f"{self.path}: {error.strerror or error}; finished runs are kept") from None

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
        kind, found = get_type_hints(work)["return"], dict[int, Any]()
        for number, (result, cpu_s) in ({} if self.file is None else self.file.kept).items():
            found[number] = msgspec.convert(result, kind)
            self.runs, self.kept, self.cpu_s = self.runs + 1, self.kept + 1, self.cpu_s + cpu_s
        left = [number for number in range(len(tasks)) if number not in found]
        with contextlib.ExitStack() as stack:
            for number, (result, cpu_s) in self._made(work, {k: tasks[k] for k in left}, stack):
                if self.file is not None:
                    self.file.keep(number, result, cpu_s)
                found[number] = result
                self.runs, self.cpu_s = self.runs + 1, self.cpu_s + cpu_s
                progress(len(found) / len(tasks))
        return [found[number] for number in range(len(tasks))]

    def _made(
        self, work: Callable[..., Any], tasks: dict[int, Task], stack: contextlib.ExitStack
    ) -> Iterator[tuple[int, tuple[Any, float]]]:
        """Yield each result with its number when it is there, in any order."""
        if not tasks:
            return
        jobs = min(self.jobs or os.cpu_count() or 1, len(tasks))
        executor = stack.enter_context(cluster(self.dask) if self.dask else processes(jobs))
        if executor is None:
            yield from ((number, carry_out(work, task, "")) for number, task in tasks.items())
            return
        code = code_version()
        with interrupts_withheld():  # processes start
            made = {executor.submit(carry_out, work, task, code): number for number, task in tasks.items()}
        for future in as_completed(made):
            yield made.pop(future), future.result()
