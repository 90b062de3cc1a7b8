"""Image models: predictions of the own images at postures that the arm has not visited.

`ImageData.fit` gives one of two models. Kinematics that explain all visits predict every posture (`KinematicImages`).
Until such kinematics are found, a Gaussian process interpolates the visits (`GaussianProcessImages`); later it still
predicts the points of which the kinematics do not know yet which joints move them.

The noise of the visited images distorts derivatives of E (`estimate_own_noise`). A noisy Jacobian J adds curvature
where there is none, and the gradient Jᵀe is wrong by the noise of both factors. An average of visits gives e, but only
differences of visits give J: visits near each other determine e well, and J hardly at all.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.adjustment import KinematicsCovariance
from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.model import ProjectiveKinematics
from ..least_squares import FD_STEP, fd_steps
from ..observation import Visit
from .gaussian_process import GaussianProcessImages

FD_STEP_RAD = 1e-5  # of differences of predicted images
MIN_CONFIRMING = 4  # visible points that confirm the kinematics at a visit
LINEAR_PX = 1e-3  # noise small enough that predictions are linear in it
N_SAMPLES = 8  # of the noise
BIAS_SIGMA = 2.0  # standard deviations of the noise's curvature that are subtracted with it
MIN_CURVATURE = 1e-9  # relative to the trace of a Hessian: what remains where noise explains a curvature


@dataclass(frozen=True)
class KinematicImages:
    """Images predicted by kinematics that explain all visits."""

    kinematics: ProjectiveKinematics
    centre: NDArray[np.float64]  # (m,) rad: the visit about which predictions are asked for
    observations: Observations  # the visits to which the kinematics were fitted
    noise_px: float  # standard deviation of an image coordinate
    process: GaussianProcessImages | None  # predicts the points unknown to the kinematics; None if there are none
    trusted: bool = False  # whether the kinematics are evidence, as of `convergence`

    @property
    def seen(self) -> NDArray[np.bool_]:
        """(n, N): visible in both images, or predicted at a visit whose visible points confirm the kinematics."""
        confirmed = self.observations.visible_in_both.sum(1, keepdims=True) >= MIN_CONFIRMING
        return self.observations.visible_in_both | (confirmed & self._known[:, 0])

    def impute(self, own: NDArray[np.float64]) -> NDArray[np.float64]:
        """Replace hidden points of the visited images, (n, N, 4) px, by predictions; `seen` says which can be used."""
        visible = self.observations.visible_in_both[..., None]
        return own if visible.all() else np.where(visible, own, self.predict(self.observations.displacement))

    @cached_property
    def at_centre(self) -> NDArray[np.float64]:
        """(N, 4) px."""
        return self.predict(self.centre)

    def predict(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Images (..., N, 4) px at (..., m) rad."""
        images = self.kinematics.predict(displacement)
        return images if self.process is None else np.where(self._known, images, self.process.predict(displacement))

    def restrict(self, points: NDArray[np.bool_]) -> "KinematicImages":
        """Forget all other points, (N,) bool."""
        if points.all():
            return self
        kept = np.where(points[:, None], self.kinematics.points, np.nan)
        process = None if self.process is None else self.process.restrict(points)
        return replace(self, kinematics=replace(self.kinematics, points=kept), process=process)

    def jacobian(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Derivatives of the predicted images, (m, N, 4) px/rad, at (m,) rad, by central differences."""
        steps = FD_STEP_RAD * np.eye(len(displacement))
        ahead, behind = self.predict(np.stack([displacement + steps, displacement - steps]))
        return (ahead - behind) / (2 * FD_STEP_RAD)

    def prediction_std(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Standard deviations of the predictions, (k, N) px, at (k, m) rad; inf for points never seen."""
        std = np.zeros((len(displacement), len(self._known)))
        if self.noise_px > 0:
            columns = self._perturbed(self._covariance.columns(LINEAR_PX)).predict(displacement)
            errors = (columns - self.kinematics.predict(displacement)) * (self.noise_px / LINEAR_PX)
            std = np.sqrt((errors**2).sum(0).mean(-1))
        others = np.inf if self.process is None else self.process.prediction_std(displacement)
        return np.where(self._known[:, 0], std, others)

    def jacobian_std(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """As of the Gaussian process, (N,) px/rad at (m,) rad; 0 for points known to the kinematics."""
        others = np.inf if self.process is None else self.process.jacobian_std(displacement)
        return np.where(self._known[:, 0], 0.0, others)

    def posterior_samples(
        self, displacement: NDArray[np.float64], count: int, seed: Sequence[int]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Draw errors of the images predicted at (m,) rad, and of their derivatives, as the noise of all visits makes.

        Returns arrays of (count, N, 4) px and (count, m, N, 4) px/rad.
        """
        places = displacement + FD_STEP_RAD * np.eye(1 + len(displacement), len(displacement), -1)
        rng = np.random.default_rng(seed)
        errors = self._perturbed(self._covariance.sample(rng, count, LINEAR_PX)).predict(places)
        errors = (errors - self.kinematics.predict(places)) * (self.noise_px / LINEAR_PX)
        images, jacobians = errors[:, 0], (errors[:, 1:] - errors[:, :1]) / FD_STEP_RAD
        if self.process is None:
            return images, jacobians
        noise = self.noise_px * rng.standard_normal((count, len(self.seen), *images.shape[1:]))
        of_images = np.tensordot(self.process.image_weights(displacement), noise, ([0], [1]))
        of_jacobians = np.moveaxis(np.tensordot(self.process.jacobian_weights(displacement), noise, ([0], [1])), 0, 1)
        return np.where(self._known, images, of_images), np.where(self._known, jacobians, of_jacobians)

    def _perturbed(self, errors: tuple[NDArray[np.float64], NDArray[np.float64]]) -> ProjectiveKinematics:
        """Several kinematics at once, with errors of their parameters, (D, P), and points, (D, N, 3)."""
        parameters, points = self.kinematics.parameters + errors[0], self.kinematics.points + errors[1]
        return replace(self.kinematics, parameters=parameters, points=points)

    @cached_property
    def _known(self) -> NDArray[np.bool_]:
        """(N, 1) bool: points known to the kinematics."""
        return ~self.kinematics.unknown[:, None]

    @cached_property
    def _covariance(self) -> KinematicsCovariance:
        return KinematicsCovariance.estimate(self.kinematics, self.observations)


ImageModel = GaussianProcessImages | KinematicImages


@dataclass(frozen=True)
class ImageData:
    """Data from which image models are fitted."""

    visits: Sequence[Visit]
    noise_px: float  # standard deviation of an image coordinate
    kinematics: ProjectiveKinematics | None = None  # that explain all visits, None if none were found
    trusted: bool = False  # as of `KinematicImages`

    def fit(self, centre: int = -1) -> ImageModel:
        """Fit an image model about one of the visits."""
        if self.kinematics is None:
            return self._fit_process(centre)
        process = self._fit_process(centre) if self.kinematics.unknown.any() else None
        there = self.visits[centre].displacement
        return KinematicImages(
            self.kinematics, there, observations_of(self.visits), self.noise_px, process, self.trusted
        )

    def is_rounded(self, at: int = -1) -> bool:
        """Whether some point has exactly the same image at a visit and at another posture."""
        here, others = self.visits[at], [visit for k, visit in enumerate(self.visits) if k != at % len(self.visits)]
        elsewhere = (visit for visit in others if (visit.displacement != here.displacement).any())
        return any(bool((visit.own == here.own).all(-1).any()) for visit in elsewhere)

    def _fit_process(self, centre: int) -> GaussianProcessImages:
        return GaussianProcessImages.fit(self.visits, centre % len(self.visits), self.noise_px)


def observations_of(visits: Sequence[Visit]) -> Observations:
    """Collect the visits in arrays."""
    displacement = np.array([visit.displacement for visit in visits])
    own = np.array([visit.own for visit in visits])
    return Observations(displacement, own, np.all([visit.seen for visit in visits], -1))


@dataclass(frozen=True)
class OwnNoise:
    """Effect of the own images' noise on derivatives of E at a posture."""

    hessian_bias: NDArray[np.float64]  # (m, m) px²/rad²: expected curvature that the noise adds
    grad_samples_images: NDArray[np.float64]  # (k, m) px²/rad: errors of the gradient by noise of the images
    grad_samples_jacobian: NDArray[np.float64]  # (k, m) px²/rad: errors of the gradient by noise of their derivatives
    degrees_of_freedom: int  # of the residuals that make E

    def debias_hessian(self, hessian: NDArray[np.float64]) -> NDArray[np.float64]:
        """Subtract the curvature of noise, plus BIAS_SIGMA deviations, from (..., m, m); keep the rest positive."""
        factor = 1 + BIAS_SIGMA * np.sqrt(2 / self.degrees_of_freedom)
        curvatures, directions = np.linalg.eigh(hessian - factor * self.hessian_bias)
        least = MIN_CURVATURE * np.trace(hessian, axis1=-2, axis2=-1)[..., None]
        return (directions * np.maximum(curvatures, least)[..., None, :]) @ np.swapaxes(directions, -1, -2)


def estimate_own_noise(
    model: ImageModel,
    residuals: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    place: NDArray[np.float64],
    noise_px: float,
    degrees_of_freedom: int,
    seed: Sequence[int],
) -> OwnNoise:
    """Estimate, by drawing noise, how noise of the own images changes the derivatives of E at a posture.

    Parameters
    ----------
    model : ImageModel
        Predicts the own images.
    residuals : callable
        Maps own images (..., N, 4) px to residuals (..., n, C) px.
    place : (m,) array
        Displacement [rad].
    noise_px : float
        Standard deviation of an image coordinate.
    degrees_of_freedom : int
        Of the residuals.
    seed : sequence of int
        Of the noise.
    """
    if isinstance(model, KinematicImages):
        return _kinematic_noise(model, residuals, place, degrees_of_freedom, seed)
    images = model.predict(place + FD_STEP * fd_steps(len(place)))
    noise = np.random.default_rng(seed).standard_normal((N_SAMPLES, *images[0].shape))
    e = residuals(np.concatenate([images, images[0] + noise_px * noise]))
    n_points = e.shape[-2]
    e = e.reshape(len(e), -1)
    J, errors = (e[1 : len(images)] - e[0]) / FD_STEP, e[len(images) :] - e[0]
    mean_square = float((errors**2).sum()) / (N_SAMPLES * n_points)  # px², by the noise of one image
    jacobian_weights, image_weights = model.jacobian_weights(place), model.image_weights(place)
    gradients = np.linalg.norm(image_weights) * errors @ J.T
    by_jacobian = _gradients_by_jacobian(jacobian_weights, errors @ e[0])
    hessian_bias = mean_square * jacobian_weights.T @ jacobian_weights
    return OwnNoise(hessian_bias, gradients / n_points, by_jacobian / n_points, degrees_of_freedom)


def _kinematic_noise(
    model: KinematicImages,
    residuals: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    place: NDArray[np.float64],
    degrees_of_freedom: int,
    seed: Sequence[int],
) -> OwnNoise:
    """As `estimate_own_noise`, where the noise of all visits together moves every image and every derivative."""
    images = model.predict(place + FD_STEP * fd_steps(len(place)))
    image_errors, jacobian_errors = model.posterior_samples(place, N_SAMPLES, seed)
    stepped = FD_STEP * jacobian_errors.reshape(-1, *images[0].shape)
    e = residuals(np.concatenate([images, images[0] + image_errors, images[0] + stepped]))
    n_points = e.shape[-2]
    e = e.reshape(len(e), -1)
    J, by_images, by_jacobian = np.split(e[1:] - e[0], [len(place), len(place) + N_SAMPLES])
    J, by_jacobian = J / FD_STEP, by_jacobian.reshape(N_SAMPLES, len(place), -1) / FD_STEP
    hessian_bias = np.einsum("dik,djk->ij", by_jacobian, by_jacobian) / (N_SAMPLES * n_points)
    return OwnNoise(hessian_bias, by_images @ J.T / n_points, by_jacobian @ e[0] / n_points, degrees_of_freedom)


def _gradients_by_jacobian(jacobian_weights: NDArray[np.float64], products: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N_SAMPLES, m) px²/rad: draws of the Jacobian's noise times e.

    jacobian_weights: (n, m) /rad; products: (N_SAMPLES,) px², draws of the change of e by one image's noise, times e.
    """
    root = np.linalg.qr(jacobian_weights, mode="r")  # noise of m images has the same covariance as that of n
    return np.stack([np.roll(products, k + 1) for k in range(len(root))], -1) @ root
