"""What a page has drawn last, and when: nothing is sent when nothing changes, nor more often than anybody sees."""

from collections.abc import Hashable

import numpy as np

from viewimit.loop.snapshot import Snapshot

EARLY = 0.9  # of a period: ticks jitter


class Redraw:
    """Remembers by kind of drawing, or by a name, its last values and when it was drawn."""

    def __init__(self):
        self._state: dict[Hashable, tuple] = {}
        self._at: dict[Hashable, float] = {}

    def due(self, what: Hashable, now: float, period: float) -> bool:
        """Return whether a period, s, has passed since this was last due.

        A call late by less than a period does not delay those after it.
        """
        at = self._at.get(what, -np.inf)
        if now - at < EARLY * period:
            return False
        self._at[what] = min(at + period, now) if now - at < 2 * period else now
        return True

    def changed(self, what: Hashable, state: tuple) -> bool:
        """Return whether the state differs from the last one. Of snapshots the identity counts."""
        before, self._state[what] = self._state.get(what), state
        if before is None or len(before) != len(state):
            return True
        return any(a is not b and (isinstance(a, Snapshot) or a != b) for a, b in zip(before, state))
