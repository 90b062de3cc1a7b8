"""What all pages share."""

import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

import numpy as np

from viewimit.loop.snapshot import Snapshot

from ..jobs import basin_child
from ..jobs.camera_images import Cameras
from ..jobs.experiments import ExperimentWorker
from ..jobs.threads import LandscapeWorker, ScriptPlayer

# What a page has drawn last, and when: nothing is sent when nothing changes, nor more often than anybody sees.

EARLY = 0.9  # of a period: ticks jitter


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
    share: Callable[[str, str], None]
    basins: ExperimentWorker = field(default_factory=lambda: ExperimentWorker(basin_child.work))
    scripts: ScriptPlayer = field(default_factory=ScriptPlayer)
    picture_scripts: ScriptPlayer = field(default_factory=lambda: ScriptPlayer(time.monotonic))  # which wait for them
    files: LandscapeWorker = field(default_factory=LandscapeWorker)  # which pictures and replays are made in
    clock: Callable[[], float] = time.monotonic
