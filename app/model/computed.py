"""When a page asks for landscapes, and what has come of it."""

from collections.abc import Callable
from functools import partial

import msgspec

from viewimit.analysis.landscape import seen_from
from viewimit.analysis.minima import study_transfer
from viewimit.analysis.observability import joint_uncertainty
from viewimit.drawing.export.panels import COARSE_DEG, MadeLandscape, compute_landscape, landscape_key, make_landscape
from viewimit.drawing.landscape import LandscapePicture
from viewimit.estimation.equations import with_minus
from viewimit.estimation.transfers import TRANSFERS
from viewimit.experiments import EXPERIMENTS
from viewimit.loop.session import Session
from viewimit.loop.settings import Settings
from viewimit.loop.snapshot import Snapshot
from viewimit.simulation.world import World

from ..drawing import duel as drawing
from ..drawing.landscapes import draw_compared, draw_costs, draw_together, waiting
from ..jobs.experiments import ExperimentWorker, Request, Run
from .motions import Motions
from .queue import CommandQueue, Send


class OwnLandscape:
    """Of the transfer that the visitor's learner uses: coarse at once, then fine, unless it has changed by then.
    made: None before the first moment is known."""

    def __init__(self, beside: Callable[..., None]):
        self._beside = beside
        self._asked: tuple | None = None
        self._begun: Snapshot | None = None  # the first moment in the world
        self._about: Snapshot | None = None  # the moment that was asked for last
        self.made: MadeLandscape | None = None

    def ask(self, world: World, present: Snapshot) -> None:
        """If it would differ. In a new world an empty one stands for it meanwhile."""
        if self.made is None or self.made.world is not world:
            self._begun = present
            self.made = _without_landscape(world, present)
        asked = world, *landscape_key(present)
        if asked != self._asked:
            self._asked, self._about = asked, present
            self._beside("landscape", partial(make_landscape, world, present, COARSE_DEG), self.take)

    def take(self, made: MadeLandscape | Exception) -> None:
        """Unless the scene has changed meanwhile."""
        if self.made is None or self._begun is None:
            return
        if isinstance(made, Exception):
            made = _without_landscape(self.made.world, self._begun, with_minus(f"no landscape: {made}")[:60])
        if made.world is self.made.world:
            self.made = made
            if made.to_refine is not None and made.to_refine is self._about:
                self._beside("landscape", partial(make_landscape, made.world, made.to_refine), self.take)


def _without_landscape(world: World, present: Snapshot, why: str = "computing …") -> MadeLandscape:
    return MadeLandscape(world, LandscapePicture(None, world.scene, present, why), None)


class DuelLandscapes:
    """Of both learners. html: what lies under their paths."""

    def __init__(self, beside: Callable[..., None]):
        self._beside = beside
        self._asked: tuple | None = None
        self._world: World | None = None  # of the duel that goes on
        self.html = drawing.draw_empty()

    def ask(self, world: World, present: Snapshot, opponent: Session | None) -> None:
        """For landscapes of what both now see of the demonstrator, if they would differ."""
        if opponent is None:
            if self._world is not None:
                self._asked, self._world, self.html = None, None, drawing.draw_empty()
            return
        if self._world is not world:
            self._world, self.html = world, drawing.draw_ground(world.scene, [], present.theta_demo)
        both = present, opponent.snapshot
        asked = world, *map(landscape_key, both)
        if asked != self._asked:
            self._asked = asked
            self._beside("duel", partial(_draw_ground, world, both), self.take)

    def take(self, made: tuple[World, str] | Exception) -> None:
        if isinstance(made, Exception):
            raise ValueError(f"no landscapes for the duel: {made}")
        if made[0] is self._world:
            self.html = made[1]


def _draw_ground(world: World, both: tuple[Snapshot, Snapshot]) -> tuple[World, str]:
    found = [made for made in (compute_landscape(world, snapshot) for snapshot in both) if made is not None]
    has_both = len(found) == len(both)  # else there is nothing under the plot of errors
    return world, drawing.draw_ground(world.scene, found, both[0].theta_demo) if has_both else drawing.wrap("")


class Basins:
    """From where the learner arrives, while it is shown. run: None while it is not."""

    def __init__(self, worker: ExperimentWorker, queue: CommandQueue):
        self._worker, self._queue = worker, queue
        self._asked: Settings | None = None
        self._count = 0  # of requests
        self.run: Run | None = None

    def toggle(self, session: Session) -> None:
        """Find it, or hide it, which also ends it. Raises ValueError without two moving joints."""
        if self.run is not None:
            self._end()
        elif len(session.scene.moving_joints) != 2:
            raise ValueError("starts are spread over two moving joints; choose two under Joints")
        else:
            self._asked, self._count = _without_start(session.settings), self._count + 1
            request = Request(f"basin {self._count}", msgspec.structs.replace(self._asked, sensor="projected"))
            self.run = Run(request.name)
            tell = lambda run: self._queue.put_made(("basin", run.name), self.take, run)
            self._worker.ask(self._queue, request, tell)

    def follow(self, session: Session) -> None:
        """End it if it would differ now."""
        if self.run is not None and _without_start(session.settings) != self._asked:
            self._end()

    def take(self, run: Run) -> None:
        """What the worker tells. Raises ValueError for a run that has failed."""
        if self.run is None or run.name != self.run.name:  # of a run that is no longer shown
            return
        self.run = run
        if run.state == "failed":
            self.run = None
            raise ValueError(f"the starts could not be tried: {run.problem}")

    def _end(self) -> None:
        if self.run is not None and self.run.goes_on:
            self._worker.cancel(self._queue)
        self.run = None


def _without_start(settings: Settings) -> Settings:
    return msgspec.structs.replace(settings, start_deg=None)


class Comparison:
    """The landscapes of all transfers, computed only while they are shown. Each is asked for separately, so that those
    of other pages come in between. on: whether they are to be shown; toggles: how often that has changed; html: None
    while the one that is used is shown."""

    def __init__(self, beside: Callable[..., None]):
        self._beside = beside
        self._asked: tuple | None = None  # a world and what E depends on; None while nothing is shown
        self._compared: dict[str, tuple[tuple, str]] = {}  # by transfer: what was asked for, and its drawing
        self._fresh: set[str] = set()  # what has come since the last drawing
        self.on, self.toggles = False, 0
        self.html: str | None = None

    def toggle(self) -> None:
        self.on, self.toggles, self._asked = not self.on, self.toggles + 1, None
        if not self.on:
            self.html = None

    def ask(self, world: World, snapshot: Snapshot) -> None:
        """Ask again if the landscapes would differ."""
        if not self.on:
            return
        asked = world, *landscape_key(snapshot, ignored=("transfer",))
        if asked == self._asked:
            return
        if self._asked is None or self._asked[0] is not world:
            self._compared.clear()
            self.html = waiting("computing …")
        self._asked = asked
        for transfer in TRANSFERS:
            make = partial(_draw_compared, asked, world, snapshot, transfer)
            self._beside(f"compared: {transfer}", make, partial(self.take, transfer))

    def take(self, transfer: str, made: tuple[tuple, str] | Exception) -> None:
        """Draw all once they are as asked for; or all are newer than those shown, while the demonstrator moves on."""
        if isinstance(made, Exception):
            raise ValueError(f"nothing to compare for the {transfer} transfer: {made}")
        if self._asked is None or made[0][0] is not self._asked[0]:  # closed, or of another scene
            return
        self._compared[transfer] = made
        self._fresh.add(transfer)
        as_asked = all(asked == self._asked for asked, _ in self._compared.values())
        if len(self._compared) == len(TRANSFERS) and (as_asked or len(self._fresh) == len(TRANSFERS)):
            self._fresh.clear()
            self.html = draw_together([self._compared[transfer][1] for transfer in TRANSFERS])


def _draw_compared(asked: tuple, world: World, snapshot: Snapshot, transfer: str) -> tuple[tuple, str]:
    joints, theta_demo = world.scene.moving_joints, snapshot.theta_demo
    if len(joints) == 2:
        return asked, draw_compared(world.scene, study_transfer(world, snapshot, transfer), theta_demo)
    return asked, draw_costs(joints, transfer, joint_uncertainty(*seen_from(world, snapshot, transfer), theta_demo))


class Experiments:
    """What a page asks of its experiments, and what it knows of them. All look at projected points, as pictures would
    take them hours. chosen: an experiment's name; latest: the run asked for last; runs: by experiment, its latest."""

    def __init__(self, worker: ExperimentWorker, session: Session, motions: Motions, queue: CommandQueue, send: Send):
        self._worker, self._session, self._motions = worker, session, motions
        self._queue, self._send = queue, send
        self.chosen = next(iter(EXPERIMENTS))
        self.latest: Run | None = None
        self.runs: dict[str, Run] = {}

    @property
    def going_on(self) -> bool:
        return self.latest is not None and self.latest.goes_on

    @property
    def shown(self) -> Run | None:
        """Of the experiment that is chosen."""
        return self.runs.get(self.chosen)

    def run_or_cancel(self) -> None:
        if self.going_on:
            self._worker.cancel(self._queue)
            return
        offered = {"motion": self._motions.asked_for}
        options = {name: offered[name]() for name in EXPERIMENTS[self.chosen].options if name in offered}
        settings = msgspec.structs.replace(self._session.settings, sensor="projected")
        tell = lambda run: self._queue.put_made(("run", run.name), self.take, run)
        self._worker.ask(self._queue, Request(self.chosen, settings, options), tell)

    def take(self, run: Run) -> None:
        """What the worker tells. Raises ValueError, after taking it, for a run that has failed."""
        self.latest = self.runs[run.name] = run
        if run.state == "failed":
            title = EXPERIMENTS[run.name].short_title
            raise ValueError(f"{title} failed: {run.problem}")

    def download(self) -> None:
        if self.shown is None or not self.shown.archive:
            raise ValueError("there is nothing to download before the experiment is done")
        self._send(f"viewimit-{self.chosen}.zip", self.shown.archive)
