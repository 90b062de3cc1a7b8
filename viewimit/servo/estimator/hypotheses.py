"""What the demonstrator's images say: hypotheses, each adjusted together with the own images, compared by likelihood.

| hypothesis | unknowns besides the body's | found by |
|---|---|---|
| the same body | 7 of a similarity, m angles | `same_body`, from the last estimate or each minimum of E |
| the same body, points swapped | the same, times the choices | `find_pairs` |
| another body | 3m more | `likeliest_other` |
| a body whose links and points all differ a little | one more, their spread | `likeliest_other`, if no other fits |
| another head | 8 more | `likeliest_other` |
| points elsewhere | 3 more for each | `likeliest_other` |
| mirrored | no more | `likeliest_other` |
| a lens | 5 more | `likeliest_other` |
| the same body, other chains or postures | the same | `with_rivals`: their weights e^(-Δ/2) widen the error |

Δ is the rise of the cost over σ². Schwarz's criterion Δ + k ln n compares hypotheses of different size. The same body
is asked first, and the others only where an F-test says that noise does not explain what it leaves.

References
----------
Schwarz, "Estimating the dimension of a model", Annals of Statistics 6, 1978.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...estimation.residuals import ResidualFunction
from ...estimation.transfers.transfer import conflict
from ...estimation.views import Pairs
from ...geometry.kinematics.adjustment import MIN_POINTS, NOISE_FLOOR_PX
from ...geometry.kinematics.loose_pair import LoosePair
from ...geometry.kinematics.maximum_likelihood import Likely, likely_kinematics
from ...geometry.kinematics.own_body import OwnBody
from ...geometry.kinematics.two_bodies import BodyPair
from ..least_squares import minimise, posture_grid
from ..misfit import Misfit, MisfitKind
from ..observation import Observation
from .naming import KnownBody, mixed_up
from .options import EstimatorOptions
from .pair_fit import FEW_STEPS, CommonAdjustment, PairFit
from .reasons import Explanation, Reasons
from .swaps import find_swaps

Array = NDArray[np.float64]
GOALS = MisfitKind.ANOTHER_BODY, MisfitKind.LENS, MisfitKind.TWO_HEADS  # of which a claim is made
ANGLES = (*GOALS, MisfitKind.POINT, MisfitKind.LINK_POINTS)  # whose angles are worth imitating
APART, DISTINCT = np.radians([15.0, 2.0])  # rad: between starts of the search; between its results
BEYOND = np.radians(3.0)  # rad: outside the limits by more, a posture is only taken if there is no other
MANY_STEPS, HOPELESS_SIGMAS = 80, 12.0  # steps that end at a minimum; beyond, no other chain of a point helps
FLAT, FLAT_STEPS = 6.0, 1000  # standard deviations of noise; steps that end in the narrow valley of a nearly flat body
CLEAR, EARLY = 10.0, 70.0  # by which the best reason's criterion is smaller than others', to claim; to look no further
MAX_IMITATED_STD = np.radians(3.0)  # expected error: if larger, the angles of an explanation are not imitated
SMALL_E = 25.0, 1e-3  # E that is small: times the noise variance; share of the mean square extent of the own image
NO_ERROR, MANY_POINTS = 1e-7, 8  # E in squared image units, that is rounding; points from which it says something


@dataclass(frozen=True)
class Estimate:
    """The demonstrator's posture by one hypothesis."""

    theta: Array  # (m,) rad
    std: Array  # (m,) rad: of the way from the arm to the demonstrator
    sigmas: float  # by how many standard deviations its images contradict
    fit: PairFit | None = None  # None of an estimate without noise, whose covariance was not needed yet
    adjustment: CommonAdjustment | None = None  # that the fit is of
    explanation: Explanation | None = None  # another hypothesis than the same body
    minima: tuple[tuple[float, Array], ...] = ()  # E and posture of the last search over all postures, the least first
    rivalry: float = 1.0  # factor by which rivals enlarge the standard error

    def fits(self, options: EstimatorOptions) -> bool:
        """Whether noise explains the images, by a hypothesis that allows a claim."""
        if self.explanation is None:
            return self.sigmas < options.max_sigmas
        why = self.explanation
        return why.misfit.kind in GOALS and why.is_convincing(options.max_sigmas, CLEAR)

    def std_per_unit(self, noise_px: float) -> Array:
        """Standard error by noise of one image unit, (m,) rad. noise_px: of an own image, without a fit."""
        return self.std / (noise_px if self.fit is None else self.fit.std)

    def open_joints(self, options: EstimatorOptions, noise_px: float) -> NDArray[np.bool_]:
        """Which joints the images leave open, (m,) bool. noise_px: as of `std_per_unit`."""
        return ~(self.std_per_unit(noise_px) < options.max_std_per_unit)

    def is_clear(self, options: EstimatorOptions) -> bool:
        """Whether another hypothesis explains the images, and no third nearly as well."""
        why = self.explanation
        return why is not None and why.is_convincing(options.max_sigmas, EARLY)


def least_E(estimate: Estimate) -> Array:
    """The posture of least E if it was searched for, else the estimate, (m,) rad."""
    return estimate.minima[0][1] if estimate.minima else estimate.theta


@dataclass(frozen=True)
class Evidence:
    """All that hypotheses are compared by. Images are in image units."""

    body: OwnBody
    see: Observation
    residuals: ResidualFunction
    options: EstimatorOptions

    @property
    def noise_px(self) -> float:
        """Of an own image's coordinate."""
        return max(self.see.noise_px, NOISE_FLOOR_PX)

    @property
    def is_nearly_flat(self) -> bool:
        """Whether the own images spread in their third direction hardly more than noise: all points near a plane."""
        return bool(self.body.kinematics.frame.unit_px[2] < FLAT * self.noise_px)

    @property
    def unclear(self) -> MisfitKind | None:
        """Why the images tell no reason from another one."""
        by, images = self.body.kinematics.rectification, (self.body.seen.images, self.see.demonstrator[0][None])
        if by is not None and by.meets_epipole(np.concatenate(images)):
            return MisfitKind.EPIPOLE
        return MisfitKind.NEARLY_FLAT if self.is_nearly_flat else None

    def adjustment(self, likely: Likely | None = None) -> CommonAdjustment | None:
        """The adjustment of both bodies; None if too few points are visible for any test."""
        body, (demo, demo_noise_px) = self.body, self.see.demonstrator
        likely = Likely(body.kinematics, body.cost, body.cost) if likely is None else likely
        weight = self.noise_px / max(demo_noise_px, NOISE_FLOOR_PX)
        return CommonAdjustment.of(likely, body.seen, demo[None], self.noise_px, weight)

    def inside(self, fit: PairFit) -> bool:
        """Whether a fit's posture is hardly beyond the limits."""
        theta = fit.pair.angles[0]
        return bool(np.maximum(self.see.lower - theta, theta - self.see.upper).max() < BEYOND)

    def is_right(self, fit: PairFit) -> bool:
        """Whether noise explains a fit, and no limit excludes it."""
        return fit.sigmas < self.options.max_sigmas and self.inside(fit)

    def estimate(
        self,
        adjustment: CommonAdjustment,
        fit: PairFit,
        minima: tuple[tuple[float, Array], ...] = (),
        explanation: Explanation | None = None,
    ) -> Estimate:
        """The posture of a fit, with its standard error."""
        problem, slack = adjustment.problem, self.body.slack
        std = LoosePair(problem, slack).std(fit.pair) if slack else problem.angle_std(fit.pair)[0]
        return Estimate(fit.pair.angles[0], fit.std * std, fit.sigmas, fit, adjustment, explanation, minima)

    def continued(self, previous: Estimate) -> BodyPair | None:
        """The last pair, with the points and chains that the body has now; None if its coordinates are other ones."""
        assert previous.fit is not None
        pair, k = previous.fit.pair, self.body.kinematics
        if pair.kinematics.frame is not k.frame:
            return None
        moved = (pair.kinematics.moved_by != k.moved_by).any(1) | np.isnan(pair.points[:, 0]) | k.unknown
        return replace(pair, kinematics=k, points=np.where(moved[:, None], k.points, pair.points))

    def postures(self, near: Array | None = None) -> tuple[tuple[float, Array], ...]:
        """Minima of E in the body's predicted images, the least first. near: (m,) rad, to search about alone."""
        see, options, m = self.see, self.options, len(self.see.lower)
        conflict_at = lambda theta: self.residuals(self.body.kinematics.predict(theta))
        if near is not None:
            one = minimise(conflict_at, near[None], see.lower, see.upper)
            return ((one.E, one.theta),) if np.isfinite(one.E) else ()
        if m < 3:
            grid = posture_grid(see.lower, see.upper, options.grid)
        else:
            rng = np.random.default_rng([see.seed, see.motion, m])
            grid = rng.uniform(see.lower, see.upper, (options.samples, m))
        E, starts = conflict(conflict_at(grid)), list[Array]()
        for g in np.argsort(E):
            if np.isfinite(E[g]) and len(starts) < options.starts and _is_new(grid[g], starts, APART):
                starts.append(grid[g])
        distinct = list[tuple[float, Array]]()
        for one in sorted(
            (minimise(conflict_at, s[None], see.lower, see.upper) for s in starts), key=lambda one: one.E
        ):
            if _is_new(one.theta, [theta for _, theta in distinct], DISTINCT):
                distinct.append((one.E, one.theta))
        return tuple(distinct)


def _is_new(theta: Array, others: Iterable[Array], apart: float) -> bool:
    return all(np.abs(theta - other).max() > apart for other in others)


def same_body(evidence: Evidence, previous: Estimate | None = None) -> Estimate | None:
    """The demonstrator as the same body: from the last estimate, else from each minimum of E; the likeliest.

    Without noise, E = 0 of many points in both views is the same body. None if too few points are visible.
    """
    body, see, m = evidence.body, evidence.see, len(evidence.see.lower)
    k, options = body.kinematics, evidence.options
    enough = np.count_nonzero(np.isfinite(see.demonstrator[0]).all(1) & ~k.unknown) >= MANY_POINTS
    quick = see.noise_px == 0 and not body.slack and enough and (previous is None or previous.fit is None)
    if quick and previous is not None:
        at = evidence.postures(previous.theta)
        if at and at[0][0] < NO_ERROR:
            return replace(previous, theta=at[0][1])
    if (adjustment := evidence.adjustment()) is None:
        return None
    if previous is not None and previous.fit is not None and (start := evidence.continued(previous)) is not None:
        fit = adjustment.fit(start, FEW_STEPS)
        if evidence.is_right(fit):
            return evidence.estimate(adjustment, fit, previous.minima)
    minima, found = evidence.postures(), list[PairFit]()
    if quick and minima and minima[0][0] < NO_ERROR:
        return Estimate(minima[0][1], np.zeros(m), 0.0, minima=minima)
    for _, theta in minima:
        for start in adjustment.problem.starts(k, theta[None])[:2]:
            found.append(fit := adjustment.fit(start, FEW_STEPS))
            if evidence.is_right(fit):
                return evidence.estimate(adjustment, fit, minima)
    if not found:
        return None
    best = min(found, key=lambda fit: (fit.sigmas >= options.max_sigmas, not evidence.inside(fit), fit.raised))
    return evidence.estimate(adjustment, best, minima)


def refined(same: Estimate, evidence: Evidence) -> Estimate:
    """The same hypothesis after as many steps as it takes, with the likeliest chains that the points may have."""
    assert same.fit is not None and same.adjustment is not None
    steps = FLAT_STEPS if evidence.is_nearly_flat else MANY_STEPS
    found = [evidence.estimate(same.adjustment, same.adjustment.fit(same.fit.pair, steps), same.minima)]
    options = evidence.options
    hopeful = options.max_sigmas <= found[0].sigmas < HOPELESS_SIGMAS
    if hopeful and not evidence.body.slack and not found[0].open_joints(options, evidence.noise_px).any():
        found += _other_chains(same, evidence, FEW_STEPS)
    return min(found, key=_cost)


def _cost(estimate: Estimate) -> float:
    assert estimate.fit is not None
    return estimate.fit.cost


def _other_chains(same: Estimate, evidence: Evidence, steps: int) -> Iterator[Estimate]:
    """Yield estimates with other chains of the points, which explain the own images nearly as well.

    steps: of each adjustment, at most.
    """
    for likely in likely_kinematics(evidence.body.kinematics, evidence.body.problem):
        other = replace(evidence, body=replace(evidence.body, kinematics=likely.kinematics))
        start, adjustment = other.continued(same), other.adjustment(likely)
        if adjustment is not None and start is not None:
            yield evidence.estimate(adjustment, adjustment.fit(start, steps), same.minima)


def with_rivals(best: Estimate, evidence: Evidence) -> Estimate:
    """The estimate, more uncertain by all that are nearly as likely: other chains of the points, other postures."""
    see, body, options = evidence.see, evidence.body, evidence.options
    if best.fit is None:  # without noise: only now its covariance is needed
        adjustment = evidence.adjustment()
        starts = [] if adjustment is None else adjustment.problem.starts(body.kinematics, best.theta[None])
        fit = adjustment.best_fit(starts, options.max_sigmas) if adjustment is not None and starts else None
        if adjustment is None or fit is None:
            return replace(best, std=np.full_like(best.std, np.inf))
        best = evidence.estimate(adjustment, fit, best.minima)
    adjustment, found = best.adjustment, [best]
    assert adjustment is not None
    if see.noise_px > 0 and not body.slack:
        found += _other_chains(best, evidence, MANY_STEPS)
    minima = best.minima or evidence.postures()
    for E, theta in minima:
        low = E < options.rival * max(minima[0][0], see.noise_px**2, NO_ERROR)
        if low and np.abs(theta - best.theta).max() > max(BEYOND, 5 * best.std.max()):
            for start in adjustment.problem.starts(body.kinematics, theta[None])[:2]:
                if evidence.is_right(fit := adjustment.fit(start, FEW_STEPS)):
                    found.append(evidence.estimate(adjustment, fit))
    least = min(found, key=_cost)
    assert least.adjustment is not None
    weights = np.exp((_cost(least) - np.array([_cost(one) for one in found])) / (2 * least.adjustment.variance))
    squares = [one.std**2 + (one.theta - least.theta) ** 2 for one in found]
    std = np.sqrt(np.average(squares, axis=0, weights=weights))
    return replace(least, std=std, minima=minima, rivalry=float(std.max() / least.std.max()))


def find_pairs(evidence: Evidence) -> Pairs:
    """Pairs of the demonstrator's points that seem to be swapped; none if that explains nothing."""
    see, k = evidence.see, evidence.body.kinematics
    demo = see.demonstrator[0]
    model = KnownBody(k, evidence.body.seen, evidence.noise_px)
    own = see.own[np.isfinite(see.own).all(1)]
    floor = max(SMALL_E[0] * see.noise_px**2, SMALL_E[1] * float(own.var(0).mean()))
    name = lambda: mixed_up(demo, model, see.lower, see.upper, see.seed)
    return find_swaps(k.predict, evidence.residuals, see.lower, see.upper, floor, see.seed, name)


def likeliest_other(same: Estimate, evidence: Evidence) -> Estimate:
    """The likeliest hypothesis but the same body, by Schwarz's criterion; `same` if too few points tell.

    Where its angles are not worth imitating, the posture of least E is the place to be. Points near a plane, or near an
    epipole, tell no hypothesis from another one.
    """
    see, (demo, _) = evidence.see, evidence.see.demonstrator
    assert same.fit is not None and same.adjustment is not None
    if np.count_nonzero(same.adjustment.problem.visible_in_both[0]) < MIN_POINTS:
        return same
    if (unclear := evidence.unclear) is not None:
        nothing = Explanation(Misfit(unclear), same.adjustment.estimate(same.fit), 0.0)
        return replace(same, theta=least_E(same), explanation=nothing)
    see = replace(see, noise_px=evidence.noise_px, demo=demo)
    reasons = Reasons(same.adjustment, same.fit, evidence.body.seen, see, same.theta, see.seed)
    why, best = reasons.best()
    estimate = why.estimate
    found = replace(same, theta=estimate.theta, std=estimate.std_error, sigmas=estimate.sigmas, explanation=why)
    accurate = found.sigmas < evidence.options.max_sigmas and found.std.max() < MAX_IMITATED_STD
    if why.misfit.kind in ANGLES and accurate:
        return replace(found, fit=best.fit, adjustment=best.adjustment)
    return replace(found, theta=least_E(same))


def refitted(before: Estimate, evidence: Evidence) -> Estimate | None:
    """The hypothesis of the last estimate with the images seen since; None if it fits no more, or cannot go on."""
    why = before.explanation
    assert why is not None
    start, adjustment = evidence.continued(before), evidence.adjustment()
    if why.misfit.kind is MisfitKind.LENS or start is None or adjustment is None:
        return None
    fit = adjustment.fit(start, FEW_STEPS)
    if fit.sigmas >= evidence.options.max_sigmas:
        return None
    why = replace(why, estimate=adjustment.estimate(fit))
    return evidence.estimate(adjustment, fit, before.minima, why)
