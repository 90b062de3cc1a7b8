"""Experiments run beside the server, each in a process of its own, one at a time, in the order asked.

A process that is ended leaves nothing behind: cancelling, a closed tab and the server's end all do just that.
"""

import contextlib
import multiprocessing
import tempfile
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection

from viewimit.analysis.trajectory import Imitation
from viewimit.experiments.paper.common import Claim
from viewimit.loop.settings import Settings

from . import experiment_child

ENDS_WITHIN_S = 2.0
GOING_ON = ("waiting", "running", "writing")


@dataclass(frozen=True)
class Request:
    """name: of EXPERIMENTS; options: its own, by name."""

    name: str
    settings: Settings
    options: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Run:
    """A page's knowledge of its experiment; each message brings it whole.

    state: waiting, running, writing (its files), done, failed, cancelled; before: runs that are first;
    figure: html, of the results so far; imitation: a motion that can be seen; archive: zip of the files;
    seconds: since it began to run; request: of the page.
    """

    name: str
    state: str = "waiting"
    before: int = 0
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
    page_id: int
    request: Request
    tell: Callable[[Run], None]
    run: Run
    process: multiprocessing.process.BaseProcess | None = None
    cancelled: bool = False


class ExperimentWorker:
    """`ask` returns at once; `tell(run)` is called under the worker's lock, from any thread, and must be short.

    work(connection, folder): what each process does.
    """

    def __init__(self, work: Callable[[Connection, str], None] = experiment_child.work):
        self._work = work
        self._changed = threading.Condition()
        self._waiting: dict[int, _Job] = {}
        self._job: _Job | None = None  # the one that runs
        self._stopped = False
        self._thread = threading.Thread(target=self._serve, name="viewimit-experiments", daemon=True)
        self._thread.start()

    def ask(self, page_id: int, request: Request, tell: Callable[[Run], None]) -> None:
        """A newer request takes the place of the page's waiting one. Raises ValueError while one of the page runs."""
        with self._changed:
            if self._running_of(page_id) is not None:
                raise ValueError("an experiment of this page still runs: wait for it, or cancel it")
            self._waiting[page_id] = _Job(page_id, request, tell, Run(request.name, request=request))
            self._tell_waiting()
            self._changed.notify()

    def cancel(self, page_id: int) -> None:
        """End what the page has asked for."""
        with self._changed:
            job, running = self._waiting.pop(page_id, None), self._running_of(page_id)
            if job is not None:
                self._tell(job, state="cancelled")
                self._tell_waiting()
            elif running is not None:
                self._tell(running, state="cancelled")
                self._end(running)

    def forget(self, page_id: int) -> None:
        """The page is gone: it is sent nothing more."""
        with self._changed:
            for job in (self._waiting.get(page_id), self._job):
                if job is not None and job.page_id == page_id:
                    job.tell = lambda run: None
        self.cancel(page_id)

    def stop(self) -> None:
        """End everything, and wait until no process is left."""
        with self._changed:
            self._stopped = True
            self._waiting.clear()
            if self._job is not None:
                self._end(self._job)
            self._changed.notify()
        self._thread.join(2 * ENDS_WITHIN_S)

    def _serve(self) -> None:
        while True:
            with self._changed:
                while not self._waiting and not self._stopped:
                    self._changed.wait()
                if self._stopped:
                    return
                self._job = self._waiting.pop(next(iter(self._waiting)))
                self._tell(self._job, state="running", before=0)
                self._tell_waiting()
            problem = self._carry_out(self._job)
            with self._changed:
                if self._job.run.goes_on and not self._job.cancelled:
                    self._tell(self._job, state="failed", problem=problem)
                self._job = None

    def _carry_out(self, job: _Job) -> str:
        """Until its process is gone; the message to send if it has not sent the last one itself."""
        began = time.monotonic()
        try:
            with tempfile.TemporaryDirectory(prefix="viewimit-", ignore_cleanup_errors=True) as folder:
                with self._process(job, folder) as connection:
                    self._listen(job, connection, began)
        except Exception as error:  # one page's fault must not end the others' experiments
            if not isinstance(error, OSError):  # no process, no folder
                traceback.print_exc()
            return f"it could not be run: {error}"
        return "its process ended unexpectedly"

    @contextlib.contextmanager
    def _process(self, job: _Job, folder: str):
        """A process of its own, which is gone afterwards."""
        context = multiprocessing.get_context("spawn")
        ours, theirs = context.Pipe()
        process = context.Process(target=self._work, args=(theirs, folder), name="viewimit-experiment", daemon=True)
        with ours:
            with theirs:  # the child's end; while it is open here, its loss would go unnoticed
                process.start()
            with self._changed:
                job.process = process
                if job.cancelled:
                    self._end(job)
            try:
                yield ours
            finally:
                with self._changed:
                    job.process = None
                process.join(ENDS_WITHIN_S if job.run.state == "done" else 0)
                process.kill()
                process.join()
                process.close()

    def _listen(self, job: _Job, connection: Connection, began: float) -> None:
        try:
            connection.send((job.request.name, job.request.settings, job.request.options))
            while job.run.goes_on:
                kind, *content = connection.recv()
                with self._changed:
                    if not job.cancelled:
                        self._tell(job, seconds=time.monotonic() - began, **_news(kind, *content))
        except (EOFError, OSError):  # the process has ended
            pass

    def _running_of(self, page_id: int) -> _Job | None:
        job = self._job
        return job if job is not None and job.page_id == page_id and job.run.goes_on else None

    def _end(self, job: _Job) -> None:
        job.cancelled = True
        if job.process is not None:
            job.process.kill()  # it has nothing to put in order, and may not be listening

    def _tell(self, job: _Job, **news) -> None:
        job.run = replace(job.run, **news)
        job.tell(job.run)

    def _tell_waiting(self) -> None:
        """Every waiting page how many are first."""
        first = 0 if self._job is None else 1
        for k, job in enumerate(self._waiting.values()):
            self._tell(job, before=first + k)


def _news(kind: str, *content) -> dict:
    """A message of the process, as changes of a run."""
    if kind == "share":
        return {"share": content[0]}
    if kind == "figure":
        return {"figure": content[0]}
    if kind == "imitation":
        return {"imitation": content[0]}
    if kind == "found":
        return {"state": "writing", "share": 1.0, "figure": content[0], "claims": content[1]}
    if kind == "files":
        return {"state": "done", "archive": content[0]}
    return {"state": "failed", "problem": content[0]}
