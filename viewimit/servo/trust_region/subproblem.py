"""Evaluate E at all visits, and solve the trust-region subproblem: minimise the predicted E inside the region.

The image model predicts the learner's own image points at any posture. The transfer turns predicted points into
residuals, and residuals give E. So E can be evaluated at postures that the arm has not visited, without moving it.

References
----------
Conn, Gould and Toint, Trust-Region Methods, SIAM 2000, chapter 6.
Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, Algorithm 4.1.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np
from numpy.typing import NDArray

from ...estimation.residuals import NoiseReference, ResidualFunction, conflict
from ..least_squares import Minimum, minimise
from ..observation import Observation
from .convergence import Certificate, certify, curvature_directions
from .image_models import ImageData, ImageModel
from .local_model import EstimationData, absorbed_points, local_model, min_points_identifiable
from .options import TrustRegionOptions

SAME_E = 1e-6  # relative: values of E that differ by less may do so by rounding, as where a joint moves no point


@dataclass(frozen=True)
class VisitObjectives:
    """E at all visits."""

    E: NDArray[np.float64]  # (n,) px²
    points: NDArray[np.bool_]  # (n, N): points that E was evaluated with
    count: NDArray[np.int_]  # (n,): how many of them have a residual
    best: int  # index of the visit to plan from
    noise_reference: NoiseReference | None = None  # of whitened residuals; None without noise


@dataclass(frozen=True)
class StepPlan:
    """Solution of the subproblem."""

    E: float  # px², at the best visit
    n_points: int  # number of points that determine it
    model: ImageModel  # predicts images; its centre is the best visit
    minimum: Minimum  # of the predicted E inside the region
    noise_reference: NoiseReference | None  # of whitened residuals; None without noise
    data: EstimationData | None  # for the convergence test; None if E is another transfer's, or of too few points
    options: TrustRegionOptions

    @property
    def can_certify(self) -> bool:
        """Whether the convergence test can be made: E is the chosen transfer's, and enough points determine it."""
        return self.data is not None

    def certify(self, place: NDArray[np.float64]) -> Certificate:
        """Make the convergence test at a posture, (m,) rad. Raises ValueError where it cannot be made."""
        if self.data is None:
            raise ValueError("E is another transfer's, or of too few points")
        return certify(local_model(self.data, self.minimum, place, self.options), self.options)

    @property
    def step_length(self) -> float:
        """Largest joint displacement from the best visit to the minimum, rad."""
        return float(np.abs(self.minimum.theta - self.model.centre).max())

    @property
    def max_displacement(self) -> float:
        """Largest displacement from the minimum that E at the best visit allows, rad."""
        return max_displacement(self.E, self.minimum, self.options)

    @property
    def max_displacement_at_minimum(self) -> float:
        """Largest displacement that the predicted E leaves possible, rad."""
        return max_displacement(self.minimum.E, self.minimum, self.options)

    @property
    def flattest_direction(self) -> NDArray[np.float64]:
        """(m,) unit vector along which the predicted E rises least."""
        return curvature_directions(self.minimum.hessian)[:, 0]


def evaluate_visits(
    images: ImageData,
    residuals: ResidualFunction,
    transfer: str | None,
    min_points: int,
    options: TrustRegionOptions,
) -> VisitObjectives:
    """Evaluate E at all visits, with the noise of their images averaged by the image model.

    Parameters
    ----------
    images : ImageData
        All visits and what they show of the own images.
    residuals : ResidualFunction
    transfer : str or None
        Another transfer than the chosen one.
    min_points : int
        Number of points that must determine E at the best visit, if any visit has as many.
    options : TrustRegionOptions

    Returns
    -------
    VisitObjectives

    Notes
    -----
    Hidden points are replaced by predictions. While E is large, these may have a standard deviation of
    `max_prediction_std_px`. Near the minimum it must not exceed the image noise.
    """
    loose, noise_px = options.max_prediction_std_px, images.noise_px
    found = _evaluate(loose, images, residuals, transfer, min_points, options)
    hidden = not all(visit.seen.all() for visit in images.visits)
    if 0 < noise_px < loose and hidden and found.E[found.best] < loose**2:
        return _evaluate(noise_px, images, residuals, transfer, min_points, options)
    return found


def _evaluate(
    max_std_px: float,
    images: ImageData,
    residuals: ResidualFunction,
    transfer: str | None,
    min_points: int,
    options: TrustRegionOptions,
) -> VisitObjectives:
    """Evaluate E with predicted points up to a standard deviation; with noise, first unweighted, then whitened."""
    own, known = _impute(images, max_std_px)
    joints = len(images.visits[0].displacement)
    evaluate = lambda **weighted: _objectives(
        own, known, joints, min_points, partial(residuals, transfer=transfer, **weighted)
    )
    if images.noise_px == 0 or transfer is not None:
        return evaluate()
    best = evaluate(noise_reference=NoiseReference()).best
    reference = NoiseReference(own[best], _variance_ratio(images, best, options))
    return replace(evaluate(noise_reference=reference), noise_reference=reference)


def _variance_ratio(images: ImageData, best: int, options: TrustRegionOptions) -> float:
    """Return the variance of the own images that are compared, relative to a single image.

    Kinematics average the noise of many visits; a Gaussian process does not. Images that repeat to the last bit at
    other postures have rounded coordinates. Their errors are always the same, so they do not average out.
    """
    return 1.0 if images.kinematics is None or images.is_rounded(best) else options.averaged_variance


def _impute(images: ImageData, max_std_px: float) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return the images of all visits and which points are known in them.

    Returns (n, N, 4) px with hidden points predicted and noise averaged, and (n, N) bool of points that were seen, or
    are predicted to `max_std_px`.
    """
    visits, noise_px = images.visits, images.noise_px
    own = np.array([visit.own for visit in visits])
    seen = np.all([visit.seen for visit in visits], -1)
    hidden = np.isnan(own)
    if noise_px == 0 and not hidden.any():
        return own, seen
    model = images.fit()
    displacement = np.array([visit.displacement for visit in visits])
    predicted = model.predict(displacement)
    known = seen if seen.all() else seen | (model.prediction_std(displacement) < max_std_px)
    return (predicted if noise_px > 0 else np.where(hidden, predicted, own)), known


def _objectives(
    own: NDArray[np.float64],
    known: NDArray[np.bool_],
    joints: int,
    min_points: int,
    residuals: Callable[[NDArray[np.float64]], NDArray[np.float64]],
) -> VisitObjectives:
    """Evaluate E with the known points if they are enough to be identifiable, otherwise with all points.

    The best visit is chosen by E n / (n - n_absorbed), since fewer points leave fewer residual degrees of freedom.
    """
    if known.all():
        e = residuals(own)
        E = conflict(e)
        return VisitObjectives(E, known, np.full(len(E), e.shape[-2]), argmin_last(E))
    enough = min_points_identifiable(joints)
    points, E, count = known.copy(), np.empty(len(own)), np.empty(len(own), int)
    for k, (images, these) in enumerate(zip(own, points)):
        e = residuals(np.where(these[:, None], images, np.nan))
        if e.shape[-2] < enough:
            e, these[:] = residuals(images), True
        E[k], count[k] = conflict(e), e.shape[-2]
    comparable = E * count / np.maximum(count - absorbed_points(joints), 1)
    if (count >= min_points).any():
        comparable[count < min_points] = np.inf
    return VisitObjectives(E, points, count, argmin_last(comparable))


def argmin_last(E: NDArray[np.float64]) -> int:
    """Return the index of the smallest of (n,) values, of equal ones the last: it is nearer to where the arm is."""
    return int(np.flatnonzero(E <= E.min() * (1 + SAME_E))[-1])


def solve_subproblem(
    images: ImageData,
    visited: VisitObjectives,
    radius: float,
    observation: Observation,
    residuals: ResidualFunction,
    transfer: str | None,
    options: TrustRegionOptions,
) -> StepPlan:
    """Minimise the predicted E over |θ - centre| <= radius inside the joint limits.

    Parameters
    ----------
    images : ImageData
        Predicts the own images from all visits.
    visited : VisitObjectives
        E at the visits; the centre is the best of them.
    radius : float
        Trust radius per joint [rad]; inf once the kinematics are known.
    observation : Observation
        The last one: joint limits, noise, rig hypotheses.
    residuals : ResidualFunction
    transfer : str or None
        Another transfer than the chosen one.
    options : TrustRegionOptions

    Returns
    -------
    StepPlan
    """
    best, reference = visited.best, visited.noise_reference
    E, points, model = float(visited.E[best]), visited.points[best], images.fit(best)
    predict = model.restrict(points).predict
    minimum = _search(
        model.centre, radius, observation, lambda theta: residuals(predict(theta), transfer, reference), options
    )
    plan = StepPlan(E, int(visited.count[best]), model, minimum, reference, None, options)
    if transfer is not None or not np.isfinite(minimum.E):
        return plan
    whitened = partial(residuals, transfer=None, noise_reference=reference)
    data = EstimationData(
        visits=tuple(images.visits),
        best=best,
        E=E,
        points=points,
        model=model,
        observation=observation,
        residuals=whitened,
        E_of_visits=visited.E if reference is None else None,
        residuals_per_rig=tuple(partial(whitened, rig=k) for k in range(1, observation.n_rig_hypotheses + 1)),
        residuals_single=None
        if reference is None
        else partial(residuals, transfer=None, noise_reference=replace(reference, own_variance_ratio=1.0)),
    )
    return replace(plan, data=data)


def max_displacement(E: float, minimum: Minimum, options: TrustRegionOptions) -> float:
    """Return the largest semi-axis of the level set ½ dᵀ H d = E, rad, along observable directions."""
    curvatures = np.linalg.eigvalsh(minimum.hessian)
    observable = curvatures[curvatures * minimum.points > options.max_std_per_px**-2]
    return float(np.sqrt(2 * E / max(observable[0] if len(observable) else curvatures[0], 1e-12)))


def _search(
    centre: NDArray[np.float64],
    radius: float,
    observation: Observation,
    residual_at: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    options: TrustRegionOptions,
) -> Minimum:
    """Refine the best of many candidates by bounded least squares; E has several local minima."""
    low, high = np.maximum(observation.lower, centre - radius), np.minimum(observation.upper, centre + radius)
    joints = len(low)
    if joints <= 2:
        share = _unit_grid(joints, options.grid)
        candidates = (1 - share) * low + share * high
    else:
        candidates = np.random.default_rng([observation.seed, observation.motion]).uniform(
            low, high, (options.samples, joints)
        )
    E = conflict(residual_at(candidates))
    starts = np.concatenate([centre[None], candidates[np.argsort(E)[: options.refined]]])
    found = minimise(residual_at, starts, low, high)
    # The expected error is about the minimum itself, so the last step is made, too. It ends inside the limits as well.
    return replace(found, theta=found.theta + found.newton_step)


@cache
def _unit_grid(joints: int, count: int) -> NDArray[np.float64]:
    """Return an even grid over [0, 1] per joint, (count**joints, joints)."""
    axes = np.meshgrid(*[np.linspace(0, 1, count)] * joints, indexing="ij")
    return np.stack(axes, -1).reshape(-1, joints)
