"""The landscape of eyes turned inwards: as they see, rectified by their matches, and with more points."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from viewimit.analysis.landscape import Landscape, grid_axes, landscape_over
from viewimit.geometry.rectification import Rectification
from viewimit.loop.session import Session

from .work import Task, Work

GRID_DEG, FINE_DEG = 2.0, 0.1  # of the landscapes, and of a look around where E is smallest
MORE = 20  # points
CASES: Mapping[str, Mapping[str, Any]] = {
    "as seen": {"rectify": "off"},
    "rectified": {"rectify": "auto"},
    "more points": {"rectify": "off", "points": MORE},
}


@dataclass(frozen=True)
class Mending:
    """least: (2,) rad, where E is smallest, between the grid's postures too; rectification: by which images are
    rectified, None if they are not."""

    landscape: Landscape
    least: NDArray
    rectification: Rectification | None


def _mendings(task: Task) -> Mapping[str, Mending]:
    return {
        name: _mending(Session(msgspec.structs.replace(task.settings, **changed))) for name, changed in CASES.items()
    }


def _mending(session: Session) -> Mending:
    world, moment = session.world, session.snapshot
    demo, visible = moment.views.demo, moment.views.visible[:, :2]
    found = landscape_over(world, moment.fit, demo, visible, grid_axes(world, GRID_DEG))
    about = np.radians(np.arange(-GRID_DEG, GRID_DEG + FINE_DEG / 2, FINE_DEG))
    near = [np.clip(middle + about, axis[0], axis[-1]) for middle, axis in zip(found.minimum, found.axes)]
    least = landscape_over(world, moment.fit, demo, visible, (near[0], near[1])).minimum
    return Mending(found, least, moment.rectification)


WORKS: Mapping[str, Work] = {"mendings": Work(_mendings)}
