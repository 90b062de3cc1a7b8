"""What noise in the images leaves open of kinematics that were fitted to them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .adjustment import Adjustment, products
from .clusters import Seen
from .model import ProjectiveKinematics

NOTHING = 1e-12  # of the largest eigenvalue, below which nothing is told


@dataclass(frozen=True)
class Information:
    """For noise of 1 px: root: (P, P), of the covariance of the parameters; follow: (N, 3, P), how each point goes with
    them; alone: (N, 3, 3), root of its covariance when they are known."""

    root: NDArray
    follow: NDArray
    alone: NDArray

    @classmethod
    def of(cls, kinematics: ProjectiveKinematics, seen: Seen) -> "Information":
        seen = seen.only(~kinematics.unknown)
        all_visits = Adjustment(seen, np.zeros((*seen.whole.shape, 3)), 1.0)
        parameters = len(kinematics.parameters)
        A, B, C = products(all_visits.derivatives(kinematics, all_visits.left(kinematics)), parameters)
        follow = -np.linalg.pinv(C, hermitian=True) @ B.swapaxes(1, 2)
        left = A + np.diag(all_visits.prior(parameters)) + np.tensordot(B, follow, ([0, 2], [0, 1]))
        return cls(_inverse_root(left), follow, _inverse_root(C))

    def draws(self, rng: np.random.Generator, count: int, size: float) -> tuple[NDArray, NDArray]:
        """What such noise, times `size`, adds to the parameters, (count, P), and to the points, (count, N, 3)."""
        parameters = size * rng.standard_normal((count, len(self.root))) @ self.root.T
        alone = size * rng.standard_normal((count, len(self.alone), 1, 3)) @ self.alone.swapaxes(-1, -2)
        return parameters, np.tensordot(parameters, self.follow, ([1], [2])) + alone[:, :, 0]

    def columns(self, size: float) -> tuple[NDArray, NDArray]:
        """The same one by one, (P + 3, ...): squares of what they make add up to variances."""
        parameters = size * np.vstack([self.root.T, np.zeros((3, len(self.root)))])
        points = np.tensordot(parameters, self.follow, ([1], [2]))
        points[-3:] = size * np.moveaxis(self.alone, -1, 0)
        return parameters, points


def _inverse_root(matrix: NDArray) -> NDArray:
    """R of (..., k, k), R Rᵀ its inverse along what is told, 0 along what is not."""
    values, vectors = np.linalg.eigh(matrix)
    told = values > NOTHING * values[..., -1:]
    return vectors * np.where(told, 1 / np.sqrt(np.where(told, values, 1.0)), 0.0)[..., None, :]
