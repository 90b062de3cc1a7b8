"""What a run of the loop returns: why it ended, and what it took."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .snapshot import AT_REST, Snapshot

OUT_OF_MOTIONS = "max_motions"
WHY = {
    "converged": "the learner claims to have arrived",
    "rests": "it rests, without evidence of having arrived",
    "untold": "some joint is not told",
    "stalled": "stalled",
    "stopped": "too few points are seen in all four images",
    OUT_OF_MOTIONS: "no more motions",
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
        return f"RunResult(status={self.status!r}, motions={self.motions}, travel_deg={self.travel_deg:.4g})"

    @property
    def status(self) -> str:
        """Of the servo: converged, rests, untold or stalled; else stopped, for want of points, or max_motions."""
        if self.last.status in AT_REST:
            return self.last.status
        return "stopped" if self.last.transfer is None else OUT_OF_MOTIONS

    @property
    def success(self) -> bool:
        """Whether the learner claims to have arrived."""
        return self.status == "converged"

    @property
    def message(self) -> str:
        """Why it ended, in a line."""
        why = "no motion was made" if self.status == OUT_OF_MOTIONS and self.last.motion == 0 else WHY[self.status]
        says = self.last.servo.says(self.last.servo_state, self.last.status) if self.status == "stalled" else ""
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
