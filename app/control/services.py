"""What all pages of a process share."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from ..classroom.classroom import Classroom
from ..jobs import basin_child
from ..jobs.camera_images import CameraProcess
from ..jobs.experiments import ExperimentWorker
from ..jobs.landscapes import LandscapeWorker
from ..lessons.format import Lesson
from ..lessons.source import shipped
from .shedding import LoadShedding


@dataclass(frozen=True, eq=False)
class Services:
    """share(robot, arm): puts its meshes on the server's scene, before they are first shown; lessons: by name, in
    their order; classroom: where there is a lecturer; clock: s, that of the ticks."""

    landscapes: LandscapeWorker
    experiments: ExperimentWorker
    camera: CameraProcess
    shedding: LoadShedding
    share: Callable[[str, str], None]
    lessons: Mapping[str, Lesson] = field(default_factory=shipped)
    basins: ExperimentWorker = field(default_factory=lambda: ExperimentWorker(basin_child.work))
    files: LandscapeWorker = field(default_factory=LandscapeWorker)  # which pictures and replays are made in
    classroom: Classroom | None = None
    clock: Callable[[], float] = time.monotonic
