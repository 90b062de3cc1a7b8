"""How far a learner is from the demonstrator, over its history. The truth, for the viewer only."""

from collections.abc import Sequence

import numpy as np

from viewimit.snapshot import Snapshot

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


def recent_rms(errors_deg: Sequence[float]) -> float:
    """Root mean square of the last RECENT errors."""
    return float(np.sqrt(np.mean(np.square(errors_deg[-RECENT:]))))
