"""The last step of a run: one adjustment of the own visits and the demonstrator's images, with one head for both.

It estimates the demonstrator's posture by maximum likelihood, with its covariance, and tests whether the demonstrator
is a body like the own one. The conflict E compares images by a homography of space with fifteen parameters. The
adjustment has seven, since the own motions show which homographies keep a body's size and shape (`two_bodies`).

The test is an F-test. The demonstrator's images raise the cost of the own images alone by σ² χ²_f if both bodies are
alike. The own images have that noise, too, so their cost over its degrees of freedom estimates σ². It is a better
estimate than the noise at rest, and without the error of that one.

References
----------
Paulson, "An approximate normalization of the analysis of variance distribution", 1942.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...estimation.noise import f_test_sigmas
from ...geometry.kinematics.adjustment import NOISE_SLACK
from ...geometry.kinematics.model import ProjectiveKinematics
from ...geometry.kinematics.two_bodies import PairAdjustment
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
    problem = PairAdjustment.of(kinematics, observations_of(visits), observation.demo[None], observation.noise_px)
    if problem.degrees_of_freedom < 1 or problem.own.degrees_of_freedom < 1:
        return None
    own = float((problem.own.residuals(kinematics) ** 2).sum())
    best, raised, sigmas = None, np.inf, np.inf
    variance = max(own / problem.own.degrees_of_freedom, (observation.noise_px / NOISE_SLACK) ** 2)
    for start in problem.starts(kinematics, theta):
        found = problem.solve(start)
        cost = float((problem.residuals(found) ** 2).sum()) - own
        if cost < raised:
            best, raised = found, cost
            ratio = max(cost, 0.0) / problem.degrees_of_freedom / variance
            sigmas = f_test_sigmas(ratio, problem.degrees_of_freedom, problem.own.degrees_of_freedom)
        if sigmas < options.max_body_sigmas:
            break
    if best is None:
        return None
    freedom = problem.degrees_of_freedom + problem.own.degrees_of_freedom
    std = max(observation.noise_px, np.sqrt((raised + own) / freedom))
    return PostureEstimate(best.angles[0], std * problem.angle_std(best)[0], sigmas)
