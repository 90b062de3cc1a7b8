"""The moments of a session in order of their motions, and the one of them that it is at."""

from collections.abc import Iterable, Iterator, Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from .snapshot import Snapshot

MAX_HISTORY = 100_000  # motions a session makes
RECENT = 64  # of the last motions, transfer and residuals stay as they were computed; those of older ones are let go
EARLY = 64  # of the first motions, which are the longest, all are kept
STRIDE, MOST_OLD = 32, 64  # of motions long past one in so many is kept, if not all are, and so many of them at most


class History(Sequence[Snapshot]):
    """moments: by motion, from 0 on; cursor: the motion that the session is at; joints: numbers of those that move, by
    which columns are named, 1, 2, … if None.

    dense: how many of the last motions are kept, None for all. Of older ones the EARLY first are, and then every
    STRIDE-th, which stands in place of those after it; every second one of these as soon as they are MOST_OLD, and so
    on: a history of whatever length takes no more memory.
    """

    def __init__(
        self,
        moments: Iterable[Snapshot],
        cursor: int = 0,
        dense: int | None = None,
        joints: Sequence[int] | None = None,
    ):
        self.joints = joints
        self._moments, self.cursor, self._dense = list(moments), cursor, dense
        for first in range(0, cursor - RECENT - STRIDE + 1, STRIDE):
            self._let_go(first)
        self._thin()

    def __len__(self) -> int:
        return len(self._moments)

    def __iter__(self) -> Iterator[Snapshot]:
        return iter(self._moments)

    @overload
    def __getitem__(self, index: int) -> Snapshot: ...
    @overload
    def __getitem__(self, index: slice) -> list[Snapshot]: ...
    def __getitem__(self, index: int | slice) -> Snapshot | list[Snapshot]:
        return self._moments[index]

    @property
    def present(self) -> Snapshot:
        """The moment that the cursor is on."""
        return self._moments[self.cursor]

    @property
    def imitation_motions(self) -> int:
        """The number of motions up to the present, without those of a rehearsal and before it."""
        if self.present.pending_postures is None:
            return self.present.motion
        past = reversed(self._moments[: self.cursor + 1])
        last = next((moment.motion + 1 for moment in past if moment.is_rehearsing), 0)
        return max(self.present.motion - last, 0)

    def recent(self, count: int) -> list[Snapshot]:
        """The last moments up to the present, at most `count`, the present one last."""
        return self._moments[max(self.cursor + 1 - count, 0) : self.cursor + 1]

    def arrays(self) -> dict[str, NDArray]:
        """Columns of one value a motion, (K,) each, of the K moments that are kept.

        motion; by joint theta2_deg, demonstrator2_deg (the truth, NaN where nobody knows it) and moved2_deg, the motion
        that led there; E_px2; usable, the number of points seen in all views; probe; status.
        """
        kept = [moment for k, moment in enumerate(self._moments) if moment.motion == k]  # others stand in for some
        joints = self.joints or range(1, len(kept[0].theta) + 1)
        angles = {
            "theta": [moment.theta for moment in kept],
            "demonstrator": [moment.theta_demo for moment in kept],
            "moved": [moment.moved for moment in kept],
        }
        by_joint = {
            f"{name}{joint}_deg": column
            for name, values in angles.items()
            for joint, column in zip(joints, np.degrees(values).T)
        }
        return {
            "motion": np.array([moment.motion for moment in kept]),
            **by_joint,
            "E_px2": np.array([moment.E for moment in kept]),
            "usable": np.array([int(moment.usable.sum()) for moment in kept]),
            "probe": np.array([bool(moment.probe) for moment in kept]),
            "status": np.array([moment.status for moment in kept]),
        }

    def table(self) -> list[dict[str, Any]]:
        """A row a motion, with the columns of `arrays`: for csv.DictWriter, or for pandas.DataFrame."""
        columns = self.arrays()
        return [dict(zip(columns, row)) for row in zip(*(column.tolist() for column in columns.values()))]

    def append(self, moment: Snapshot) -> None:
        """One motion on from the present; what came later is dropped."""
        self.cursor += 1
        self._moments[self.cursor :] = [moment]
        if self.cursor % STRIDE == 0:
            self._let_go(self.cursor - RECENT - STRIDE)
        if self._dense is not None and (self.cursor - self._dense) % STRIDE == 0:
            self._thin()

    def replace(self, moment: Snapshot) -> None:
        """Put a moment in place of the present; what came later is dropped."""
        self._moments[self.cursor :] = [moment]

    def undo(self) -> bool:
        """One motion back; the later ones stay. False at the start."""
        return self.scrub(self.cursor - 1)

    def scrub(self, motion: int) -> bool:
        """To the moment after that many motions, or the one that stands in its place. False if there is none."""
        if not 0 <= motion < len(self._moments):
            return False
        self.cursor = self._moments[motion].motion
        return True

    def _let_go(self, first: int) -> None:
        """Of STRIDE motions from `first` on, keep what does not follow from the rest. Who holds one keeps all of it."""
        if first < 0:
            return
        for motion in range(first, first + STRIDE):
            moment = self._moments[motion]
            stands_for_another = moment.motion != motion
            self._moments[motion] = self._moments[moment.motion] if stands_for_another else moment.without_cache()

    def _thin(self) -> None:
        """Let each of the old moments that are kept stand for those until the next one."""
        old, stride = 0 if self._dense is None else self.cursor - self._dense - EARLY, STRIDE
        while old >= MOST_OLD * stride:
            stride *= 2
        for first in range(EARLY, EARLY + old - stride + 1, stride):
            self._moments[first + 1 : first + stride] = [self._moments[first]] * (stride - 1)
