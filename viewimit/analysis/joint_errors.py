"""How far a learner is from the demonstrator, over its history. The truth, for the viewer only."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..loop.snapshot import Snapshot

RECENT = 20  # motions over which the rms is taken


class ErrorTrace:
    """The largest joint error at every moment of a history, in degrees; only what is new in it is computed."""

    def __init__(self):
        self._postures: list[tuple[NDArray, NDArray]] = []  # moments are known by them, and not kept alive
        self._degrees: list[float] = []

    def of(self, history: Sequence[Snapshot]) -> list[float]:
        """history: it changes from its end only, or is another one."""
        kept = min(len(history), len(self._postures))
        while kept and any(a is not b for a, b in zip(self._postures[kept - 1], _postures(history[kept - 1]))):
            kept -= 1
        new = history[kept:]
        self._postures[kept:] = map(_postures, new)
        self._degrees[kept:] = largest_errors_deg(new)
        return self._degrees


def recent_errors_deg(history: Sequence[Snapshot], cursor: int) -> list[float]:
    """Of the last moments up to the cursor, as many as `following` asks for."""
    return largest_errors_deg(history[max(cursor - RECENT, 0) : cursor + 1])


def largest_errors_deg(moments: Sequence[Snapshot]) -> list[float]:
    """Of the joint that is farthest from the demonstrator's, at each moment."""
    if not moments:
        return []
    theta, theta_demo = zip(*map(_postures, moments))
    return np.degrees(np.abs(np.array(theta) - np.array(theta_demo)).max(1)).tolist()


def _postures(moment: Snapshot) -> tuple[NDArray, NDArray]:
    return moment.theta, moment.theta_demo
