"""Work in processes beside the server: one at a time, in the order asked, each in a process of its own. A process that
is killed leaves nothing behind: cancelling, a closed tab and the server's end all do just that."""

import multiprocessing
import tempfile
import threading
import time
import traceback
from collections.abc import Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from typing import Any

from viewimit.analysis.trajectory import Imitation
from viewimit.experiments.paper.common import Claim
from viewimit.loop.settings import Settings

from . import child

ENDS_WITHIN_S = 2.0
GOING_ON = ("waiting", "running", "writing")


def begin(work: Callable[..., None], name: str, *arguments) -> tuple[BaseProcess, Any]:
    """Begin a process that runs work(connection, *arguments) → it, and the connection's other end."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    with theirs:  # while it is open here, the loss of the child would go unnoticed
        process = context.Process(target=work, args=(theirs, *arguments), name=name, daemon=True)
        process.start()
    return process, ours


def end(process: BaseProcess) -> None:
    """Kill a process, which has nothing to put in order and may not be listening."""
    process.kill()
    process.join()
    process.close()


@dataclass(frozen=True)
class Request:
    """name: of EXPERIMENTS; options: its own, by name."""

    name: str
    settings: Settings
    options: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Run:
    """A page's knowledge of its experiment. state: waiting, running, writing (its files), done, failed, cancelled;
    figure: html, of the results so far; archive: zip of the files; seconds: since it began to run."""

    name: str
    state: str = "waiting"
    share: float = 0.0
    figure: str = ""
    claims: tuple[Claim, ...] = ()
    imitation: Imitation | None = None
    archive: bytes = b""
    problem: str = ""
    seconds: float = 0.0
    request: Request | None = None

    @property
    def goes_on(self) -> bool:
        return self.state in GOING_ON


@dataclass(eq=False)
class _Job:
    request: Request
    tell: Callable[[Run], None]
    run: Run
    process: BaseProcess | None = None


class ExperimentWorker:
    """`ask` returns at once; `tell(run)` is called under the worker's lock, from any thread, and must be short.
    work(connection, folder): what each process does."""

    def __init__(self, work: Callable[[Connection, str], None] = child.carry_out_experiment):
        self._work, self._lock = work, threading.RLock()
        self._line = ThreadPoolExecutor(1, "viewimit-experiments")
        self._jobs: dict[Hashable, _Job] = {}  # by page

    def ask(self, page: Hashable, request: Request, tell: Callable[[Run], None]) -> None:
        """Raises ValueError while an earlier request of the page goes on."""
        with self._lock:
            if page in self._jobs:
                raise ValueError("an experiment of this page still runs: wait for it, or cancel it")
            job = self._jobs[page] = _Job(request, tell, Run(request.name, request=request))
            tell(job.run)
            self._line.submit(self._carry_out, page, job)

    def cancel(self, page: Hashable) -> None:
        """End what the page has asked for."""
        with self._lock:
            job = self._jobs.pop(page, None)
            if job is not None:
                self._tell(job, state="cancelled")
                if job.process is not None:
                    job.process.kill()

    def forget(self, page: Hashable) -> None:
        """The page is gone: it is sent nothing more."""
        with self._lock:
            if page in self._jobs:
                self._jobs[page].tell = lambda run: None
            self.cancel(page)

    def stop(self) -> None:
        """End everything, and wait until no process is left."""
        for page in list(self._jobs):
            self.forget(page)
        self._line.shutdown()

    def _carry_out(self, page: Hashable, job: _Job) -> None:
        """Until its process is gone."""
        problem = "its process ended unexpectedly"
        try:
            with tempfile.TemporaryDirectory(prefix="viewimit-", ignore_cleanup_errors=True) as folder:
                self._listen(job, folder)
        except Exception as error:  # one page's fault must not end the others' experiments
            if not isinstance(error, OSError):  # no process, no folder
                traceback.print_exc()
            problem = f"it could not be run: {error}"
        with self._lock:
            self._tell(job, state="failed", problem=problem)
            if self._jobs.get(page) is job:
                del self._jobs[page]

    def _listen(self, job: _Job, folder: str) -> None:
        with self._lock:
            if not job.run.goes_on:  # it was cancelled before its turn
                return
            self._tell(job, state="running")
            began, (process, connection) = time.monotonic(), begin(self._work, "viewimit-experiment", folder)
            job.process = process
        try:
            connection.send((job.request.name, job.request.settings, job.request.options))
            while job.run.goes_on:
                news = connection.recv()
                with self._lock:
                    self._tell(job, seconds=time.monotonic() - began, **news)
        except (EOFError, OSError):  # the process has ended
            pass
        finally:
            with self._lock:
                job.process = None
            process.join(ENDS_WITHIN_S if job.run.state == "done" else 0)
            end(process)
            connection.close()

    def _tell(self, job: _Job, **news) -> None:
        """Tell changes of a run, until it has ended."""
        if job.run.goes_on:
            job.run = replace(job.run, **news)
            job.tell(job.run)
