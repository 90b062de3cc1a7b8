"""What all pages of a process share."""

import time
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass, field

import numpy as np

from viewimit.loop.snapshot import Snapshot

from ..jobs import basin_child
from ..jobs.camera_images import Cameras
from ..jobs.experiments import ExperimentWorker
from ..jobs.threads import LandscapeWorker, ScriptPlayer

# Load shedding: plots slow down first, then panels; poses keep their pace.

AIM = 0.98  # of a tick that may be spent on all pages together, and on sending what they draw
GAIN = 0.04  # a tick: from no to full load shedding in some seconds
SLOWEST = 5.0  # times the usual period
STEPS = 0.4  # of a tick: for sessions that run as fast as they compute, all together


class LoadShedding:
    """Written by the scheduler, read by its pages. strain: 0 all at full rate, 1 plots slowest, 2 panels too."""

    def __init__(self, tick_s: float):
        self._tick_s = tick_s
        self.strain = 0.0
        self._running, self._ran = 0, 0  # sessions that asked for steps in this tick, and in the one before

    @property
    def plots(self) -> float:
        """How many times longer than usual between two plots."""
        return 1 + (SLOWEST - 1) * min(self.strain, 1.0)

    @property
    def panels(self) -> float:
        return 1 + (SLOWEST - 1) * max(self.strain - 1.0, 0.0)

    def step_budget(self) -> float:
        """s in this tick for one more session that runs as fast as it computes."""
        self._running += 1
        return STEPS * self._tick_s / max(self._running, self._ran)

    def ticked(self, busy_s: float) -> None:
        """How long all pages together took in a tick."""
        share = min(busy_s / self._tick_s, 2.0)
        self.strain = float(np.clip(self.strain + GAIN * (share - AIM), 0.0, 2.0))
        self._ran, self._running = self._running, 0


# What a page has drawn last, and when: nothing is sent when nothing changes, nor more often than anybody sees.

EARLY = 0.9  # of a period: ticks jitter
ToDraw = tuple[Hashable, Callable[[], None]]  # of what kind it is, and what draws it


def draw_all(drawings: Iterable[ToDraw]) -> None:
    for _, draw in drawings:
        draw()


class Redraw:
    """Remembers by kind of drawing, or by a name, its last values and when it was drawn."""

    def __init__(self):
        self._state: dict[Hashable, tuple] = {}
        self._at: dict[Hashable, float] = {}

    def due(self, what: Hashable, now: float, period: float) -> bool:
        """Return whether a period, s, has passed since this was last due.

        A call late by less than a period does not delay those after it.
        """
        at = self._at.get(what, -np.inf)
        if now - at < EARLY * period:
            return False
        self._at[what] = min(at + period, now) if now - at < 2 * period else now
        return True

    def changed(self, what: Hashable, state: tuple) -> bool:
        """Return whether the state differs from the last one. Of snapshots the identity counts."""
        before, self._state[what] = self._state.get(what), state
        if before is None or len(before) != len(state):
            return True
        for a, b in zip(before, state):
            if a is not b and (isinstance(a, Snapshot) or a != b):
                return True
        return False


@dataclass(frozen=True, eq=False)
class Services:
    """share(robot, arm): puts its meshes on the server's scene, before they are first shown; clock: s, of the ticks."""

    landscapes: LandscapeWorker
    experiments: ExperimentWorker
    camera: Cameras
    shedding: LoadShedding
    share: Callable[[str, str], None]
    basins: ExperimentWorker = field(default_factory=lambda: ExperimentWorker(basin_child.work))
    scripts: ScriptPlayer = field(default_factory=ScriptPlayer)
    picture_scripts: ScriptPlayer = field(default_factory=lambda: ScriptPlayer(time.monotonic))  # which wait for them
    files: LandscapeWorker = field(default_factory=LandscapeWorker)  # which pictures and replays are made in
    clock: Callable[[], float] = time.monotonic
