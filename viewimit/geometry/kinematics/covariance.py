"""Covariance of kinematics that were fitted to noisy images, from the inverse of the normal equations.

The points are eliminated by the Schur complement, as in `adjustment`: for noise of 1 px the parameters have the
covariance (A - B C⁻¹ Bᵀ)⁻¹. A point follows them by -C⁻¹ Bᵀ, and has the covariance C⁻¹ in addition.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .adjustment import BundleAdjustment, normal_equations
from .clusters import Observations
from .model import ProjectiveKinematics

MIN_EIGENVALUE = 1e-12  # relative to the largest: below it a direction is not determined


@dataclass(frozen=True)
class KinematicsCovariance:
    """Uncertainty of parameters and points for image noise of 1 px."""

    sqrt_cov: NDArray[np.float64]  # (P, P): square root of the covariance of the parameters
    point_gain: NDArray[np.float64]  # (N, 3, P): change of each point with the parameters
    point_sqrt_cov: NDArray[np.float64]  # (N, 3, 3): square root of its covariance when the parameters are known

    @classmethod
    def estimate(cls, kinematics: ProjectiveKinematics, observations: Observations) -> "KinematicsCovariance":
        """Estimate it from the visits to which the kinematics were fitted."""
        observations = observations.restrict(~kinematics.unknown)
        problem = BundleAdjustment(observations, np.zeros((*observations.visible_in_both.shape, 3)), 1.0)
        P = len(kinematics.parameters)
        A, B, C = normal_equations(problem.jacobian(kinematics, problem.residuals(kinematics)), P)
        gain = -np.linalg.pinv(C, hermitian=True) @ B.swapaxes(1, 2)
        schur = A + np.diag(problem.prior_weights(P)) + np.tensordot(B, gain, ([0, 2], [0, 1]))
        return cls(_sqrt_inverse(schur), gain, _sqrt_inverse(C))

    def sample(
        self, rng: np.random.Generator, count: int, noise_px: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Draw errors of the parameters, (count, P), and of the points, (count, N, 3)."""
        parameters = noise_px * rng.standard_normal((count, len(self.sqrt_cov))) @ self.sqrt_cov.T
        own = noise_px * rng.standard_normal((count, len(self.point_sqrt_cov), 1, 3))
        own = own @ self.point_sqrt_cov.swapaxes(-1, -2)
        return parameters, np.tensordot(parameters, self.point_gain, ([1], [2])) + own[:, :, 0]

    def columns(self, noise_px: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Errors of parameters, (P + 3, P), and points, (P + 3, N, 3), whose squares add up to the variances."""
        parameters = noise_px * np.vstack([self.sqrt_cov.T, np.zeros((3, len(self.sqrt_cov)))])
        points = np.tensordot(parameters, self.point_gain, ([1], [2]))
        points[-3:] = noise_px * np.moveaxis(self.point_sqrt_cov, -1, 0)
        return parameters, points


def _sqrt_inverse(matrix: NDArray) -> NDArray:
    """R of (..., k, k) with R Rᵀ its pseudo-inverse."""
    values, vectors = np.linalg.eigh(matrix)
    determined = values > MIN_EIGENVALUE * values[..., -1:]
    return vectors * np.where(determined, 1 / np.sqrt(np.where(determined, values, 1.0)), 0.0)[..., None, :]
