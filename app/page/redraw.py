"""What a page has drawn last, and when: nothing is sent when nothing changes, nor more often than anybody sees."""

from collections.abc import Callable, Hashable, Iterable

import numpy as np

from viewimit.loop.snapshot import Snapshot

EARLY = 0.9  # of a period: ticks jitter
ToDraw = tuple[Hashable, Callable[[], None]]  # of what kind it is, and what draws it


def draw_all(drawings: Iterable[ToDraw]) -> None:
    for _, draw in drawings:
        draw()


class Redraw:
    """By what is drawn: the kind of a drawing, or a name."""

    def __init__(self):
        self._state: dict[Hashable, tuple] = {}
        self._at: dict[Hashable, float] = {}

    def due(self, what: Hashable, now: float, period: float) -> bool:
        """Whether that long has passed, s, since this was last to be answered with yes: what is asked late by less than
        a period keeps its pace."""
        at = self._at.get(what, -np.inf)
        if now - at < EARLY * period:
            return False
        self._at[what] = min(at + period, now) if now - at < 2 * period else now
        return True

    def changed(self, what: Hashable, state: tuple) -> bool:
        """Whether this differs from what was told last; of snapshots, whether they are others."""
        before, self._state[what] = self._state.get(what), state
        if before is None or len(before) != len(state):
            return True
        for a, b in zip(before, state):
            if a is not b and (isinstance(a, Snapshot) or a != b):
                return True
        return False
