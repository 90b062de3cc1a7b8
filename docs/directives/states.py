"""States that the documentation shows."""

from dataclasses import dataclass
from functools import cache

import numpy as np

from viewimit import Session, Settings


@dataclass(frozen=True)
class State:
    """settings: what leads there; chosen: a body point, None for that with the largest residual; runs: until the servo
    rests; lab: the fragment of the lab's address that shows the same, if it can."""

    settings: Settings = Settings.paper()
    chosen: int | None = None
    runs: bool = False
    lab: str = ""


STATES = {
    "begin": State(Settings.paper(start_deg=(25, -45)), chosen=6, lab="preset=paper&demo=45,-90&start=25,-45&point=6"),
    "best": State(Settings(start_deg=(25, -45)), runs=True),
    "unobservable": State(
        Settings(points=5, joints=(4, 7), demonstrator_deg=(-80, 30), start_deg=(-50, 60)), runs=True
    ),
    "toed-in": State(Settings(scene="panda-toed", start_deg=(25, -45))),
}


@cache
def session(name: str) -> Session:
    """That has come to the state."""
    state = STATES[name]
    found = Session(state.settings)
    if state.runs:
        found.run()
    return found


def chosen(name: str) -> int:
    state, now = STATES[name], session(name).snapshot
    return int(np.nanargmax((now.e**2).sum(1))) if state.chosen is None else state.chosen
