"""What a page shows, as it is told to the others of its class."""

import msgspec
import numpy as np

from viewimit.loop.script import Script

from ...classroom.messages import Shown
from ...sessions.link import written
from ..page_model import PageModel

replace = msgspec.structs.replace


def shown_of(model: PageModel) -> Shown:
    """What a page shows, for others; where too much was done to be said, what it shows from now on."""
    at = model.guided.place
    if at is not None:
        return Shown(lesson=at)
    playing = model.player.playing and not all(runner.resting for runner in model.player.runners)
    linked = model.linked()
    try:
        text = written(linked)
    except ValueError:
        text = written(replace(linked, script=_from_here(model)))
        return Shown(text=text, playing=playing)
    return Shown(text=text, motion=model.session.cursor, playing=playing)


def _from_here(model: PageModel) -> Script:
    present = model.session.snapshot
    start, demo = (tuple(np.degrees(theta).tolist()) for theta in (present.theta, present.theta_demo))
    return Script(replace(model.session.settings, start_deg=start, demonstrator_deg=demo))
