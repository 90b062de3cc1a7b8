"""What all pages of a process share."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ..jobs import basin_child
from ..jobs.camera_images import CameraProcess
from ..jobs.experiments import ExperimentWorker
from ..jobs.landscapes import LandscapeWorker
from ..jobs.scripts import ScriptPlayer
from .shedding import LoadShedding


@dataclass(frozen=True, eq=False)
class Services:
    """share(robot, arm): puts its meshes on the server's scene, before they are first shown; clock: s, of the ticks."""

    landscapes: LandscapeWorker
    experiments: ExperimentWorker
    camera: CameraProcess
    shedding: LoadShedding
    share: Callable[[str, str], None]
    basins: ExperimentWorker = field(default_factory=lambda: ExperimentWorker(basin_child.work))
    scripts: ScriptPlayer = field(default_factory=ScriptPlayer)
    picture_scripts: ScriptPlayer = field(default_factory=lambda: ScriptPlayer(time.monotonic))  # which wait for them
    files: LandscapeWorker = field(default_factory=LandscapeWorker)  # which pictures and replays are made in
    clock: Callable[[], float] = time.monotonic
