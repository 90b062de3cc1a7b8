"""The tab Experiments with what is behind it: the page passes wishes on to it, ticks it and lets it draw."""

import time
from collections.abc import Callable
from contextlib import AbstractContextManager

from numpy.typing import NDArray
from viser import ClientHandle

from viewimit.analysis.motion import Motion, encode
from viewimit.session import Session

from ..control.experiments import Experiments
from ..control.inbox import Inbox
from ..control.motions import Motions
from ..jobs.experiments import ExperimentWorker
from ..jobs.landscapes import LandscapeWorker
from .experiments import ExperimentsTab

SEND_EVERY = 1.0  # s at least between two files


class Laboratory:
    """wishes: what may be asked, by the names in the inbox; each may raise ValueError.

    tab: what the tab is built in; aside: makes motions that take long; pose(theta): moves the demonstrator.
    """

    def __init__(
        self,
        client: ClientHandle,
        tab: AbstractContextManager,
        inbox: Inbox,
        session: Session,
        worker: ExperimentWorker,
        aside: LandscapeWorker,
        pose: Callable[[NDArray], None],
    ):
        self._client, self._session, self._sent_at = client, session, -SEND_EVERY
        self._encoded: tuple[Motion, bytes] | None = None
        page_id = client.client_id
        with tab:
            self._tab = ExperimentsTab(client, inbox)
        put = lambda made: inbox.put("motion made", made)
        make = lambda motion: aside.ask(page_id, motion, put, kind="motion")
        self._motions = Motions(session, pose, make, self._send)
        told = lambda run: inbox.put("run told", run)
        self._experiments = Experiments(worker, page_id, session, self._motions, told, self._send)
        self.wishes = {**self._experiments.wishes, **self._motions.wishes}

    def tick(self) -> None:
        self._motions.tick()

    @property
    def poses(self) -> bool:
        """Whether `tick` moves the demonstrator."""
        return self._motions.replaying

    def moves(self, name: str) -> bool:
        """Whether a wish may move the demonstrator."""
        return name in self._motions.wishes

    @property
    def state(self) -> tuple:
        """What the tab shows: drawn again when this differs."""
        experiments, motions = self._experiments, self._motions
        said = motions.name, motions.moment, motions.describe()
        return experiments.chosen, experiments.latest, experiments.shown, self._session.scene, *said

    @property
    def recorded(self) -> bytes | None:
        """The motion that was recorded or loaded, as a file has it."""
        motion = self._motions.recorded
        if motion is None:
            return None
        if self._encoded is None or self._encoded[0] is not motion:
            self._encoded = motion, encode(motion)
        return self._encoded[1]

    def draw(self) -> None:
        self._tab.show(self._experiments, self._motions, self._session.scene)

    def describe(self) -> tuple[str, str] | None:
        """State and sentence for the pill, while a motion is recorded or replayed."""
        return self._motions.describe() if self._motions.recording or self._motions.replaying else None

    def _send(self, name: str, data: bytes) -> None:
        now = time.monotonic()
        if now - self._sent_at >= SEND_EVERY:  # a second click does not send it twice
            self._sent_at = now
            self._client.send_file_download(name, data, save_immediately=True)
