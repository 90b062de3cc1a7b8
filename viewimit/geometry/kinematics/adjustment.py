"""Kinematics from images, all visits together: bundle adjustment over the frame, the twists and the points.

Levenberg and Marquardt's steps on what is left in the images, the points eliminated from each by Schur's complement
(Triggs et al. 2000). It needs no good start: the affine frame and joints that do not turn will do.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .model import FRAME, ProjectiveKinematics
from .seen import Seen

STEP = 1e-6  # of difference quotients
ROUNDS, RETRIES = 30, 6
FIRST_DAMPING, LESS, MORE = 1e-3, 0.1, 10.0
GAIN, NOTHING = 1e-3, 1e-9  # share of what is left, that a round must gain; px, rms, that is nothing
STEADY = 1e-9  # of the normal equations' diagonal, added to it
AFFINE = 3.0  # standard deviation of the frame's parameters, where noise leaves them open
EXACT = 1e-2  # px, rms of what images without noise may leave
SURELY, SLACK = 4.0, 1.2  # standard deviations of the mean square; times the noise, as that is measured itself


@dataclass(frozen=True)
class Adjustment:
    """seen: of known points alone; coordinates: (K, N, 3), of these images in the kinematics' frame; noise_px: of an
    image coordinate, standard deviation."""

    seen: Seen
    coordinates: NDArray
    noise_px: float

    @property
    def least_px(self) -> float:
        return max(self.noise_px, EXACT)

    @property
    def freedom(self) -> int:
        """Coordinates that the parameters and points do not fit by themselves."""
        parameters = FRAME + 6 * self.seen.displacement.shape[1]
        return 3 * (int(np.count_nonzero(self.seen.whole)) - self.seen.points) - parameters

    def of_known(self, found: ProjectiveKinematics) -> "Adjustment":
        """To the images of those points alone of which it knows."""
        return replace(self, seen=self.seen.only(~found.unknown))

    def left(self, found: ProjectiveKinematics) -> NDArray:
        """(..., K, N, 3) px, 0 of what was not seen. found: with (..., P) parameters and (..., N, 3) points."""
        off = found.coordinates(self.seen.displacement) - self.coordinates
        return np.where(self.seen.whole[..., None], off * found.frame.spread, 0.0)

    def squares(self, found: ProjectiveKinematics) -> NDArray:
        """(N,) px², the mean square of what is left of each point, a coordinate."""
        return (self.left(found) ** 2).sum((0, 2)) / np.maximum(3 * self.seen.whole.sum(0), 1)

    def explained(self, found: ProjectiveKinematics) -> bool:
        """Whether what is left is noise."""
        freedom = max(self.freedom, 1)
        mean = float((self.left(found) ** 2).sum()) / freedom
        return mean < (SLACK * self.least_px) ** 2 * (1 + SURELY * np.sqrt(2 / freedom))

    def adjusted(self, begun: ProjectiveKinematics) -> ProjectiveKinematics | None:
        """The nearest to all images from there; None if it does not explain them."""
        found, prior = begun, self.prior(len(begun.parameters))
        left, damping = self.left(found), FIRST_DAMPING
        square = float((left**2).sum() + prior @ found.parameters**2)
        for _ in range(ROUNDS):
            if square < left.size * NOTHING**2:
                break
            stepped, gained = self._stepping(found, left, prior), 0.0
            for _ in range(RETRIES):
                trial = stepped(damping)
                trial_left = self.left(trial)
                gained = square - float((trial_left**2).sum() + prior @ trial.parameters**2)
                if gained > 0:
                    break
                damping *= MORE
            if not gained > 0:
                break
            found, left, square, damping = trial, trial_left, square - gained, damping * LESS
            if gained < GAIN * square:
                break
        return found if self.explained(found) else None

    def prior(self, parameters: int) -> NDArray:
        """(P,) px², weights: what noise leaves open of the frame is as in an affine one."""
        weights = np.zeros(parameters)
        weights[:FRAME] = (self.noise_px / AFFINE) ** 2
        return weights

    def derivatives(self, found: ProjectiveKinematics, left: NDArray) -> NDArray:
        """(P + 3, K, N, 3) px: of what is left, by each parameter, and by each coordinate of its point."""
        P = len(found.parameters)
        parameters = found.parameters + STEP * np.eye(P + 3, P)
        shape = found.shape + STEP * np.eye(P + 3, 3, -P)[:, None, :]
        return np.nan_to_num((self.left(replace(found, parameters=parameters, shape=shape)) - left) / STEP)

    def _stepping(
        self, found: ProjectiveKinematics, left: NDArray, prior: NDArray
    ) -> Callable[[float], ProjectiveKinematics]:
        """A damping → where the linear model there leads."""
        J, P = self.derivatives(found, left), len(found.parameters)
        A, B, C = products(J, P)
        A = A + np.diag(prior)
        g = J[:P].reshape(P, -1) @ left.ravel() + prior * found.parameters
        h = np.einsum("akni,kni->na", J[P:], left)
        own, of_points = np.diag(A), np.einsum("naa->na", C)

        def stepped(damping: float) -> ProjectiveKinematics:
            raised = damping * of_points + STEADY * of_points.sum(1, keepdims=True) + np.finfo(float).tiny
            inverse = np.linalg.inv(C + raised[..., None] * np.eye(3))
            BC = B @ inverse
            reduced = A + np.diag(damping * own + STEADY * own.mean()) - np.tensordot(BC, B, ([0, 2], [0, 2]))
            step = np.linalg.solve(reduced, np.tensordot(BC, h, ([0, 2], [0, 1])) - g)
            shape = found.shape - np.einsum("nab,nb->na", inverse, h + np.tensordot(B, step, ([1], [0])))
            return replace(found, parameters=found.parameters + step, shape=shape)

        return stepped


def products(J: NDArray, parameters: int) -> tuple[NDArray, NDArray, NDArray]:
    """The normal equations of derivatives (P + 3, K, N, 3): A (P, P) of the parameters, C (N, 3, 3) of the points,
    B (N, P, 3) of both."""
    of_all = J[:parameters].reshape(parameters, -1)
    by_point = np.moveaxis(J, 2, 0).reshape(J.shape[2], len(J), -1)
    both = by_point @ by_point[:, parameters:].swapaxes(1, 2)
    return of_all @ of_all.T, both[:, :parameters], both[:, parameters:]
