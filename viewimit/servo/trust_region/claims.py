"""What a claim must pass besides the certificate: the goal is inside the joint limits, and the image model is right.

The certificate is of the posture where the arm may rest. If that posture was clipped to the joint limits, it is not the
demonstrator's, and a test shows by how many standard errors it is not. The certificate also takes the noise at rest for
the error of the image model. Kinematics that explain all visits have been tested by it. A Gaussian process has not: its
error is what it makes in predicting each visit from all others.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...geometry.kinematics.adjustment import NOISE_FLOOR_PX, fit_kinematics
from ..least_squares import minimise
from ..status import ServoStatus
from .gaussian_process import cross_validated_noise
from .image_models import observations_of
from .misfit import BeyondLimit, Misfit, MisfitKind
from .rules import StepContext, at_joint_limit
from .state import TrustRegionState


def with_kinematics_sought(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Fit kinematics before a claim without them: at most visits, none are looked for."""
    if state.kinematics is not None or state.mismatch is not None or context.observation.noise_px == 0:
        return state
    observation = context.observation
    found = fit_kinematics(observations_of(state.known), observation.noise_px, observation.rectification)
    if found is None:
        return state
    context.images = replace(context.images, kinematics=found)
    return replace(state, kinematics=found)


def with_claim_reviewed(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Refuse a claim of a goal beyond the joint limits, or by an image model that is less exact than the noise."""
    if not context.status.is_claim:
        return state
    if beyond := _beyond_limits(state, context):
        context.status = ServoStatus.NO_PROGRESS
        return replace(state, refusal=Misfit(MisfitKind.LIMIT, limits=beyond))
    return _with_model_error(state, context)


def _beyond_limits(state: TrustRegionState, context: StepContext) -> tuple[BeyondLimit, ...]:
    """Return by how much the demonstrator's posture is beyond the limits of which joints, where noise is no reason."""
    observation, options, estimate = context.observation, context.options, state.estimate
    if estimate is not None:
        theta, std = estimate.theta, estimate.std_error
    elif at_joint_limit(context) and state.certificate is not None:
        theta, std = _minimum_without_limits(context), _std_error(state, context)
    else:
        return ()
    beyond = theta - np.clip(theta, observation.lower, observation.upper)
    excluded = np.flatnonzero(np.abs(beyond) > options.max_limit_sigmas * std)
    return tuple(BeyondLimit(int(j), float(beyond[j]), float(std[j])) for j in excluded)


def _std_error(state: TrustRegionState, context: StepContext) -> NDArray[np.float64]:
    """(m,) rad, of the predicted minimum by noise alone: what E leaves there may be due to the limit."""
    assert state.certificate is not None
    noise_px = max(context.observation.noise_px, NOISE_FLOOR_PX) * state.unit_px
    return np.maximum(state.certificate.std_per_px * noise_px, context.options.min_step)


def _minimum_without_limits(context: StepContext) -> NDArray[np.float64]:
    """(m,) rad, where E as predicted is least near the planned minimum, if joints could pass their limits."""
    plan, observation, room = context.plan, context.observation, context.options.max_step
    data = plan.data
    assert data is not None  # a certificate was made from it
    predict = data.model.restrict(data.points).predict
    low, high = observation.lower - room, observation.upper + room
    found = minimise(lambda theta: data.residuals(predict(theta)), plan.minimum.theta[None], low, high)
    return found.theta + found.newton_step


def _with_model_error(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Take the error of an image model without kinematics for the noise; refuse a claim that is not accurate then."""
    noise_px, options, certificate = context.observation.noise_px, context.options, state.certificate
    if state.kinematics is not None or noise_px == 0 or certificate is None:
        return state
    times = cross_validated_noise(state.known, noise_px, options.noise_slack) / noise_px
    std_error = times * certificate.std_error
    state = replace(state, certificate=replace(certificate, std_error=std_error))
    if times == 1 or std_error.max() < options.max_claimed_std:
        return state
    context.status = ServoStatus.SETTLED
    return replace(state, refusal=None if state.mismatch is not None else Misfit(MisfitKind.NOT_RIGID))
