"""States of the page that the documentation shows, and the address that opens the page in each."""

from dataclasses import dataclass, field
from functools import cache

import numpy as np

from viewimit import Session, Settings
from viewimit.loop import link
from viewimit.loop.simulated_robot import complete

PAGE = "http://127.0.0.1:8080/?"  # where `viewimit` serves


@dataclass(frozen=True)
class State:
    """settings: what leads there; chosen: a body point, None for that with the largest residual; show:
    switches of the page."""

    settings: Settings = Settings.paper()
    chosen: int | None = None
    show: dict[str, bool] = field(default_factory=dict)
    runs: bool = False  # until the servo rests


STATES = {
    "begin": State(Settings.paper(start_deg=(25, -45)), chosen=6),
    "best": State(Settings(start_deg=(25, -45)), runs=True),
    "unobservable": State(Settings(points=5, start_deg=(25, -45)), runs=True),
    "toed-in": State(Settings(scene="panda-toed", start_deg=(25, -45)), show={"rectified": True}),
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


def address(name: str) -> str:
    """Of the page in that state."""
    shown = session(name)
    base = complete(Settings.paper())
    pairs = [("preset", "paper"), *link.said(shown.script, base), ("point", str(chosen(name)))]
    return PAGE + link.joined([*pairs, *((switch, str(int(on))) for switch, on in STATES[name].show.items())])
