"""Image Jacobians learned from the learner's own motions: ŷ(θ) = y + J (θ - θ_last).

A motion h changes an image coordinate by Δy = j·h, with j its row of J. Points that were hidden at one end of a motion
teach nothing of J.

`BroydenModel` makes Broyden's rank-one updates. `RecursiveJacobian` also keeps a covariance P of each row:

    P' = P + q I,   k = P'h / (r + hᵀP'h),   j ← j + k (Δy - j·h),   P ← (P' - k hᵀP') / λ.

q is the drift of J, r the variance of Δy, and λ < 1 forgets. The Kalman filter has λ = 1. Recursive least squares have
q = 0 and r = λ. Without memory, P' = q I, the update is Broyden's, with soft² = r/q. The rows of a point in one image
share P, as they are visible together.

References
----------
Broyden, "A class of methods for solving nonlinear simultaneous equations", 1965.
Qian and Su, "Online estimation of image Jacobian matrix by Kalman-Bucy filter", ICRA 2002.
Piepmeier, McMurray and Lipkin, "Uncalibrated dynamic visual servoing", IEEE Trans. Robotics and Automation 20(1), 2004.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import ResidualFunction
from .observation import Observation, Visit, repeat_xy

MIN_WELL_SEEN = 12  # points: if as many are seen often enough, rarely seen ones are left out
SOFT_RAD = np.radians(0.2)  # motions up to about this size teach less, as they are mostly noise
FD_STEP_RAD = 1e-5
MIN_STEP_RAD = np.radians(0.1)  # shorter motions are not made
MAX_STEP_RAD = np.radians(10.0)  # of a joint, in one motion towards target images
DAMPING = 1e-6  # of the normal equations, relative to their trace: keeps still what the images do not determine


@dataclass(frozen=True)
class BroydenModel:
    """Image Jacobian with Broyden's updates."""

    jacobian: NDArray[np.float64]  # (N, 4, m) px/rad: J_u of Eq. (8)
    last: Visit  # about which it is linear
    n_updates: NDArray[np.int_]  # (N,): motions at both ends of which the point was seen

    @property
    def rarely_seen(self) -> NDArray[np.bool_]:
        """(N,): points of whose motion too little is known."""
        return is_rarely_seen(self.n_updates, self.jacobian.shape[-1])

    @classmethod
    def start(cls, observation: Observation) -> "BroydenModel":
        """Begin with J = 0 at the first observation."""
        here = Visit.of(observation.displacement, observation.own, observation.seen)
        jacobian = np.zeros(observation.own.shape + observation.displacement.shape)
        return cls(jacobian, here, np.zeros(len(observation.own), int))

    def update(self, observation: Observation, soft: float = SOFT_RAD) -> "BroydenModel":
        """Learn from the last motion. soft: rad, 0 to learn from tiny motions as well as from others."""
        moved = observation.displacement - self.last.displacement
        length = moved @ moved
        now = repeat_xy(observation.seen)
        expected = self.last.own + self.jacobian @ moved
        jacobian, n_updates = self.jacobian, self.n_updates
        if length > 0:
            both = now & repeat_xy(self.last.seen)
            innovation = np.where(both, observation.own - expected, 0.0)
            n_updates = n_updates + both.all(-1)
            jacobian = jacobian + innovation[..., None] * moved / (length + soft**2)
        own = np.where(now, observation.own, expected)
        return BroydenModel(jacobian, Visit(observation.displacement, own, observation.seen), n_updates)

    def predict(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Images (N, 4) px at (m,) rad."""
        return self.last.own + self.jacobian @ (displacement - self.last.displacement)

    def step_towards(
        self, observation: Observation, target: NDArray[np.float64], followed: NDArray[np.bool_]
    ) -> NDArray[np.float64]:
        """Return the motion, (m,) rad, that brings the own points to target images: image-based visual servoing.

        It is the damped least-squares solution over the followed points that are visible, shortened to one motion and
        kept inside the joint limits (the paper's Section 5.4).

        Parameters
        ----------
        observation : Observation
            The last one, which the model has been updated with.
        target : (N, 4) array
            Where the points should be in [L, R] [px].
        followed : (N,) bool array
            Points to bring there.
        """
        used = repeat_xy(observation.seen) & followed[:, None] & np.isfinite(target)
        J, error = self.jacobian[used], (target - observation.own)[used]
        normal = J.T @ J
        normal = normal + np.eye(len(normal)) * (DAMPING * np.trace(normal) + 1e-12)
        step = np.linalg.solve(normal, J.T @ error)
        step *= min(1.0, min(MAX_STEP_RAD, observation.max_step) / max(np.max(np.abs(step)), 1e-12))
        here = observation.displacement
        return np.clip(step, observation.lower - here, observation.upper - here)


@dataclass(frozen=True)
class RecursiveJacobian:
    """Image Jacobian with the covariance of its rows."""

    jacobian: NDArray[np.float64]  # (N, 4, m) px/rad
    covariance: NDArray[np.float64]  # (N, 2, m, m): of the rows in [L], in [R]
    last: Visit  # about which it is linear
    n_updates: NDArray[np.int_]  # (N,): motions at both ends of which the point was seen
    mean_gain: float = 0.0  # mean of hᵀk at the last motion: share of the innovations that J has absorbed

    @classmethod
    def start(cls, observation: Observation, variance: float) -> "RecursiveJacobian":
        """Begin with J = 0 and P = variance I at the first observation."""
        here = Visit.of(observation.displacement, observation.own, observation.seen)
        m = len(observation.displacement)
        covariance = np.broadcast_to(variance * np.eye(m), (len(observation.own), 2, m, m)).copy()
        jacobian = np.zeros((*observation.own.shape, m))
        return cls(jacobian, covariance, here, np.zeros(len(observation.own), int))

    def update(
        self, observation: Observation, r: float, q: float = 0.0, forgetting: float = 1.0
    ) -> "RecursiveJacobian":
        """Learn from the last motion. r, q, forgetting: see the module; r in the unit of hᵀPh."""
        h = observation.displacement - self.last.displacement
        now = repeat_xy(observation.seen)
        expected = self.last.own + self.jacobian @ h
        here = Visit(observation.displacement, np.where(now, observation.own, expected), observation.seen)
        if not h.any():
            return RecursiveJacobian(self.jacobian, self.covariance, here, self.n_updates, self.mean_gain)
        both = observation.seen & self.last.seen
        P = self.covariance + q * np.eye(len(h))
        Ph = P @ h
        k = Ph / (r + Ph @ h)[..., None]
        innovation = np.where(repeat_xy(both), observation.own - expected, 0.0)
        jacobian = self.jacobian + np.repeat(k, 2, axis=1) * innovation[..., None]
        updated = (P - k[..., None] * Ph[..., None, :]) / forgetting
        covariance = np.where(both[..., None, None], updated, P)
        mean_gain = float((k @ h)[both].mean()) if both.any() else 0.0
        return RecursiveJacobian(jacobian, covariance, here, self.n_updates + both.all(-1), mean_gain)

    def linearise(self, residuals: ResidualFunction) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Residuals here, (k,) px, and their derivatives by the displacement, (k, m) px/rad.

        The residual function is evaluated at stepped images, so that the derivative of the transfer is included.
        Residuals are inf if too few points are known.
        """
        m = self.jacobian.shape[-1]
        known = np.where(is_rarely_seen(self.n_updates, m)[:, None], np.nan, self.last.own)
        steps = FD_STEP_RAD * np.moveaxis(self.jacobian, -1, 0)
        e = residuals(known + np.concatenate([np.zeros((1, *known.shape)), steps])).reshape(m + 1, -1)
        if not np.isfinite(e).all():
            return np.full(1, np.inf), np.zeros((1, m))
        return e[0], ((e[1:] - e[0]) / FD_STEP_RAD).T


def is_rarely_seen(n_updates: NDArray[np.int_], n_joints: int) -> NDArray[np.bool_]:
    """(N,): points with fewer updates than joints, if enough other points have as many."""
    return n_updates < min(n_joints, np.sort(n_updates)[-min(MIN_WELL_SEEN, len(n_updates))])
