"""The quadratic model of E about a posture: E(θ) = E₀ + ½ dᵀ H d, d = θ - θ₀, and its errors.

The posture θ₀ is taken for the minimum, so there is no linear term. H = J_uᵀ J_eᵀ J_e J_u / N is the Gauss-Newton
Hessian. J_u are the derivatives of the own images by the joints, J_e those of the residuals by the own images. J_u is
learned from noisy images, so H is debiased. That noise also makes a gradient at the true minimum: Monte Carlo draws of
it, `grad_samples_…`, give the error of θ₀.

References
----------
Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, section 10.3 (Gauss-Newton).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...estimation.residuals import conflict
from ..least_squares import FD_STEP, Minimum, fd_steps
from ..observation import Observation, Visit
from .image_models import ImageModel, KinematicImages, estimate_own_noise
from .options import DEFAULTS, TrustRegionOptions

Array = NDArray[np.float64]
Residuals = Callable[[Array], Array]  # own images (..., N, 4) px → residuals (..., n, C) px
AFFINE_MINIMAL_SAMPLE = 4  # points that affine fundamental matrices fit exactly, Section 2.2 of the paper


def absorbed_points(joints: int) -> float:
    """Return how many points the free parameters fit exactly, at any posture.

    The parameters are the joints and a 3-D projective map (15). Each stereo match gives three coordinates, because its
    row is the same in both images.
    """
    return (15 + joints) / 3


def min_points_identifiable(joints: int) -> int:
    """Return how many points contradict a wrong posture: one more than the free parameters fit."""
    return int(absorbed_points(joints) + 1) + 1


def degrees_of_freedom(points: int, joints: int) -> int:
    """Return how many residual coordinates of N points are left by the parameters of the transfer and the m joints.

    It is 4 (N - 4) - m, as for affine transfers, whose 16 parameters fit four points exactly. The default transfer is a
    homography of space with 15 parameters: it leaves 4 N - 15 - m, one more. The smaller number is used for both, so
    bounds on E are slightly too low. A point that one camera alone sees is counted as four coordinates, and has two.
    """
    return max(4 * (points - AFFINE_MINIMAL_SAMPLE) - joints, 1)


@dataclass(frozen=True)
class LocalModel:
    """Quadratic model of E about a posture, and E as measured at the visits near it; m joints, n visits."""

    hessian: Array  # (m, m) px²/rad², debiased, mean over the points
    hessian_all_points: Array  # (m, m) px²/rad², with rarely seen points, as if own images had no noise
    E: float  # px², at the best visit
    n_points: int  # points N that determine E
    n_visible: int  # those of them that are visible at the best visit
    newton_step: Array  # (m,) rad, from the posture to the predicted minimum
    grad_samples_images: Array  # (k, m) px²/rad, Monte Carlo draws: error of the gradient by the own images' noise
    grad_samples_jacobian: Array  # (k, m) px²/rad, draws: its error by the noise of the images' slopes
    grad_bias_per_rig: Array  # (k, m) px²/rad, change of the gradient with each other hypothesis about the stereo head
    image_gram: Array  # (m, m) px²/rad², J_uᵀ J_u / N
    offsets: Array  # (n, m) rad, of the visits from the posture
    increase: Array  # (n,) px², of the measured E above the best visit; NaN where no common points allow it
    hessians: Array  # (n, m, m) px²/rad², of the points that `increase` is measured with, for single images
    hessian_single: Array  # (m, m) px²/rad², of all points, for single images
    lower: Array  # (m,) rad, joint limits relative to the posture
    upper: Array  # (m,) rad
    noise_px: float  # standard deviation of a residual
    trusted: bool = False  # whether kinematics predict all images and are evidence, as of `convergence`

    @property
    def degrees_of_freedom(self) -> int:
        """Residual degrees of freedom of E."""
        return degrees_of_freedom(self.n_points, len(self.hessian))


@dataclass(frozen=True)
class EstimationData:
    """What a local model is made from."""

    visits: tuple[Visit, ...]
    best: int  # index of the visit with the smallest E
    E: float  # px², there
    points: NDArray[np.bool_]  # (N,), points that E was evaluated with there
    model: ImageModel  # learned from the visits
    observation: Observation  # at the last visit
    residuals: Residuals  # by the chosen transfer; points that are NaN are left out
    E_of_visits: Array | None = None  # (n,) px², by each visit's own images; None: residuals are whitened
    residuals_per_rig: tuple[Residuals, ...] = ()  # for each other hypothesis about the stereo head
    residuals_single: Residuals | None = None  # whitened for single own images; None: residuals are not whitened

    @property
    def residuals_of_visits(self) -> Residuals:
        """Residuals of own images as they were seen."""
        return self.residuals if self.residuals_single is None else self.residuals_single


def local_model(
    data: EstimationData, minimum: Minimum, place: Array, options: TrustRegionOptions = DEFAULTS
) -> LocalModel:
    """Make the quadratic model of E about a posture.

    Parameters
    ----------
    data : EstimationData
    minimum : Minimum
        The smallest predicted E.
    place : (m,) array
        The posture [rad].
    options : TrustRegionOptions, optional

    Returns
    -------
    LocalModel

    Notes
    -----
    A point whose slopes are more uncertain than 1 / `max_std_per_px` is left out: its errors would look like curvature.
    """
    learned = data.model.jacobian_std(place) < 1.0 / options.max_std_per_px
    hessian, points = minimum.hessian, minimum.points
    if not learned[data.points].all():
        hessian, points = _hessian_of_points(data, data.points & learned, place)
    single = hessian
    if data.residuals_single is not None:
        of_points = _restricted(data, data.residuals_single, learned, place)
        single = _hessian(of_points(_images_about(data.model, place)))
    increase, hessians = _increases(data, single, place, learned)
    of_images = of_jacobian = np.zeros((1, len(place)))
    if data.observation.noise_px > 0:
        freedom = degrees_of_freedom(points, len(place))
        residuals, seed = (
            _restricted(data, data.residuals, learned, place),
            [data.observation.seed, data.observation.motion],
        )
        noise = estimate_own_noise(data.model, residuals, place, data.observation.noise_px, freedom, seed)
        hessian, hessians, single = (noise.debias_hessian(one) for one in (hessian, hessians, single))
        of_images, of_jacobian = noise.grad_samples_images, noise.grad_samples_jacobian
    return LocalModel(
        hessian=hessian,
        hessian_all_points=minimum.hessian * minimum.points / points,
        E=data.E,
        n_points=points,
        n_visible=_count_visible(data, points),
        newton_step=minimum.theta - place,
        grad_samples_images=of_images,
        grad_samples_jacobian=of_jacobian,
        grad_bias_per_rig=_grad_bias_per_rig(data, learned, place),
        image_gram=_image_gram(data.model, place),
        offsets=np.array([visit.displacement for visit in data.visits]) - place,
        increase=increase,
        hessians=hessians,
        hessian_single=single,
        lower=data.observation.lower - place,
        upper=data.observation.upper - place,
        noise_px=data.observation.noise_px,
        trusted=isinstance(data.model, KinematicImages) and data.model.process is None and data.model.trusted,
    )


def _hessian_of_points(data: EstimationData, points: NDArray[np.bool_], place: Array) -> tuple[Array, int]:
    """Return the Hessian that these points, (N,), predict, 0 where they are too few for any E, and their number."""
    e = data.residuals(np.where(points[:, None], _images_about(data.model, place), np.nan))
    return (_hessian(e) if np.isfinite(e).all() else np.zeros((len(place),) * 2)), max(e.shape[-2], 1)


def _images_about(model: ImageModel, place: Array) -> Array:
    """Predict the images at a posture and one finite difference on by each joint: (1 + m, N, 4) px."""
    return model.predict(place + FD_STEP * fd_steps(len(place)))


def _restricted(data: EstimationData, residuals: Residuals, learned: NDArray[np.bool_], place: Array) -> Residuals:
    """Return residuals of the points that E was evaluated with and whose slopes are learned; of all, if too few."""
    points = data.points & learned
    of_these = lambda own: residuals(np.where(points[:, None], own, np.nan))
    enough = points.all() or np.isfinite(of_these(data.model.predict(place))).all()
    return of_these if enough else residuals


def _grad_bias_per_rig(data: EstimationData, learned: NDArray[np.bool_], place: Array) -> Array:
    """Return how the gradient of E changes with each other hypothesis about the stereo head: (k, m) px²/rad."""
    if not data.residuals_per_rig:
        return np.zeros((0, len(place)))
    about = _images_about(data.model, place)
    rigs = data.residuals, *data.residuals_per_rig
    gradients = [_gradient(_restricted(data, residuals, learned, place)(about)) for residuals in rigs]
    return np.array([gradient - gradients[0] for gradient in gradients[1:]])


def _gradient(e: Array) -> Array:
    """Return the gradient of E, (m,) px²/rad, from residuals (1 + m, n, C) px at `_images_about`."""
    return (e[1:] - e[0]).reshape(len(e) - 1, -1) @ e[0].ravel() / (FD_STEP * e.shape[-2])


def _hessian(e: Array) -> Array:
    """Return the Gauss-Newton Hessian of E, (m, m) px²/rad², from residuals (1 + m, n, C) px at `_images_about`."""
    J = (e[1:] - e[0]).reshape(len(e) - 1, -1) / FD_STEP
    return J @ J.T / e.shape[-2]


def _increases(data: EstimationData, hessian: Array, place: Array, learned: NDArray[np.bool_]) -> tuple[Array, Array]:
    """Measure how much E is larger at every visit than at the best one, with the points seen and learned at both.

    Returns (n,) px², and (n, m, m) px²/rad², the Hessians of these points.
    """
    own, seen, residuals = _images_of_visits(data), data.model.seen, data.residuals_of_visits
    hessians = np.repeat(hessian[None], len(own), 0)
    if seen.all():
        E = conflict(residuals(own)) if data.E_of_visits is None else data.E_of_visits
        with np.errstate(invalid="ignore"):  # inf - inf: too few points at both
            return E - E[data.best], hessians
    increases = np.full(len(own), np.nan)
    about = _images_about(data.model, place)
    for k, both in enumerate(seen & seen[data.best] & learned):
        images = np.concatenate([own[[data.best, k]], about])
        e = residuals(np.where(both[:, None], images, np.nan))
        here, there = conflict(e[:2])
        if np.isfinite(there):
            increases[k], hessians[k] = there - here, _hessian(e[2:])
    return increases, hessians


def _count_visible(data: EstimationData, points: int) -> int:
    """Count the points that determine E at the best visit without being predicted.

    If all are seen at every visit it is `points`. Otherwise points may be visible only because the posture is wrong.
    """
    if data.model.seen.all():
        return points
    best, seen = _images_of_visits(data)[data.best], data.model.seen[data.best]
    return data.residuals_of_visits(np.where(seen[:, None], best, np.nan)).shape[-2]


def _images_of_visits(data: EstimationData) -> Array:
    """Return the images of all visits, hidden points predicted where that is safe: (n, N, 4) px."""
    return data.model.impute(np.array([visit.own for visit in data.visits]))


def _image_gram(model: ImageModel, place: Array) -> Array:
    """Return J_uᵀ J_u / N of the points that the model knows, (m, m) px²/rad²."""
    slopes = model.jacobian(place)[:, np.isfinite(model.at_centre).all(-1)]
    points = max(slopes.shape[1], 1)
    slopes = slopes.reshape(len(place), -1)
    return slopes @ slopes.T / points
