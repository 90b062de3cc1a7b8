"""Name the reason why a demonstrator is no body like the own one: another body, moved points, another head, and so on.

Every reason is a small model on the final adjustment, with a few unknowns more. A lens bends the own images, too. Of k
unknowns that raise the cost of the own images to C (in variances of the noise), the best model has the least
C + k ln n, the Bayesian information criterion, n the number of image coordinates. The best is named if noise explains
what it leaves. Else another body is named whose links and points all differ a little, if one spread explains that.

Which reasons cannot be distinguished: within a rigid group of points, a longer link, a fixed joint turned, and points
moved on it; a home offset of a joint and its angle; a body larger as a whole and one farther away.

References
----------
Schwarz, "Estimating the dimension of a model", Annals of Statistics 6, 1978.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.adjustment import MIN_POINTS, NOISE_FLOOR_PX, BundleAdjustment
from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.disturbed import N_LENS, fit_lens
from ...geometry.kinematics.model import N_FRAME, ProjectiveKinematics
from ...geometry.kinematics.two_bodies import (
    MOST_STEPS,
    SAME,
    BodyPair,
    Difference,
    fit_homography,
    reverses_orientation,
)
from ..least_squares import posture_grid
from ..misfit import LinkChange, Misfit, MisfitKind
from ..observation import Observation
from .pair_fit import FEW_STEPS, MAX_SIGMAS, CommonAdjustment, PairFit, PostureEstimate, fit_same_body

Array = NDArray[np.float64]
FIRST_STEPS = 4  # steps that show which points fit best
N_FINISHED = 2  # reasons that are fitted to the end, after few steps of each
FD_STEP = 1e-6  # of differences of a link's length
N_FUNDAMENTAL = 7  # unknowns of a fundamental matrix, which a rectification rests on
MAX_REASON_SIGMAS = 3.72  # as MAX_SIGMAS, of a reason why another body differs: once in ten thousand
HOPEFUL = 0.5  # share of the price of a lens that it has to save of the own images, to be fitted to all
MIRROR_GRID = 13  # postures per joint, in which a mirror image is looked for
FIRST_SPREAD = 0.05  # of links and points that all differ, in the body's rms extent, from which its estimate begins
SPREADS = 0.004, 0.1  # that are named: links of ±5 % make 0.007 to 0.03, lenses that are not named 0.003 to 0.009
MIN_LEVER = 0.1  # of the body's extent: a shorter link has no relative length


@dataclass(frozen=True)
class Explanation:
    """A misfit, and the demonstrator's posture if it is the reason."""

    misfit: Misfit
    estimate: PostureEstimate
    margin: float  # by which the criterion of the next best reason is larger; 0 if none explains the images

    def is_convincing(self, max_sigmas: float, margin: float) -> bool:
        """Whether the images contradict it by less than so many standard deviations, and no other is nearly as good."""
        return self.estimate.sigmas < max_sigmas and self.margin > margin


@dataclass(frozen=True)
class Candidate:
    """A fitted reason."""

    kind: MisfitKind
    adjustment: CommonAdjustment
    fit: PairFit
    criterion: float
    points: tuple[int, ...] = ()
    amount: float | None = None

    def finished(self) -> "Candidate":
        """The same reason, fitted to the end."""
        fit = self.adjustment.fit(self.fit.pair)
        return replace(self, fit=fit, criterion=self.criterion - self.fit.raised + fit.raised)


def explain(
    kinematics: ProjectiveKinematics,
    seen: Observations,
    observation: Observation,
    theta: Array,
    seed: int = 0,
) -> Explanation | None:
    """Find the reason why a demonstrator is no body like the own one.

    Parameters
    ----------
    kinematics : ProjectiveKinematics
        Explain all visits.
    seen : Observations
        Own images, with where the arm was.
    observation : Observation
        Gives the demonstrator's images, the joint limits and the noise.
    theta : (m,) array
        Posture near the demonstrator's [rad].
    seed : int, optional
        Of random postures, of three joints or more.

    Returns
    -------
    Explanation or None
        None if the demonstrator may be a body like the own one, or too few points are visible to tell.
    """
    demo, noise_px = observation.demo, max(observation.noise_px, NOISE_FLOOR_PX)
    if demo is None:
        return None
    like_own = fit_same_body(kinematics, seen, demo[None], noise_px, theta[None])
    if like_own is None or like_own[1].sigmas < MAX_SIGMAS:
        return None
    if np.count_nonzero(like_own[0].problem.visible_in_both[0]) < MIN_POINTS:
        return None
    return Reasons(*like_own, seen, replace(observation, noise_px=noise_px), theta, seed).best()[0]


@dataclass(frozen=True)
class Reasons:
    """Fits every reason."""

    adjustment: CommonAdjustment
    same: PairFit  # a body like the own one
    seen: Observations  # own images, with where the arm was
    observation: Observation
    theta: Array  # (m,) rad, near the demonstrator's posture
    seed: int

    def best(self) -> tuple[Explanation, Candidate]:
        """Return the reason with the least criterion; `MisfitKind.NONE` if noise does not explain what it leaves.

        Few steps of each fit show which ones are worth more: the N_FINISHED best are fitted to the end. The margin is
        to the next one, as far as that is fitted.
        """
        criterion = attrgetter("criterion")
        found = sorted(self.all(), key=criterion)
        hopeful = [one.finished() for one in found[:N_FINISHED]]
        best, *others = sorted([*hopeful, *found[N_FINISHED:]], key=criterion)
        if best.fit.sigmas >= MAX_REASON_SIGMAS and (rough := self._differing_everywhere()) is not None:
            misfit = Misfit(rough.kind, amount=rough.amount)
            return Explanation(misfit, rough.adjustment.estimate(rough.fit), 0.0), rough
        estimate = best.adjustment.estimate(best.fit)
        if best.kind is MisfitKind.NONE or best.fit.sigmas >= MAX_REASON_SIGMAS:
            return Explanation(Misfit(MisfitKind.NONE), estimate, 0.0), best
        margin = min((one.criterion for one in others), default=np.inf) - best.criterion
        links = _link_changes(best.adjustment, best.fit) if best.kind is MisfitKind.ANOTHER_BODY else ()
        return Explanation(Misfit(best.kind, best.points, links, best.amount), estimate, float(margin)), best

    def all(self) -> Iterator[Candidate]:
        """Yield each reason with its best fit after few steps."""
        other_head = _fit_other_head(self.adjustment, self.same.pair)
        yield self._candidate(MisfitKind.TWO_HEADS, other_head)
        yield self._candidate(
            MisfitKind.ANOTHER_BODY, _fit_another_body(self.adjustment, self.same.pair, other_head, FEW_STEPS)
        )
        yield from self._points()
        mirrored = self._mirrored()
        if mirrored is not None:
            yield self._candidate(MisfitKind.MIRRORED, mirrored)
        if (lens := self._lens()) is not None:
            yield lens

    def _candidate(self, kind: MisfitKind, fit: PairFit, points: tuple[int, ...] = (), choices: int = 1) -> Candidate:
        """Compute the criterion. choices: number of such reasons, of which this one is the best."""
        unknowns = sum(fit.pair.difference.sizes(fit.pair.n_joints))
        criterion = fit.raised + unknowns * self._log_coordinates + 2 * np.log(choices)
        return Candidate(kind, self.adjustment, fit, criterion, points)

    @property
    def _log_coordinates(self) -> float:
        """Logarithm of the number of image coordinates."""
        problem, pair = self.adjustment.problem, self.same.pair
        freedom = problem.degrees_of_freedom + problem.own.degrees_of_freedom
        return float(np.log(freedom + pair.parameters.size + pair.points.size))

    def _points(self) -> Iterator[Candidate]:
        """Yield the best single point, and the best link, that leave enough points to compare the bodies by."""
        visible, pair = self.adjustment.problem.visible_in_both[0], self.same.pair
        single = [(int(point),) for point in np.flatnonzero(visible)]
        links = [tuple(members[visible[members]].tolist()) for members in pair.body.clusters.points]
        free = min((self.adjustment.problem.degrees_of_freedom - 1) // 3, len(single) - MIN_POINTS)
        several = [points for points in links if len(points) > 1]
        for kind, choices in ((MisfitKind.POINT, single), (MisfitKind.LINK_POINTS, several)):
            if choices := [points for points in choices if len(points) <= free]:
                freed = partial(self._with_points, kind, len(choices))
                begun = [freed(points, FIRST_STEPS) for points in choices]
                yield freed(min(begun, key=attrgetter("criterion")).points)

    def _with_points(
        self, kind: MisfitKind, choices: int, points: tuple[int, ...], max_iter: int = FEW_STEPS
    ) -> Candidate:
        start = self.same.pair.with_difference(Difference(points=points))
        return self._candidate(kind, self.adjustment.fit(start, max_iter), points, choices)

    def _differing_everywhere(self) -> Candidate | None:
        """Fit a body whose links and points all differ a little; None if they differ by too little, or by too much.

        All are normal about the own ones, with one spread, which is estimated twice: χ² of the demonstrator's images
        by noise and spread has as many degrees of freedom as they add.
        """
        visible = tuple(np.flatnonzero(self.adjustment.problem.visible_in_both[0]).tolist())
        spread, pair = FIRST_SPREAD, self.same.pair
        for _ in range(2):
            difference = Difference(shifted=True, points=visible, spread=spread)
            fit = self.adjustment.fit(pair.with_difference(difference), FEW_STEPS)
            differences = fit.pair.parameters[len(pair.parameters) :] / pair.extent
            squares = float(((differences / spread) ** 2).sum()) + fit.raised
            spread *= np.sqrt(squares / self.adjustment.problem.degrees_of_freedom)
            if not SPREADS[0] < spread < SPREADS[1]:
                return None
        return Candidate(MisfitKind.ANOTHER_BODY, self.adjustment, fit, np.inf, visible, float(spread))

    def _mirrored(self) -> PairFit | None:
        """Fit a mirror image, from the posture of a grid in which a reflection agrees best."""
        problem, kinematics = self.adjustment.problem, self.adjustment.kinematics
        postures = posture_grid(self.observation.lower, self.observation.upper, MIRROR_GRID, self.seed)
        visible, frame = problem.visible_in_both[0], kinematics.frame
        own, demo = kinematics.coordinates(postures)[:, visible], frame.coordinates(problem.images[0])[visible]
        H = fit_homography(own, np.broadcast_to(demo, own.shape))
        mapped = np.concatenate([own, np.ones((*own.shape[:-1], 1))], -1) @ H.swapaxes(-1, -2)
        cost = (((mapped[..., :3] / mapped[..., 3:] - demo) * frame.unit_px) ** 2).sum((-1, -2))
        reflects = reverses_orientation(H)
        if not reflects.any():
            return None
        theta = postures[np.where(reflects, cost, np.inf).argmin()]
        starts = problem.starts(kinematics, theta[None], mirror=True)
        return self.adjustment.best_fit(starts, MAX_SIGMAS)

    def _lens(self) -> Candidate | None:
        """Fit a body like the own one to images that a lens bends.

        The own images alone have to favour the lens, by the same criterion, else this is no reason that is named: it
        might bend a mirror image, or another body, into shape. It may take the place of a rectification, which has
        unknowns, too. Both fits know the same points: a cost of fewer ones would be smaller.
        """
        demo, noise_px = self.observation.demo, self.observation.noise_px
        assert demo is not None  # by `explain`
        seen, straight = self.seen, self.adjustment.kinematics
        found = fit_lens(seen, noise_px, straight.moved_by, ~straight.unknown, straight.rectification)
        if found is None:
            return None
        kinematics, lens = found
        own, theirs = lens.straightened(seen.images), lens.straightened(demo[None])[0]
        replaced = N_FUNDAMENTAL if straight.rectification is not None and kinematics.rectification is None else 0
        price = (N_LENS - replaced) * self._log_coordinates
        alone = BundleAdjustment.of(kinematics, replace(seen, images=own), noise_px).restricted_to_known(kinematics)
        left = float((alone.residuals(kinematics) ** 2).sum())
        if self.adjustment.own_cost - left < HOPEFUL * price * self.adjustment.variance:
            return None
        weight = self.adjustment.problem.weight
        like_own = fit_same_body(
            kinematics, replace(seen, images=own), theirs[None], noise_px, self.theta[None], weight
        )
        if like_own is None:
            return None
        adjustment, fit = like_own
        saved = (self.adjustment.own_cost - adjustment.own_cost) / self.adjustment.variance
        kind = MisfitKind.LENS if saved > price else MisfitKind.NONE
        bent = float(np.nanmax(np.abs([*(own - seen.images), theirs - demo])))
        return Candidate(kind, adjustment, fit, fit.raised - saved + price, amount=bent)


def _fit_other_head(adjustment: CommonAdjustment, same: BodyPair) -> PairFit:
    return adjustment.fit(same.with_difference(Difference(other_head=True)), FEW_STEPS)


def _fit_another_body(
    adjustment: CommonAdjustment, same: BodyPair, other_head: PairFit, max_iter: int = MOST_STEPS
) -> PairFit:
    """Fit another body, from the pair of like bodies and from that of another head: it absorbs more of what differs."""
    other = other_head.pair
    starts = same, replace(other, parameters=other.parameters[:-N_FRAME], difference=SAME)
    fits = [adjustment.fit(start.with_difference(Difference(shifted=True)), max_iter) for start in starts]
    return min(fits, key=lambda fit: fit.raised)


def explain_again(
    kinematics: ProjectiveKinematics,
    seen: Observations,
    demos: Array,
    postures: Array,
    noise_px: float,
) -> Explanation | None:
    """Explain a demonstrator that is another body by one such body in several postures.

    Parameters
    ----------
    kinematics, seen
        As of `explain`.
    demos : (Q, N, 4) array
        The demonstrator's images in [l, r], px; NaN where hidden.
    postures : (Q, m) array
        Postures near those of the demonstrator [rad]; its base stays where it is.
    noise_px : float
        Standard deviation of an image coordinate.

    Returns
    -------
    Explanation or None
        With the first posture. None if it may be a body like the own one, or if noise does not explain what another
        body leaves: the base has moved, or this is another demonstrator.
    """
    like_own = fit_same_body(kinematics, seen, demos, max(noise_px, NOISE_FLOOR_PX), postures)
    if like_own is None or like_own[1].sigmas < MAX_SIGMAS:
        return None
    adjustment, same = like_own[0], like_own[1].pair
    fit = _fit_another_body(adjustment, same, _fit_other_head(adjustment, same))
    if fit.sigmas >= MAX_SIGMAS:
        return None
    misfit = Misfit(MisfitKind.ANOTHER_BODY, links=_link_changes(adjustment, fit))
    return Explanation(misfit, adjustment.estimate(fit), np.inf)


def _link_changes(adjustment: CommonAdjustment, fit: PairFit) -> tuple[LinkChange, ...]:
    """Return how much longer each link between two moving joints is, the base outwards.

    A link's length is the radius of the circle on which its inner joint carries the outer one: of the point on the
    outer axis that is nearest to all points beyond it.
    """
    pair = fit.pair
    order = np.argsort(-pair.kinematics.moved_by.sum(0), kind="stable")
    covariance = fit.std**2 * adjustment.problem.covariance(pair)
    steps = FD_STEP * np.eye(1 + len(pair.parameters), len(pair.parameters), -1)
    found = []
    for inner, outer in zip(order[:-1].tolist(), order[1:].tolist()):
        changes = [_relative_length(replace(pair, parameters=pair.parameters + step), inner, outer) for step in steps]
        if np.isfinite(changes).all():
            gradient = (np.array(changes[1:]) - changes[0]) / FD_STEP
            std = float(np.sqrt(max(float(gradient @ covariance @ gradient), 0.0)))
            found.append(LinkChange((inner, outer), float(changes[0]), std))
    return tuple(found)


def _relative_length(pair: BodyPair, inner: int, outer: int) -> float:
    """Return the demonstrator's length of a link over the own one, minus 1; NaN of prismatic joints and short links."""
    body = pair.body
    twists = body.parameters[N_FRAME:].reshape(-1, 6)
    spin, velocity = twists[:, :3], twists[:, 3:]
    squared = (spin**2).sum(1, keepdims=True)
    if squared[[inner, outer]].min() == 0:
        return np.nan
    axes, feet = spin / np.sqrt(squared), np.cross(spin, velocity) / squared
    known = ~np.isnan(body.points[:, 0])
    homogeneous = np.concatenate([body.points[known], np.ones((known.sum(), 1))], 1) @ body.metric_upgrade.T
    metric = homogeneous[:, :3] / homogeneous[:, 3:]
    beyond = metric[body.moved_by[known, outer]].mean(0)
    centre = feet[outer] + axes[outer] * (axes[outer] @ (beyond - feet[outer]))
    arms = np.array([centre, centre + pair.shifts[outer]]) - feet[inner]
    own, theirs = np.linalg.norm(arms - np.outer(arms @ axes[inner], axes[inner]), axis=1)
    return float(theirs / own - 1) if own > MIN_LEVER * metric.std() else np.nan
