"""What a learner knows of its own images, estimated recursively: ŷ(θ) = y + J (θ - θ_last), and a covariance of J.

A motion h changes a coordinate y by Δy = j·h, j its row of J, and so tells of j (Qian & Su 2002, Piepmeier, McMurray &
Lipkin 2004):

    P' = P + q I,   k = P'h / (r + hᵀP'h),   j ← j + k (Δy - j·h),   P ← (P' - k hᵀP') / λ

q lets J change by itself, r is what is not believed of a motion, λ < 1 forgets. The Kalman filter has λ = 1; recursive
least squares have q = 0 and r = λ; a filter that forgets at every motion how well it knows J, P' = q I, makes
Broyden's update, with soft² = r/q. The rows of a point in one image share P, as they are seen together.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import ResidualFunction
from .image_model import rarely_taught
from .observation import Observation, Visit, by_coordinate

DIFFERENCE = 1e-5  # rad


@dataclass(frozen=True)
class RecursiveJacobian:
    """jacobian: (N, 4, m) px/rad; covariance: (N, 2, m, m) of the rows in [L], in [R]; last: the visit that it is
    about; taught: (N,) how many motions at both ends of which a point was seen; believed: of what the last motion
    showed otherwise than foretold, hᵀk, the mean share that has gone into J."""

    jacobian: NDArray
    covariance: NDArray
    last: Visit
    taught: NDArray
    believed: float = 0.0

    @classmethod
    def start(cls, seen: Observation, variance: float) -> "RecursiveJacobian":
        """Nothing is known yet but the image that is seen. variance: of J, P_0 = variance·I."""
        here, m = Visit.of(seen.displacement, seen.own, seen.seen), len(seen.displacement)
        covariance = np.broadcast_to(variance * np.eye(m), (len(seen.own), 2, m, m)).copy()
        return cls(np.zeros((*seen.own.shape, m)), covariance, here, np.zeros(len(seen.own), int))

    def learn(self, seen: Observation, r: float, q: float = 0.0, forgetting: float = 1.0) -> "RecursiveJacobian":
        """From the motion made since. r, q, forgetting: see the module; r in the unit of hᵀPh."""
        h = seen.displacement - self.last.displacement
        now = by_coordinate(seen.seen)
        expected = self.last.own + self.jacobian @ h
        here = Visit(seen.displacement, np.where(now, seen.own, expected), seen.seen)
        if not h.any():
            return RecursiveJacobian(self.jacobian, self.covariance, here, self.taught, self.believed)
        both = seen.seen & self.last.seen
        P = self.covariance + q * np.eye(len(h))
        Ph = P @ h
        k = Ph / (r + Ph @ h)[..., None]
        surprise = np.where(by_coordinate(both), seen.own - expected, 0.0)
        jacobian = self.jacobian + np.repeat(k, 2, axis=1) * surprise[..., None]
        learned = (P - k[..., None] * Ph[..., None, :]) / forgetting
        covariance = np.where(both[..., None, None], learned, P)
        believed = float((k @ h)[both].mean()) if both.any() else 0.0
        return RecursiveJacobian(jacobian, covariance, here, self.taught + both.all(-1), believed)

    def linearised(self, residuals: ResidualFunction) -> tuple[NDArray, NDArray]:
        """The residual here, (k,) px, and its derivative by the displacement, (k, m) px/rad: what it would be is asked
        of images a little aside, so that the transfer's own derivative is in it. inf with too few points."""
        m = self.jacobian.shape[-1]
        told = np.where(rarely_taught(self.taught, m)[:, None], np.nan, self.last.own)
        aside = DIFFERENCE * np.moveaxis(self.jacobian, -1, 0)
        e = residuals(told + np.concatenate([np.zeros((1, *told.shape)), aside])).reshape(m + 1, -1)
        if not np.isfinite(e).all():
            return np.full(1, np.inf), np.zeros((1, m))
        return e[0], ((e[1:] - e[0]) / DIFFERENCE).T
