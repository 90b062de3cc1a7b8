"""What a run of the loop returns: why it ended, and what it took."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..servo.status import ServoStatus
from .snapshot import Snapshot

WHY = {
    ServoStatus.CONVERGED: "the learner claims to have arrived",
    ServoStatus.SETTLED: "it rests, without evidence of having arrived",
    ServoStatus.UNOBSERVABLE: "the points do not determine every joint",
    ServoStatus.NO_PROGRESS: "no progress",
    ServoStatus.TOO_FEW_POINTS: "too few points are seen in all four images",
    ServoStatus.MAX_MOTIONS: "it made as many motions as it was allowed",
}


@dataclass(frozen=True, repr=False)
class RunResult:
    """Why `Session.run` ended, and what it took.

    motions: made in this run; joint_travel: (m,) rad, how far each joint went in them, back and forth; travel: rad, sum
    over the motions of the joint that moved most in each; last: the moment at which it ended.
    """

    motions: int
    travel: float
    joint_travel: NDArray
    last: Snapshot

    def __repr__(self) -> str:
        return f"RunResult(status={self.status.value!r}, motions={self.motions}, travel_deg={self.travel_deg:.4g})"

    @property
    def status(self) -> ServoStatus:
        """Of the servo at rest; else too-few-points or max-motions."""
        if self.last.status.is_at_rest:
            return self.last.status
        return ServoStatus.TOO_FEW_POINTS if self.last.transfer is None else ServoStatus.MAX_MOTIONS

    @property
    def success(self) -> bool:
        """Whether the learner claims to have arrived."""
        return self.status.is_claim

    @property
    def message(self) -> str:
        """Why it ended, in a line."""
        status, last = self.status, self.last
        why = "no motion was made" if status == ServoStatus.MAX_MOTIONS and last.motion == 0 else WHY[status]
        says = last.servo.says(last.servo_state, last.status) if status == ServoStatus.NO_PROGRESS else ""
        return f"{why}: {says}" if says else why

    @property
    def travel_deg(self) -> float:
        """`travel` in degrees."""
        return float(np.degrees(self.travel))

    @property
    def joint_travel_deg(self) -> NDArray:
        """(m,) degrees"""
        return np.degrees(self.joint_travel)

    @property
    def theta(self) -> NDArray:
        """(m,) rad, where the arm stands: the truth, for viewers only."""
        return self.last.theta

    @property
    def E(self) -> float:
        """px², at the end."""
        return self.last.E
