"""The convergence test: measured evidence that E rises in every direction from a posture.

A point is a strict local minimum if the gradient is 0 and the Hessian positive definite: the second-order sufficient
conditions (Nocedal and Wright, Theorem 2.4). A small E shows neither. A joint that no point depends on leaves E flat,
and errors of the predictions look like curvature. So the test asks for E as measured at visits.

About the posture E ≈ E₀ + ½ dᵀ H d. For each eigenvector v of H, the flattest first, a visit at offset d is evidence
if v makes most of the rise predicted at d, and at least `min_rise` of v's own share was measured. The rise must also
exceed what noise makes or, without noise, a share of the motion of the own images. If no visit tests direction v, a
verification motion along v is requested. If E does not rise as predicted, v is unobservable, and so is each joint with
a component in v. With too few points E is small and rises at wrong postures as well, so they allow no claim.

Kinematics are evidence as well if they know all points that determine E, explain all visits, and have predicted one
far from the others that they did not know: exactly without noise, or by an F-test (`final_adjustment`). Then E rises
where their H says so and no visit contradicts. Errors of such predictions look no longer like curvature. With noise,
the final adjustment must agree: it must fit, and its expected error be small. Otherwise E is measured in every
direction. So it is with noise and one joint or two, too: there it takes few motions, whose images lessen the error of
the claim.

The covariance of the joint errors is σ² H⁻¹ / N, where σ is the image noise, or what E leaves if that is more. A
gradient g of E at the posture displaces the minimum by H⁻¹ g. The squares of such displacements are added for the noise
of the own images and for other hypotheses about the stereo head.

References
----------
Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, Theorem 2.4.
Šidák, Rectangular confidence regions for the means of multivariate normal distributions, JASA 1967.
"""

from dataclasses import dataclass, replace
from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.adjustment import PREDICTION_TOL_PX
from ..status import ServoStatus
from .local_model import LocalModel, min_points_identifiable
from .options import DEFAULTS, TrustRegionOptions

Array = NDArray[np.float64]
LEAST_CURVATURE = 1e-100  # px²/rad²: keeps squares of its inverse finite
ROUNDING = 1e-6  # of a unit vector's components, and rad: smaller differences may be rounding


@dataclass(frozen=True)
class Certificate:
    """Result of the convergence test at a posture."""

    std_per_px: Array  # (m,) rad/px, standard deviation of each joint by image noise of 1 px
    std_error: Array  # (m,) rad, standard deviation of each joint error; inf for unobservable joints
    observable: NDArray[np.bool_]  # (m,), joints
    verified: bool  # whether E rises along every direction, as measured or by trusted kinematics
    verification_step: Array  # (m,) rad, a motion that would show more; 0 if there is none to make
    E_negligible: bool  # whether E is below `min_conflict_share` of what a turn of all joints moves the own images
    needs_more_data: bool = False  # points seen rarely, or noise not averaged yet, hide what would be observable
    unexplored_direction: bool = False  # whether no visit went in some direction
    rig_std_error: Array | None = None  # (m,) rad, the part of `std_error` by the stereo head's uncertainty; None: 0

    def per_pixel(self, unit_px: float) -> "Certificate":
        """Convert one that was made in image units of `unit_px` pixels."""
        return replace(self, std_per_px=self.std_per_px / unit_px)

    def with_std_error(self, std_error: Array) -> "Certificate":
        """Replace the standard errors, (m,) rad, by those of another estimate, which takes the head for known."""
        by_rig = 0.0 if self.rig_std_error is None else self.rig_std_error
        return replace(self, std_error=np.hypot(std_error, by_rig))

    @property
    def status(self) -> ServoStatus:
        """Status in which a servo may stop where E is small."""
        if not self.observable.all():
            return ServoStatus.UNOBSERVABLE
        return ServoStatus.CONVERGED if self.verified else ServoStatus.SETTLED

    @property
    def unobservable_at_minimum(self) -> bool:
        """Whether E is small and some joint is unobservable."""
        return self.E_negligible and not self.observable.all()

    @property
    def simultaneous_std_error(self) -> float:
        """Standard error s [rad] such that 2 s bounds the largest joint error with the probability of 2 σ (Šidák)."""
        normal = NormalDist()
        together = 2 * normal.cdf(2.0) - 1
        quantile = normal.inv_cdf((1 + together ** (1 / len(self.std_error))) / 2)
        return float(self.std_error.max() * quantile / 2)

    @property
    def unobservable_joints(self) -> list[int]:
        """Indices of the unobservable joints, the worst first."""
        return [int(j) for j in np.argsort(-self.std_per_px, kind="stable") if not self.observable[j]]

    def reportable_joints(self, status: ServoStatus) -> list[int]:
        """Return the unobservable joints that may be named: none, if the visits alone leave the question open."""
        open_question = self.needs_more_data or self.unexplored_direction
        return self.unobservable_joints if status == ServoStatus.UNOBSERVABLE or not open_question else []


def certify(model: LocalModel, options: TrustRegionOptions = DEFAULTS) -> Certificate:
    """Test the second-order sufficient conditions at the posture of a local model.

    Parameters
    ----------
    model : LocalModel
    options : TrustRegionOptions, optional

    Returns
    -------
    Certificate
    """
    inverse = _inverse(model.hessian)
    std_per_px = _std_per_px(inverse, model.n_points)
    observable = std_per_px < options.max_std_per_px
    missing, useful = np.zeros(len(std_per_px)), np.zeros(len(std_per_px))  # verification steps
    verified = model.n_visible >= min_points_identifiable(len(std_per_px))
    for direction in _directions(model, options):
        increased, flat = _test_increase(model, direction, options)
        increased = increased or (not flat and _rises_by_kinematics(model, direction, options))
        verified = verified and increased and not _curvature_insignificant(model, direction, options)
        if flat and not increased:
            observable = observable & (np.abs(direction) <= options.min_component)
        elif not increased or _unclear(model, direction, options):
            missing = missing if missing.any() else _step_length(model, direction, options) * direction
        elif _self_noise_dominates(model, direction, model.grad_samples_images, model.grad_samples_jacobian):
            # Visits far apart determine the derivatives of the own images best.
            useful = useful if useful.any() else options.max_evidence_noisy * direction
    left = np.sqrt(2 * model.n_points * model.E / model.degrees_of_freedom)
    noise = max(model.noise_px, PREDICTION_TOL_PX, left)
    negligible = options.min_conflict_share * 0.5 * options.max_std_per_px**2 * np.trace(model.image_gram)
    of_noise, of_rig = _self_noise_variance(model, inverse), _rig_variance(model, inverse)
    variance = (noise * std_per_px) ** 2 + model.newton_step**2 + of_noise + of_rig
    identifiable = lambda: standard_deviations(model.hessian_all_points, model.n_points) < options.max_std_per_px
    nearest = np.linalg.norm(model.offsets @ np.linalg.eigh(model.offsets.T @ model.offsets)[1][:, 0])
    return Certificate(
        std_per_px=std_per_px,
        std_error=np.where(observable, np.sqrt(variance), np.inf),
        observable=observable,
        verified=verified,
        verification_step=missing if missing.any() else useful,
        E_negligible=bool(model.E < negligible),
        needs_more_data=not observable.all() and bool(identifiable().all()),
        unexplored_direction=bool(nearest < options.min_evidence),
        rig_std_error=np.sqrt(of_rig) if len(model.grad_bias_per_rig) else None,
    )


def certificate_of(std_error: Array, noise_px: float) -> Certificate:
    """Return the certificate of an estimate that noise explains.

    std_error: (m,) rad, of each joint; noise_px: standard deviation of an image coordinate.
    """
    observable = np.isfinite(std_error)
    return Certificate(std_error / noise_px, std_error, observable, True, np.zeros_like(std_error), True)


def standard_deviations(hessian: Array, points: int) -> Array:
    """Return the standard deviation of each joint by image noise of 1 px, √diag((JᵀJ)⁻¹): (m,) rad/px."""
    return _std_per_px(_inverse(hessian), points)


def curvature_directions(hessian: Array) -> Array:
    """Return the unit eigenvectors of a Hessian as columns, the flattest first: (m, m).

    The sign is fixed: the largest component, of equal ones the first, is positive.
    """
    directions = np.linalg.eigh(hessian)[1]
    components = np.abs(directions)
    leading = (components >= components.max(0) - ROUNDING).argmax(0)
    return directions * np.copysign(1.0, directions[leading, range(len(leading))])


def _std_per_px(inverse: Array, points: int) -> Array:
    return np.sqrt(np.diag(inverse) / points)


def _inverse(hessian: Array) -> Array:
    """Invert a Hessian that may have no curvature in some directions."""
    curvatures, directions = np.linalg.eigh(hessian)
    least = max(1e-12 * curvatures[-1], LEAST_CURVATURE)
    return (directions / np.maximum(curvatures, least)) @ directions.T


def _rig_variance(model: LocalModel, inverse: Array) -> Array:
    """Return the variance of the minimum by the uncertainty of the stereo head: (m,) rad²."""
    return ((model.grad_bias_per_rig @ inverse) ** 2).sum(0)


def _self_noise_variance(model: LocalModel, inverse: Array) -> Array:
    """Return the variance of the minimum by the noise of the own images: (m,) rad²."""
    samples = model.grad_samples_images, model.grad_samples_jacobian
    return sum(((gradients @ inverse) ** 2).mean(0) for gradients in samples)


def _unclear(model: LocalModel, v: Array, options: TrustRegionOptions) -> bool:
    """Whether noise leaves open whether E rises along v.

    Either the curvature is insignificant, or the own images' noise hides more than the demonstrator's.
    """
    return _curvature_insignificant(model, v, options) or _self_noise_dominates(model, v, model.grad_samples_images)


def _curvature_insignificant(model: LocalModel, v: Array, options: TrustRegionOptions) -> bool:
    """Whether a displacement along v is unobservable under noise."""
    return model.noise_px > 0 and _curvature_small(model, v, options)


def _rises_by_kinematics(model: LocalModel, v: Array, options: TrustRegionOptions) -> bool:
    """Whether trusted kinematics show that E rises along v."""
    return model.trusted and not _curvature_small(model, v, options)


def _curvature_small(model: LocalModel, v: Array, options: TrustRegionOptions) -> bool:
    """Whether noise of 1 px would make a displacement along v unobservable."""
    return model.n_points * max(float(v @ model.hessian @ v), LEAST_CURVATURE) * options.max_std_per_px**2 < 1


def _self_noise_dominates(model: LocalModel, v: Array, *samples: Array) -> bool:
    """Whether noise that more visits would average hides more of a displacement along v than the demonstrator's noise.

    samples: (k, m) px²/rad each, gradients that it makes.
    """
    if model.noise_px == 0:
        return False
    curvature = max(float(v @ model.hessian @ v), LEAST_CURVATURE)
    own = sum(((gradients @ v) ** 2).mean() for gradients in samples) / curvature**2
    return bool(own > model.noise_px**2 / (model.n_points * curvature))


def _directions(model: LocalModel, options: TrustRegionOptions) -> list[Array]:
    """Return the unit eigenvectors of H, the flattest first.

    If the joint limits leave no room for a verification step either way along one, the parts of it that they leave, if
    long enough, take its place.
    """
    found, length = [], options.verification_step
    for v in curvature_directions(model.hessian).T:
        ways = [way.clip(model.lower, model.upper) for way in (length * v, -length * v)]
        is_free = any(np.linalg.norm(way) > 0.99 * length for way in ways)
        long_enough = [way for way in ways if np.linalg.norm(way) > options.min_evidence]
        found += [v] if is_free else [way / np.linalg.norm(way) for way in long_enough]
    return found


def _test_increase(model: LocalModel, v: Array, options: TrustRegionOptions) -> tuple[bool, bool]:
    """Return whether a visit has shown that E rises along v, and whether one has shown that it does not."""
    quadratic = lambda d: 0.5 * np.einsum("ka,kab,kb->k", d, model.hessians, d)
    along = model.offsets @ v
    across = model.offsets - along[:, None] * v
    predicted, own = quadratic(model.offsets), 0.5 * along**2 * (model.hessians @ v @ v)
    # At visits that show fewer points, v is no eigenvector of their Hessian, and `predicted` may be less than the sum.
    mostly = own >= options.min_own_share * np.maximum(predicted, own + quadratic(across))
    all_points = own >= 0.5 * (0.5 * along**2 * (v @ model.hessian_single @ v))
    aligned = np.abs(along) >= options.min_alignment * np.linalg.norm(model.offsets, axis=-1)
    nearest, farthest = options.min_evidence, options.max_evidence
    significant: Array | float = 0.5 * options.min_conflict_share * along**2 * (v @ model.image_gram @ v)
    if model.noise_px > 0:
        nearest, farthest = options.min_evidence_noisy, options.max_evidence_noisy
        significant = _noise_of_increase(model, options)
    near = (np.abs(along) >= nearest) & (np.abs(model.offsets).max(-1) <= farthest) & np.isfinite(model.increase)
    expected = predicted - (1 - options.min_rise) * np.minimum(own, predicted)
    increased = near & mostly & (model.increase >= np.maximum(expected, significant))
    visible = options.min_rise * predicted >= _noise_of_increase(model, options)
    flat = near & aligned & all_points & (model.increase < significant) & visible
    return bool(increased.any()), bool(flat.any())


def _step_length(model: LocalModel, v: Array, options: TrustRegionOptions) -> float:
    """Return the length of a verification step along v, rad; 0 if noise hides the rise even of the longest one."""
    if model.noise_px == 0:
        return options.verification_step
    longest, along = options.max_evidence_noisy, model.offsets @ v
    curvature = options.min_rise * max(float(v @ model.hessian_single @ v), 1e-12)
    needed = 1.1 * np.sqrt(2 * _noise_of_increase(model, options) / curvature)
    made = (np.abs(along) >= longest / 2) & (np.abs(model.offsets).max(-1) <= 2 * longest)
    if needed > longest and made.any() and not _unclear(model, v, options):
        return 0.0
    return float(np.clip(needed, options.verification_step_noisy, longest))


def _noise_of_increase(model: LocalModel, options: TrustRegionOptions) -> float:
    """Return a rise of E that noise makes only rarely, px²."""
    sigma = np.sqrt(model.degrees_of_freedom) / model.n_points
    return options.significance * model.noise_px**2 * float(sigma)
