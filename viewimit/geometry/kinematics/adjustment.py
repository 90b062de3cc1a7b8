"""Bundle adjustment of projective kinematics to the images of all visits (Triggs et al. 2000).

The parameters of frame and twists and all points are adjusted together (`bundle`). It needs no good initial values: it
starts from an affine frame and joints that turn nothing.

References
----------
Triggs, McLauchlan, Hartley and Fitzgibbon, "Bundle adjustment: a modern synthesis", 2000.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .bundle import jacobian, levenberg_marquardt, normal_equations, sqrt_inverse
from .clusters import Observations
from .model import N_FRAME, PLANE, ProjectiveKinematics, StereoFrame

PRIOR_STD = 3.0  # of the frame's scales and shears, where noise leaves them open
PLANE_PRIOR_STD = 0.5  # of its plane at infinity: beyond, points at two deviations are not before the cameras
NOISE_FLOOR_PX = 1e-2  # rms residual that is accepted without noise
FIT_SIGMA, NOISE_SLACK = 4.0, 1.2  # standard deviations of the mean square; factor, as the noise is an estimate itself

MAX_OFF_PLANE_SIGMA = 3.0  # rms distance of parallel cameras' images from a hyperplane, in standard deviations
MIN_POINTS = 4  # that span a space
NEAR_RAD = np.radians(40.0)  # of visits near the first one, which are adjusted first


@dataclass(frozen=True)
class BundleAdjustment:
    """Least-squares problem of fitting kinematics to images."""

    observations: Observations  # of known points alone
    coordinates: NDArray[np.float64]  # (K, N, 3): of the images in the kinematics' frame
    noise_px: float  # standard deviation of an image coordinate
    magnification: NDArray[np.float64]  # (K, N, 1): of that noise by the rectification

    @classmethod
    def of(cls, kinematics: ProjectiveKinematics, observations: Observations, noise_px: float) -> "BundleAdjustment":
        """Set it up for images that are rectified as the kinematics are."""
        images = np.where(observations.visible_in_both[..., None], observations.images, 0.0)
        return cls(observations, kinematics.coordinates_of(images), noise_px, kinematics.magnification(images))

    def select_visits(self, visits: NDArray[np.bool_]) -> "BundleAdjustment":
        """Keep some visits, (K,) bool."""
        seen, at, enlarged = self.observations.select_visits(visits), self.coordinates, self.magnification
        return BundleAdjustment(seen, at[visits], self.noise_px, enlarged[visits])

    @property
    def noise_floor_px(self) -> float:
        """Noise, but at least the rms residual that is accepted without noise [px]."""
        return max(self.noise_px, NOISE_FLOOR_PX)

    @property
    def degrees_of_freedom(self) -> int:
        """Number of coordinates minus the number of parameters and point coordinates."""
        parameters = N_FRAME + 6 * self.observations.displacement.shape[1]
        n_images = int(np.count_nonzero(self.observations.visible_in_both))
        return 3 * (n_images - self.observations.n_points) - parameters

    def restricted_to_known(self, kinematics: ProjectiveKinematics) -> "BundleAdjustment":
        """Keep the images of the points that the kinematics know."""
        return replace(self, observations=self.observations.restrict(~kinematics.unknown))

    def residuals(
        self, kinematics: ProjectiveKinematics, displacement: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Predicted minus observed coordinates, (..., K, N, 3) px as seen, 0 of images that were not seen.

        The kinematics may be several at once, with (..., P) parameters and (..., N, 3) points. displacement: where the
        arm was instead, (..., K, m) rad.
        """
        at = self.observations.displacement if displacement is None else displacement
        difference = kinematics.coordinates(at) - self.coordinates
        pixels = difference * (kinematics.frame.unit_px / self.magnification)
        return np.where(self.observations.visible_in_both[..., None], pixels, 0.0)

    def fits_noise(self, kinematics: ProjectiveKinematics) -> bool:
        """Whether noise explains the residuals (chi-square test of their mean square)."""
        freedom = max(self.degrees_of_freedom, 1)
        mean = float((self.residuals(kinematics) ** 2).sum()) / freedom
        return mean < (NOISE_SLACK * self.noise_floor_px) ** 2 * (1 + FIT_SIGMA * np.sqrt(2 / freedom))

    def solve(self, initial: ProjectiveKinematics) -> ProjectiveKinematics | None:
        """Minimise the residuals from these initial kinematics; None if noise does not explain the minimum."""
        found = levenberg_marquardt(initial, self.residuals, self.prior_weights(len(initial.parameters)))
        return found if self.fits_noise(found) else None

    def prior_weights(self, n_parameters: int) -> NDArray[np.float64]:
        """(P,) px²: weights of the squared parameters, of a prior on the frame that is centred on an affine one.

        All points are before the cameras. Their coordinates have unit variance, so the plane at infinity is near.
        """
        weights = np.zeros(n_parameters)
        weights[:N_FRAME] = (self.noise_px / PRIOR_STD) ** 2
        weights[PLANE] = (self.noise_px / PLANE_PRIOR_STD) ** 2
        return weights


def is_of_parallel_cameras(frame: StereoFrame, noise_px: float) -> bool:
    """Whether noise explains how far the images are from those of parallel cameras."""
    return frame.rms_off_plane_px <= max(NOISE_FLOOR_PX, MAX_OFF_PLANE_SIGMA * noise_px)


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
        problem = BundleAdjustment.of(kinematics, observations, 1.0)
        P = len(kinematics.parameters)
        A, B, C = normal_equations(jacobian(kinematics, problem.residuals, problem.residuals(kinematics)), P)
        gain = -np.linalg.pinv(C, hermitian=True) @ B.swapaxes(1, 2)
        schur = A + np.diag(problem.prior_weights(P)) + np.tensordot(B, gain, ([0, 2], [0, 1]))
        return cls(sqrt_inverse(schur), gain, sqrt_inverse(C))

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
