"""What all pages share."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from ..jobs.camera_images import CameraProcess
from ..jobs.child import carry_out_basin
from ..jobs.experiments import ExperimentWorker
from .queue import CommandQueue, Worker


@dataclass(frozen=True, eq=False)
class Services:
    """share(robot, arm): puts its meshes on the server's scene, before they are first shown; clock: s, of the ticks.
    Scripts of links are played in a thread of their own, as those that look with camera images wait for them."""

    share: Callable[[str, str], None]
    camera: CameraProcess = field(default_factory=CameraProcess)
    landscapes: Worker = field(default_factory=Worker)
    files: Worker = field(default_factory=Worker)  # pictures and replays
    scripts: Worker = field(default_factory=Worker)
    picture_scripts: Worker = field(default_factory=Worker)
    experiments: ExperimentWorker = field(default_factory=ExperimentWorker)
    basins: ExperimentWorker = field(default_factory=lambda: ExperimentWorker(carry_out_basin))
    clock: Callable[[], float] = time.monotonic

    def forget(self, page: CommandQueue) -> None:
        """Do nothing more for a page that is gone."""
        for each in (self.landscapes, self.files, self.scripts, self.picture_scripts, self.experiments, self.basins):
            each.forget(page)

    def stop(self) -> None:
        """End all processes."""
        self.camera.stop()
        self.experiments.stop()
        self.basins.stop()
