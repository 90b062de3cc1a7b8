"""Follow a demonstrator that keeps moving: by its angles alone, as the place where it stands is known.

Its first 16 images since it began to move share one similarity, which is adjusted again after 2, 4, 8 and 16. The
arm goes to where the demonstrator will be at the next look: a line through its last few angles is continued.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.adjustment import NOISE_FLOOR_PX
from ...geometry.kinematics.maximum_likelihood import Likely
from ...geometry.kinematics.own_body import OwnBody
from ..least_squares import minimise
from ..observation import Observation
from ..status import ServoStatus
from .hypotheses import Estimate
from .pair_fit import MAX_SIGMAS, CommonAdjustment
from .state import Displacement, EstimatorState, Purpose

MAX_TRAIL = 16  # looks that are remembered
ON_LINE = 3  # of these, that the line is fitted to; without noise two
MIN_POINTS = 4  # of an image that tells the angles
STEPS = 10  # of an adjustment


def follow(state: EstimatorState, body: OwnBody, see: Observation) -> tuple[EstimatorState, Displacement]:
    """Go where a moving demonstrator will be."""
    best, demo = state.best, see.demo
    assert best is not None and demo is not None
    theta = angles_at_known_place(best, demo, see)
    trail = (*state.trail, (demo, theta))[-MAX_TRAIL:]
    if len(trail) > 1 and len(trail) & (len(trail) - 1) == 0 and len(state.trail) < MAX_TRAIL:
        best = with_place_adjusted(best, body, see, trail)
    best = replace(best, theta=theta)
    state = replace(state, best=best, trail=trail, status=ServoStatus.MOVING, probe=False, purpose=Purpose.FOLLOW)
    on_line = trail[-ON_LINE:] if see.noise_px > 0 else trail[-2:]
    ahead = np.clip(expected([angles for _, angles in on_line]), see.lower, see.upper)
    return state, ahead - see.displacement


def expected(angles: list[Displacement]) -> Displacement:
    """The angles at the next look, by a line through the last few, (m,) rad each."""
    last = np.array(angles)
    if len(last) == 1:
        return last[0]
    steps = np.arange(len(last)) - (len(last) - 1) / 2
    slope = steps @ last / (steps @ steps)
    return last.mean(0) + slope * ((len(last) + 1) / 2)


def angles_at_known_place(before: Estimate, demo: NDArray[np.float64], see: Observation) -> Displacement:
    """Fit the joint angles alone, (m,) rad, to the demonstrator's image (N, 4); its place stays as estimated."""
    assert before.fit is not None
    pair, frame = before.fit.pair, before.fit.pair.kinematics.frame
    seen = np.isfinite(demo).all(1) & ~np.isnan(pair.points[:, 0])
    if np.count_nonzero(seen) < MIN_POINTS:
        return before.theta
    observed = pair.kinematics.coordinates_of(demo[seen])
    unit_px = frame.unit_px / pair.kinematics.magnification(demo[seen])

    def residuals(theta: NDArray[np.float64]) -> NDArray[np.float64]:
        shown = pair.in_postures(theta[..., None, :]).demonstrator()[..., 0, :, :]
        return (shown[..., seen, :] - observed) * unit_px

    return minimise(residuals, before.theta[None], see.lower, see.upper).theta


def with_place_adjusted(
    best: Estimate, body: OwnBody, see: Observation, trail: tuple[tuple[NDArray[np.float64], Displacement], ...]
) -> Estimate:
    """Adjust the place where it stands to all its images; the same estimate if they contradict one place."""
    assert best.fit is not None and best.adjustment is not None
    k = best.adjustment.kinematics
    demos, postures = (np.array(one) for one in zip(*trail))
    own = Likely(k, best.adjustment.own_cost, best.adjustment.own_cost)
    observations = best.adjustment.problem.own.observations
    adjustment = CommonAdjustment.of(own, observations, demos, max(see.noise_px, NOISE_FLOOR_PX))
    if adjustment is None:
        return best
    fit = adjustment.fit(best.fit.pair.in_postures(postures), STEPS)
    if fit.sigmas >= MAX_SIGMAS:
        return best
    return replace(best, fit=replace(best.fit, pair=fit.pair.in_postures(fit.pair.angles[-1:])))
