"""The learner's body, learned from its own images: one likelihood for shape, motions, joints of the points, and arm.

Unknown are the projective kinematics (frame, a twist for each joint, a position for each point), which joints move each
point (`chains`), and where the arm was at each visit if it is not where it was sent. Image coordinates have independent
noise of one standard deviation σ, so -2 log likelihood is the sum of squared residuals over σ².

The arm is exact; or stops short by a share s of each motion (one unknown); or is loose: off by another angle at each
visit, with a normal prior whose standard deviation is estimated from these angles. The first of these that noise
explains is taken: it has the fewest unknowns. Once an arm was found short or loose, simpler ones are not tried again,
unless it is hardly loose. Images are in the units of whoever calls, and what ends in `_px` follows them.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..rectification import Rectification
from .adjustment import MIN_POINTS, NEAR_RAD, BundleAdjustment, is_of_parallel_cameras
from .bundle import levenberg_marquardt
from .chains import first_chains, with_likely_chains
from .clusters import Observations
from .disturbed import Extended, Shortfall, fit_shortfall
from .model import ProjectiveKinematics, StereoFrame

Array = NDArray[np.float64]
ROUNDS, LOOSE_ROUNDS = 5, 3  # of motions and chains in turn
FIRST_SLACK, LEAST_SLACK, MOST_SLACK = np.radians([1.0, 0.1, 5.0])  # rad: std of a loose arm, at first; its bounds
LEAST_NOISE_PX = 1e-2  # of a loose arm's images: below it offsets explain rounding
FTOL, MAX_ITER = 1e-4, 60


@dataclass(frozen=True)
class OwnBody:
    """What the own images say."""

    kinematics: ProjectiveKinematics
    seen: Observations  # with where the arm was, as estimated
    noise_px: float  # standard deviation of an image coordinate, as measured
    cost: float  # px², of the own images
    share: float = 0.0  # of each motion that the arm misses
    slack: float = 0.0  # rad: standard deviation of a loose arm

    @classmethod
    def of(cls, kinematics: ProjectiveKinematics, seen: Observations, noise_px: float, share: float = 0.0) -> "OwnBody":
        """Compute what the kinematics leave of the images."""
        found = cls(kinematics, seen, noise_px, 0.0, share)
        return replace(found, cost=float((found.problem.residuals(kinematics) ** 2).sum()))

    @property
    def problem(self) -> BundleAdjustment:
        return BundleAdjustment.of(self.kinematics, self.seen, self.noise_px).restricted_to_known(self.kinematics)

    @property
    def here(self) -> Array:
        """(m,) rad: where the arm is."""
        return self.seen.displacement[-1]

    def to_reach(self, sent: Array, target: Array) -> Array:
        """Return where to send the arm next to reach a target, (m,) rad each. sent: where it was sent last."""
        return Shortfall(self.share).to_reach(self.here, target) if self.share else sent + (target - self.here)


def learn(
    sent: Observations, noise_px: float, rectification: Rectification | None, previous: OwnBody | None = None
) -> OwnBody | None:
    """Fit the body to all own images.

    Parameters
    ----------
    sent : Observations
        Images of K visits, in the order of the motions, and where the arm was sent.
    noise_px : float
        Standard deviation of an image coordinate.
    rectification : Rectification or None
        Of the images.
    previous : OwnBody, optional
        That explained all visits but the last one.

    Returns
    -------
    OwnBody or None
        None if the images determine no body, or none explains them.
    """
    if previous is not None and (previous.kinematics.rectification is None) != (rectification is None):
        previous = None
    if previous is None:
        first = 0
    elif previous.slack > LEAST_SLACK:
        first = 2
    else:
        first = 1 if previous.share else 0
        previous = None if previous.slack else previous  # hardly loose: try it as exact again
    arms = (exact_body, _short, _loose)  # the last kind first, from the last body, then from scratch; then looser ones
    for fit in arms[first:]:
        for start in (previous, None) if fit is arms[first] and previous is not None else (None,):
            if (found := fit(sent, noise_px, rectification, start)) is not None:
                return found
    return None


def idle_joints(seen: Observations, noise_px: float, least_px: float) -> NDArray[np.bool_]:
    """Return which joints moved no visible point when they turned alone between two visits, (m,) bool.

    noise_px: of an image coordinate; least_px: motion of a point that counts without noise.
    """
    turned = np.abs(np.diff(seen.displacement, axis=0)) > 1e-9
    farthest = np.nan_to_num(np.abs(np.diff(seen.images, axis=0)).max(-1)).max(1)
    moved = farthest > max(least_px, 5 * np.sqrt(2) * noise_px)
    alone = turned & (turned.sum(1, keepdims=True) == 1)
    return np.asarray(alone.any(0) & ~(alone & moved[:, None]).any(0))


def with_offsets(sent: Array, more: Array) -> Array:
    """Where a loose arm was: (K, m) rad, and offsets of all visits but the first, (..., (K - 1) m) → (..., K, m)."""
    off = more.reshape(*more.shape[:-1], len(sent) - 1, sent.shape[1])
    return sent + np.concatenate([np.zeros((*off.shape[:-2], 1, sent.shape[1])), off], -2)


def _begin(
    sent: Observations, noise_px: float, rectification: Rectification | None, previous: OwnBody | None
) -> tuple[ProjectiveKinematics, BundleAdjustment] | None:
    """Kinematics to begin with, and the problem; None if the images leave open what any joint does."""
    if previous is not None:
        kinematics = replace(previous.kinematics, rectification=rectification)
        problem = BundleAdjustment.of(kinematics, sent, noise_px)
        return (kinematics, problem) if is_of_parallel_cameras(kinematics.frame, noise_px) else None
    chains = first_chains(sent, noise_px)
    if chains is None or len(sent.displacement) <= sent.displacement.shape[1] or sent.n_points < MIN_POINTS:
        return None
    images = sent.images[sent.visible_in_both]
    frame = StereoFrame.fit(images if rectification is None else rectification.apply(images))
    if not is_of_parallel_cameras(frame, noise_px):
        return None
    kinematics = ProjectiveKinematics.initial(sent.images.shape[1], sent.displacement[0], frame, rectification)
    problem = BundleAdjustment.of(kinematics, sent, noise_px)
    kinematics = replace(kinematics, moved_by=chains[0]).with_points(chains[1], sent, problem.coordinates)
    return kinematics, problem


def exact_body(
    sent: Observations,
    noise_px: float,
    rectification: Rectification | None = None,
    previous: OwnBody | None = None,
) -> OwnBody | None:
    """Fit the body of an arm that is where it was sent; arguments as of `learn`.

    Points whose images no chain explains are left out. None if the images determine no body, or none explains them.
    """
    if (begin := _begin(sent, noise_px, rectification, previous)) is None:
        return None
    kinematics, problem = begin
    if previous is None:  # nearby visits first: there is no other minimum
        near = np.abs(sent.displacement - kinematics.reference).max(1) < NEAR_RAD
        if len(kinematics.reference) < near.sum() < len(near):
            kinematics = _solved(kinematics, problem.select_visits(near))
    kinematics, found = _solved(kinematics, problem), None
    for _ in range(ROUNDS):
        known = problem.restricted_to_known(kinematics)
        fits = known.degrees_of_freedom > 0 and known.fits_noise(kinematics)
        found = OwnBody.of(kinematics, sent, noise_px) if fits else found
        doubtful = kinematics.unknown if fits else np.ones(len(kinematics.points), bool)
        likely = with_likely_chains(kinematics, problem, doubtful & (sent.visible_in_both.sum(0) > 1))
        if likely is kinematics:
            break
        kinematics = _solved(likely, problem)
    return found


def _solved(kinematics: ProjectiveKinematics, problem: BundleAdjustment) -> ProjectiveKinematics:
    problem = problem.restricted_to_known(kinematics)
    prior = problem.prior_weights(len(kinematics.parameters))
    return levenberg_marquardt(kinematics, problem.residuals, prior, FTOL, MAX_ITER)


def _short(
    sent: Observations, noise_px: float, rectification: Rectification | None, previous: OwnBody | None
) -> OwnBody | None:
    """An arm that misses a share of each motion."""
    before = None if previous is None else (previous.kinematics, Shortfall(previous.share))
    if (found := fit_shortfall(sent, noise_px, rectification, before)) is None:
        return None
    kinematics, shortfall = found
    there = replace(sent, displacement=shortfall.reached(sent.displacement))
    return OwnBody.of(kinematics, there, noise_px, shortfall.share)


def _loose(
    sent: Observations, noise_px: float, rectification: Rectification | None, previous: OwnBody | None
) -> OwnBody | None:
    """An arm that is off by a different angle at each visit."""
    if len(sent.displacement) < 2 * sent.displacement.shape[1] + 1:
        return None
    more, slack = np.zeros(sent.displacement[1:].size), FIRST_SLACK
    if previous is not None:
        off = (previous.seen.displacement - sent.displacement[: len(previous.seen.displacement)])[1:].ravel()
        more[: len(off)], slack = off[: len(more)], previous.slack
    arm: Callable[[Array], Array] = lambda more: with_offsets(sent.displacement, more)
    begin = _begin(sent, max(noise_px, LEAST_NOISE_PX), rectification, previous)
    if begin is None:
        return None
    kinematics, problem = begin
    for _ in range(LOOSE_ROUNDS):
        known = problem.restricted_to_known(kinematics)
        weights = np.full(len(more), (max(noise_px, LEAST_NOISE_PX) / slack) ** 2)
        prior = np.concatenate([known.prior_weights(len(kinematics.parameters)), weights])
        initial = Extended(np.concatenate([kinematics.parameters, more]), kinematics.points, kinematics)
        residuals: Callable[[Extended], Array] = lambda model: known.residuals(model.body, arm(model.more))  # noqa: B023
        found = levenberg_marquardt(initial, residuals, prior, FTOL, MAX_ITER)
        kinematics, more = found.body, found.more
        there = replace(problem, observations=replace(sent, displacement=arm(more)))
        known = there.restricted_to_known(kinematics)
        if known.degrees_of_freedom > 0 and known.fits_noise(kinematics):
            slack = float(np.sqrt((more**2).mean()))
            body = OwnBody.of(kinematics, there.observations, noise_px)
            return replace(body, slack=max(slack, LEAST_SLACK)) if slack <= MOST_SLACK else None
        likely = with_likely_chains(kinematics, there, sent.visible_in_both.sum(0) > 1)
        if likely is kinematics:
            return None
        kinematics = likely
    return None
