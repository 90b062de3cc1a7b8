"""How far a learner is from the demonstrator, over its history. The truth, for the viewer only."""

from collections.abc import Sequence

import numpy as np

from viewimit.snapshot import Snapshot

from . import svg

RECENT = 20  # motions over which the rms is taken


class ErrorTrace:
    """The largest joint error at every moment of a history, in degrees; only what is new in it is computed."""

    def __init__(self):
        self._moments: list[Snapshot] = []
        self._degrees: list[float] = []

    def of(self, history: Sequence[Snapshot]) -> list[float]:
        """history: it changes from its end only, or is another one."""
        kept = min(len(history), len(self._moments))
        while kept and self._moments[kept - 1] is not history[kept - 1]:
            kept -= 1
        new = list(history[kept:])
        self._moments[kept:] = new
        self._degrees[kept:] = [largest_error_deg(moment) for moment in new]
        return self._degrees


def largest_error_deg(snapshot: Snapshot) -> float:
    """Of the joint that is farthest from the demonstrator's."""
    return float(np.degrees(np.abs(snapshot.theta - snapshot.theta_demo).max()))


def following(errors_deg: Sequence[float]) -> str:
    """How far off a learner is, and was in the last RECENT motions; nothing before the first motion."""
    recent = np.array(errors_deg[1:][-RECENT:])
    if len(recent) == 0:
        return ""
    count = "1 motion" if len(recent) == 1 else f"{len(recent)} motions"
    return f"{svg.number(recent[-1])}° off, rms {svg.number(np.sqrt(np.mean(recent**2)))}° over {count}"
