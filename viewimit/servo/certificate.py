"""What a servo says of its estimate: the standard error of each joint, and which joints the images leave open."""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

MAX_STD_PER_PX = float(np.radians(20.0))  # rad/px: a joint that noise of 1 px turns by more is unobservable


@dataclass(frozen=True)
class Certificate:
    """The standard errors of an estimate of the demonstrator's posture."""

    std_error: NDArray[np.float64]  # (m,) rad, standard deviation of each joint error; inf for unobservable joints
    std_per_px: NDArray[np.float64]  # (m,) rad/px, of each joint by image noise of 1 px

    @property
    def observable(self) -> NDArray[np.bool_]:
        """(m,): joints that the images determine."""
        return np.isfinite(self.std_error)

    @property
    def simultaneous_std_error(self) -> float:
        """Standard error s [rad] such that 2 s bounds the largest joint error with the probability of 2 σ (Šidák).

        Source: Šidák, "Rectangular confidence regions for the means of multivariate normal distributions", JASA 1967.
        """
        normal = NormalDist()
        together = 2 * normal.cdf(2.0) - 1
        quantile = normal.inv_cdf((1 + together ** (1 / len(self.std_error))) / 2)
        return float(self.std_error.max() * quantile / 2)

    @property
    def unobservable_joints(self) -> list[int]:
        """Indices of the unobservable joints, the worst first."""
        return [int(j) for j in np.argsort(-self.std_per_px, kind="stable") if not self.observable[j]]
