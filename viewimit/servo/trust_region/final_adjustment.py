"""The last step of a run: one adjustment of the own visits and the demonstrator's images, with one head for both.

It estimates the demonstrator's posture by maximum likelihood, with its covariance, and tests whether the demonstrator
is a body like the own one. The conflict E compares images by a homography of space with fifteen parameters. The
adjustment has seven, since the own motions show which homographies keep a body's size and shape (`two_bodies`).

The own body is fitted again first, and with it which joints move each point (`maximum_likelihood`). Where the own
images leave that open, each choice is adjusted with the demonstrator's images. The best choice gives the posture. Its
variance is the mean of the squared errors about it over all choices, weighted by their likelihood.

The test is an F-test. The demonstrator's images raise the cost of the own images alone by σ² χ²_f if both bodies are
alike. The own images have that noise, too, so their cost over its degrees of freedom estimates σ². It is a better
estimate than the noise at rest, and without the error of that one. The same test shows whether learned kinematics have
predicted a visit: its images raise the cost of those before by as little if the kinematics are right.

References
----------
Chow, "Tests of equality between sets of coefficients in two linear regressions", Econometrica 1960.
Paulson, "An approximate normalization of the analysis of variance distribution", 1942.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...estimation.noise import f_test_sigmas
from ...geometry.kinematics.adjustment import BundleAdjustment
from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.maximum_likelihood import Likely, likely_kinematics
from ...geometry.kinematics.model import ProjectiveKinematics
from ...geometry.kinematics.two_bodies import MAX_ITER, BodyPair, PairAdjustment
from ..observation import Observation, Visit
from .image_models import observations_of
from .options import TrustRegionOptions

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PostureEstimate:
    """The demonstrator's posture by the adjustment."""

    theta: Array  # (m,) rad, as a displacement
    std_error: Array  # (m,) rad
    sigmas: float  # by how many standard deviations the demonstrator's images contradict a body like the own one
    demo: Array  # (N, 4) px: its images, NaN where hidden


@dataclass(frozen=True)
class PairFit:
    """A pair of bodies, fitted."""

    pair: BodyPair
    cost: float  # px²
    raised: float  # cost above that of the own images alone, over the variance of the noise
    sigmas: float  # by how many standard deviations it is too much for noise
    std: float  # of the noise, px


@dataclass(frozen=True)
class FinalAdjustment:
    """The adjustment of one run."""

    problem: PairAdjustment
    kinematics: ProjectiveKinematics  # that explain the own images
    own_cost: float  # px², of the own images alone
    variance: float  # px², of an image coordinate

    @classmethod
    def of(
        cls, likely: Likely, observations: Observations, demo: Array, noise_px: float, weight: float = 1.0
    ) -> "FinalAdjustment | None":
        """Set it up; None if too few points are visible for any test.

        likely: explains all visits; demo: (T, N, 4) px in [l, r], NaN where hidden; noise_px: standard deviation of an
        own image's coordinate; weight: as of `PairAdjustment`.
        """
        problem = PairAdjustment.of(likely.kinematics, observations, demo, noise_px, weight)
        if problem.degrees_of_freedom < 1 or problem.own.degrees_of_freedom < 1:
            return None
        return cls(problem, likely.kinematics, likely.cost, likely.variance(problem.own))

    def fit(self, start: BodyPair, max_iter: int = MAX_ITER) -> PairFit:
        """Fit from one pair, in at most `max_iter` steps."""
        pair = self.problem.solve(start, max_iter)
        unwound = pair.unwound(start.angles)
        pair = pair if unwound is pair else self.problem.solve(unwound, max_iter)
        cost = float((self.problem.residuals(pair) ** 2).sum())
        raised, added = max(cost - self.own_cost, 0.0) / self.variance, sum(pair.difference.sizes(pair.n_joints))
        freedom, own_freedom = self.problem.degrees_of_freedom - added, self.problem.own.degrees_of_freedom
        sigmas = f_test_sigmas(raised / freedom, freedom, own_freedom) if freedom > 0 else np.inf
        noise = max(self.problem.own.noise_px**2, cost / max(freedom + own_freedom, 1))
        return PairFit(pair, cost, raised, sigmas, float(np.sqrt(noise)))

    def best_fit(self, starts: Iterable[BodyPair], max_sigmas: float) -> PairFit | None:
        """Fit from each pair in turn, until one fit contradicts by less than `max_sigmas`; return the best."""
        best: PairFit | None = None
        for start in starts:
            found = self.fit(start)
            if best is None or found.raised < best.raised:
                best = found
            if best.sigmas < max_sigmas:
                break
        return best

    def estimate(self, fit: PairFit, demo: Array) -> PostureEstimate:
        """Return the first posture of a fit. demo: (N, 4) px, the images that it is of."""
        std_error = fit.std * self.problem.angle_std(fit.pair)[0]
        return PostureEstimate(fit.pair.angles[0], std_error, fit.sigmas, demo)


@dataclass(frozen=True)
class SameBody:
    """A demonstrator like the own body, fitted with each likely choice of the joints that move the points."""

    fits: tuple[tuple[FinalAdjustment, PairFit], ...]  # the best first

    @property
    def adjustment(self) -> FinalAdjustment:
        return self.fits[0][0]

    @property
    def fit(self) -> PairFit:
        return self.fits[0][1]

    def estimate(self, demo: Array) -> PostureEstimate:
        """Return the posture of the best fit, with the uncertainty by all. demo: (N, 4) px, its images."""
        each = [adjustment.estimate(fit, demo) for adjustment, fit in self.fits]
        raised = np.array([fit.cost - self.fit.cost for _, fit in self.fits]) / self.adjustment.variance
        squares = [one.std_error**2 + (one.theta - each[0].theta) ** 2 for one in each]
        return replace(each[0], std_error=np.sqrt(np.average(squares, axis=0, weights=np.exp(-raised / 2))))


def prediction_sigmas(
    previous: ProjectiveKinematics, found: ProjectiveKinematics, observations: Observations, noise_px: float
) -> float:
    """Return by how many standard deviations the last visit contradicts kinematics that did not know it.

    previous: fitted to all visits but the last; found: from there, to all; noise_px: standard deviation of an image
    coordinate.
    """
    if (found.moved_by != previous.moved_by)[~previous.unknown].any():
        return np.inf  # it has changed them
    known = observations.restrict(~previous.unknown)
    earlier = known.select_visits(np.arange(len(known.displacement)) < len(known.displacement) - 1)
    before = BundleAdjustment.of(previous, earlier, noise_px)
    after = BundleAdjustment.of(found, known, noise_px)
    freedom, added = before.degrees_of_freedom, after.degrees_of_freedom - before.degrees_of_freedom
    if freedom < 1 or added < 1:
        return np.inf
    cost, cost_after = (float((one.residuals(k) ** 2).sum()) for one, k in ((before, previous), (after, found)))
    raised = max(cost_after - cost, 0.0) / Likely(previous, cost, cost).variance(before)
    return f_test_sigmas(raised / added, added, freedom)


def estimate_posture(
    kinematics: ProjectiveKinematics,
    visits: tuple[Visit, ...],
    observation: Observation,
    theta: Array,
    options: TrustRegionOptions,
) -> PostureEstimate | None:
    """Adjust own and demonstrator's images together.

    Parameters
    ----------
    kinematics : ProjectiveKinematics
        Explain all visits.
    visits : tuple of Visit
    observation : Observation
        Gives the demonstrator's images and the noise.
    theta : (m,) array
        Posture near the demonstrator's [rad].
    options : TrustRegionOptions

    Returns
    -------
    PostureEstimate or None
        None without the demonstrator's images, or if too few points are visible for any test.
    """
    if observation.demo is None:
        return None
    demos = observation.demo[None]
    found = fit_same_body(kinematics, visits, demos, observation.noise_px, theta[None], options)
    return None if found is None else found.estimate(observation.demo)


def fit_same_body(
    kinematics: ProjectiveKinematics,
    visits: tuple[Visit, ...],
    demos: Array,
    noise_px: float,
    postures: Array,
    options: TrustRegionOptions,
    weight: float = 1.0,
) -> SameBody | None:
    """Fit a demonstrator like the own body, from postures near its own; None if too few points are visible.

    demos: (T, N, 4) px in [l, r], NaN where hidden; noise_px: of an image coordinate; postures: (T, m) rad. The rest is
    as of `estimate_posture`.
    """
    seen = observations_of(visits)
    problem = BundleAdjustment.of(kinematics, seen, noise_px).restricted_to_known(kinematics)
    fits: list[tuple[FinalAdjustment, PairFit]] = []
    for likely in likely_kinematics(kinematics, problem):
        adjustment = FinalAdjustment.of(likely, seen, demos, noise_px, weight)
        if adjustment is None:
            return None
        fit = adjustment.best_fit(adjustment.problem.starts(likely.kinematics, postures), options.max_body_sigmas)
        fits += [] if fit is None else [(adjustment, fit)]
    of_choice: dict[bytes, tuple[FinalAdjustment, PairFit]] = {}
    for one in sorted(fits, key=lambda one: one[1].cost):
        of_choice.setdefault(one[0].kinematics.moved_by.tobytes(), one)
    return SameBody(tuple(of_choice.values())) if fits else None
