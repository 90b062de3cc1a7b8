"""One adjustment of the own images and the demonstrator's, with one head for both.

It estimates the demonstrator's posture by maximum likelihood, with its covariance, and tests whether the demonstrator
is a body like the own one. The conflict E compares images by a homography of space with fifteen parameters. The
adjustment has seven, since the own motions show which homographies keep a body's size and shape (`two_bodies`).

The test is an F-test. The demonstrator's images raise the cost of the own images alone by σ² χ²_f if both bodies are
alike. The own images have that noise, too, so their cost over its degrees of freedom estimates σ². It is a better
estimate than the noise at rest, and without the error of that one.

References
----------
Chow, "Tests of equality between sets of coefficients in two linear regressions", Econometrica 1960.
Paulson, "An approximate normalization of the analysis of variance distribution", 1942.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.adjustment import BundleAdjustment
from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.maximum_likelihood import Likely, likely_kinematics
from ...geometry.kinematics.model import ProjectiveKinematics
from ...geometry.kinematics.two_bodies import MOST_STEPS, BodyPair, PairAdjustment

Array = NDArray[np.float64]
FEW_STEPS = 25  # that show whether a start leads anywhere
MAX_SIGMAS = 3.09  # standard deviations; the right hypothesis contradicts by more once in a thousand


def f_test_sigmas(ratio: float, numerator: int, denominator: int) -> float:
    """Convert a ratio of two variances to standard deviations of a normal variable.

    Parameters
    ----------
    ratio : float
        Of two independent mean squares with the same expectation.
    numerator, denominator : int
        Their degrees of freedom.

    Returns
    -------
    float
        The standard normal quantile of F, by the approximation of Paulson (1942); 3.09 is exceeded once in a thousand.
    """
    root, a, b = np.cbrt(ratio), 2 / (9 * numerator), 2 / (9 * denominator)
    return float(((1 - b) * root - (1 - a)) / np.sqrt(a + b * root**2))


@dataclass(frozen=True)
class PostureEstimate:
    """The demonstrator's posture by the adjustment."""

    theta: Array  # (m,) rad, as a displacement
    std_error: Array  # (m,) rad
    sigmas: float  # by how many standard deviations the demonstrator's images contradict a body like the own one


@dataclass(frozen=True)
class PairFit:
    """A pair of bodies, fitted."""

    pair: BodyPair
    cost: float  # px²
    raised: float  # cost above that of the own images alone, over the variance of the noise
    sigmas: float  # by how many standard deviations it is too much for noise
    std: float  # of the noise, px


@dataclass(frozen=True)
class CommonAdjustment:
    """The adjustment of both bodies."""

    problem: PairAdjustment
    kinematics: ProjectiveKinematics  # that explain the own images
    own_cost: float  # px², of the own images alone
    variance: float  # px², of an image coordinate

    @classmethod
    def of(
        cls, likely: Likely, observations: Observations, demo: Array, noise_px: float, weight: float = 1.0
    ) -> "CommonAdjustment | None":
        """Set it up; None if too few points are visible for any test.

        likely: explains all visits; demo: (Q, N, 4) px in [l, r], NaN where hidden; noise_px: standard deviation of an
        own image's coordinate; weight: as of `PairAdjustment`.
        """
        problem = PairAdjustment.of(likely.kinematics, observations, demo, noise_px, weight)
        if problem.degrees_of_freedom < 1 or problem.own.degrees_of_freedom < 1:
            return None
        return cls(problem, likely.kinematics, likely.cost, likely.variance(problem.own))

    def fit(self, start: BodyPair, max_iter: int = MOST_STEPS) -> PairFit:
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
        """Fit from each pair in turn, until one fit contradicts by less than `max_sigmas`; return the best.

        A few steps of each show which one leads farthest; that one is fitted to the end.
        """
        best: PairFit | None = None
        for start in starts:
            found = self.fit(start, FEW_STEPS)
            if best is None or found.raised < best.raised:
                best = found
            if best.sigmas < max_sigmas:
                break
        return None if best is None else self.fit(best.pair)

    def estimate(self, fit: PairFit) -> PostureEstimate:
        """Return the first posture of a fit."""
        std_error = fit.std * self.problem.angle_std(fit.pair)[0]
        return PostureEstimate(fit.pair.angles[0], std_error, fit.sigmas)


def fit_same_body(
    kinematics: ProjectiveKinematics,
    seen: Observations,
    demos: Array,
    noise_px: float,
    postures: Array,
    weight: float = 1.0,
) -> tuple[CommonAdjustment, PairFit] | None:
    """Fit a demonstrator like the own body, from postures near its own; None if too few points are visible.

    kinematics: explain the own images `seen`; demos: (Q, N, 4) px in [l, r], NaN where hidden; noise_px: of an image
    coordinate; postures: (Q, m) rad; weight: as of `PairAdjustment`. Of the likely choices of the joints that move the
    points, the best is taken.
    """
    problem = BundleAdjustment.of(kinematics, seen, noise_px).restricted_to_known(kinematics)
    best: tuple[CommonAdjustment, PairFit] | None = None
    for likely in likely_kinematics(kinematics, problem):
        adjustment = CommonAdjustment.of(likely, seen, demos, noise_px, weight)
        if adjustment is None:
            return None
        fit = adjustment.best_fit(adjustment.problem.starts(likely.kinematics, postures), MAX_SIGMAS)
        if fit is not None and (best is None or fit.cost < best[1].cost):
            best = adjustment, fit
    return best
