"""The snapshots of a session in the order of their motions, and the one that it shows."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from .snapshot import COMPUTED, Snapshot

MAX_HISTORY = 100_000  # motions a session makes
RECENT = 64  # last motions whose snapshots keep their computed quantities
EARLY = 64  # first motions, the longest ones, that are always kept
STRIDE, MAX_OLD = 32, 64  # of older motions one in STRIDE is kept, or fewer, so that at most MAX_OLD are


class History(Sequence[Snapshot]):
    """The snapshots of a session by motion, from 0 on, and the cursor: the motion that the session shows.

    Parameters
    ----------
    snapshots : iterable of Snapshot
    cursor : int
    dense : int, optional
        How many of the last motions are kept completely; all by default. Of older motions the first EARLY are kept,
        and then every STRIDE-th, which also stands for those after it. When there are MAX_OLD of these, every second
        one is dropped. So a history of any length takes a bounded amount of memory.
    joints : sequence of int, optional
        Numbers of the moving joints, for the names of columns; 1, 2, … by default.
    """

    def __init__(
        self,
        snapshots: Iterable[Snapshot],
        cursor: int = 0,
        dense: int | None = None,
        joints: Sequence[int] | None = None,
    ):
        self.joints = joints
        self._snapshots, self._dense = list(snapshots), dense
        self.cursor: int = cursor
        for first in range(0, cursor - RECENT - STRIDE + 1, STRIDE):
            self._let_go(first)
        self._thin()

    def __len__(self) -> int:
        return len(self._snapshots)

    def __iter__(self) -> Iterator[Snapshot]:
        return iter(self._snapshots)

    @overload
    def __getitem__(self, index: int) -> Snapshot: ...
    @overload
    def __getitem__(self, index: slice) -> list[Snapshot]: ...
    def __getitem__(self, index: int | slice) -> Snapshot | list[Snapshot]:
        return self._snapshots[index]

    @property
    def present(self) -> Snapshot:
        """The snapshot that the cursor is on."""
        return self._snapshots[self.cursor]

    @property
    def imitation_motions(self) -> int:
        """The number of motions up to the present, without those of a rehearsal and before it."""
        if self.present.pending_postures is None:
            return self.present.motion
        past = reversed(self._snapshots[: self.cursor + 1])
        last = next((one.motion + 1 for one in past if one.is_rehearsing), 0)
        return max(self.present.motion - last, 0)

    def recent(self, count: int) -> list[Snapshot]:
        """The last snapshots up to the present, at most `count`. The present one is last."""
        return self._snapshots[max(self.cursor + 1 - count, 0) : self.cursor + 1]

    def arrays(self) -> dict[str, NDArray[Any]]:
        """The history as columns with one value for each motion.

        Returns
        -------
        dict of (K,) arrays
            Of the K snapshots that are kept: motion; for each joint theta2_deg, demonstrator2_deg (the truth, NaN where
            unknown) and moved2_deg, the motion that led there; E_px2; usable, the number of points visible in all
            views; probe; status.
        """
        kept = [one for k, one in enumerate(self._snapshots) if one.motion == k]  # the others stand for dropped ones
        joints = self.joints or range(1, len(kept[0].theta) + 1)
        angles = {
            "theta": [one.theta for one in kept],
            "demonstrator": [one.theta_demo for one in kept],
            "moved": [one.moved for one in kept],
        }
        by_joint = {
            f"{name}{joint}_deg": column
            for name, values in angles.items()
            for joint, column in zip(joints, np.degrees(values).T)
        }
        return {
            "motion": np.array([one.motion for one in kept]),
            **by_joint,
            "E_px2": np.array([one.E for one in kept]),
            "usable": np.array([int(one.usable.sum()) for one in kept]),
            "probe": np.array([bool(one.probe) for one in kept]),
            "status": np.array([one.status for one in kept]),
        }

    def table(self) -> list[dict[str, Any]]:
        """The history as rows, one for each motion, with the columns of `arrays`: for csv.DictWriter or pandas."""
        columns = self.arrays()
        return [dict(zip(columns, row)) for row in zip(*(column.tolist() for column in columns.values()))]

    def append(self, snapshot: Snapshot) -> None:
        """Add the snapshot after the next motion. Later snapshots are dropped."""
        self.cursor += 1
        self._snapshots[self.cursor :] = [snapshot]
        if self.cursor % STRIDE == 0:
            self._let_go(self.cursor - RECENT - STRIDE)
        if self._dense is not None and (self.cursor - self._dense) % STRIDE == 0:
            self._thin()

    def replace(self, snapshot: Snapshot) -> None:
        """Replace the present snapshot. Later snapshots are dropped."""
        self._snapshots[self.cursor :] = [snapshot]

    def scrub(self, motion: int) -> bool:
        """Show the snapshot after a number of motions, or the one that stands for it. Return False if there is none."""
        if not 0 <= motion < len(self._snapshots):
            return False
        self.cursor = self._snapshots[motion].motion
        return True

    def _let_go(self, first: int) -> None:
        """Drop the computed quantities of STRIDE motions from `first` on."""
        if first < 0:
            return
        for motion in range(first, first + STRIDE):
            one = self._snapshots[motion]
            if one.motion != motion:  # it stands for this one
                self._snapshots[motion] = self._snapshots[one.motion]
            elif COMPUTED & vars(one).keys():
                self._snapshots[motion] = replace(one)

    def _thin(self) -> None:
        """Let each old snapshot that is kept stand for those until the next kept one."""
        old, stride = 0 if self._dense is None else self.cursor - self._dense - EARLY, STRIDE
        while old >= MAX_OLD * stride:
            stride *= 2
        for first in range(EARLY, EARLY + old - stride + 1, stride):
            self._snapshots[first + 1 : first + stride] = [self._snapshots[first]] * (stride - 1)
