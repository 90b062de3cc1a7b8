"""What all pages of a process share."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from ..jobs import basin_child
from ..jobs.camera_images import Cameras
from ..jobs.experiments import ExperimentWorker
from ..jobs.landscapes import LandscapeWorker
from ..jobs.scripts import ScriptPlayer

# What gives way when there is too much to do: the plots first, then the panels; poses keep their pace.

AIM = 0.98  # of a tick that may be spent on all pages together, and on sending what they draw
GAIN = 0.04  # a tick: from nothing given way to everything in some seconds
SLOWEST = 5.0  # times the usual period
STEPS = 0.4  # of a tick: for sessions that run as fast as they compute, all together
SHARE = 0.2  # of the time: for what the visitor of one page does, 10 ms of a tick of 50 ms
AT_ONCE = 0.2  # s of it that may be spent at once after a while without much


class LoadShedding:
    """Written by the scheduler, read by its pages. strain: 0 nothing gives way, 1 plots do most, 2 panels too."""

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


class TimeBudget:
    """How much of the time one page's visitor may have carried out, so that the others' pages keep their pace. What one
    command takes beyond it is made up for by those after it, which wait."""

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._left, self._last = AT_ONCE, clock()

    @property
    def left(self) -> bool:
        now = self._clock()
        self._left = min(AT_ONCE, self._left + SHARE * (now - self._last))
        self._last = now
        return self._left > 0

    def spend(self, work: Callable[[], None]) -> None:
        """Do it, and count how long it takes."""
        began = self._clock()
        try:
            work()
        finally:
            self._left -= self._clock() - began


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
