"""What the images show of a posture that the visitor gives a see-through arm."""

from itertools import product

import numpy as np
from numpy.typing import NDArray

from viewimit.drawing.lessons.see_through import SeeThrough

from ..stage import Stage


def see_through(stage: Stage) -> SeeThrough | None:
    """None where no posture is asked for."""
    moment = stage.guessed
    if moment is None:
        return None
    ends = product(*[(slider.low, slider.high) for slider in stage.step.sliders])
    room = np.concatenate([_bones(stage, np.radians(posture)) for posture in ends], 1)
    return SeeThrough(moment, _bones(stage, moment.theta), room)


def _bones(stage: Stage, theta: NDArray) -> NDArray:
    """(2, k, 2) px: the skeleton in L and R."""
    world = stage.session.world
    origins = world.link_frames(theta, world.T_world_own)[:, :3, 3]
    return world.own_pair.images(origins)[0]
