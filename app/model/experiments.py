"""What a page asks of its experiments, and what it knows of them."""

from collections.abc import Callable

import msgspec

from viewimit.experiments import EXPERIMENTS
from viewimit.loop.session import Session

from ..jobs.experiments import ExperimentWorker, Request, Run
from .motions import Motions
from .queue import CommandQueue, JobResult


def titles() -> dict[str, str]:
    """By name, of those that there are now."""
    return {name: experiment.title for name, experiment in EXPERIMENTS.items()}


class Experiments:
    """chosen: an experiment's name; latest: the run asked for last; runs: by experiment, its latest.

    All look at projected points, whatever the page looks with: pictures would take them hours.
    """

    def __init__(
        self,
        worker: ExperimentWorker,
        page_id: int,
        session: Session,
        motions: Motions,
        queue: CommandQueue,
        send: Callable[[str, bytes], None],
    ):
        self._worker, self._page_id, self._session, self._motions = worker, page_id, session, motions
        self._queue, self._send = queue, send
        self.chosen = next(iter(EXPERIMENTS))
        self.latest: Run | None = None
        self.runs: dict[str, Run] = {}

    @property
    def going_on(self) -> bool:
        return self.latest is not None and self.latest.goes_on

    @property
    def sets_pictures_aside(self) -> bool:
        """Whether the page looks with pictures, which an experiment does not."""
        return self._session.settings.sensor == "rendered"

    @property
    def shown(self) -> Run | None:
        """Of the experiment that is chosen."""
        return self.runs.get(self.chosen)

    def run_or_cancel(self) -> None:
        if self.going_on:
            self._worker.cancel(self._page_id)
            return
        offered = {"motion": self._motions.asked_for}
        options = {name: offered[name]() for name in EXPERIMENTS[self.chosen].options if name in offered}
        settings = msgspec.structs.replace(self._session.settings, sensor="projected")
        self._worker.ask(self._page_id, Request(self.chosen, settings, options), self._on_result)

    def take(self, run: Run) -> None:
        """What the worker tells. Raises ValueError, after taking it, for a run that has failed."""
        self.latest = self.runs[run.name] = run
        if run.state == "failed":
            raise ValueError(f"{EXPERIMENTS[run.name].short_title} failed: {run.problem}")

    def download(self) -> None:
        if self.shown is None or not self.shown.archive:
            raise ValueError("there is nothing to download before the experiment is done")
        self._send(f"viewimit-{self.chosen}.zip", self.shown.archive)

    def _on_result(self, run: Run) -> None:
        self._queue.put(JobResult(("run", run.name), self.take, run))
