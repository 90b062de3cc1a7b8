"""The rules by which the phases of the trust region decide, and the motions that they make."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...estimation.noise import conflict_quantile
from ...estimation.residuals import ResidualFunction
from ...geometry.kinematics.adjustment import PREDICTION_TOL_PX
from ..observation import Observation
from ..status import ServoStatus
from .convergence import Certificate
from .correspondences import with_swapped
from .image_models import ImageData
from .local_model import degrees_of_freedom
from .motions import distance_to_visits, farthest_offset, maximin, offset_inside_limits, sample_box, sample_line
from .options import TrustRegionOptions
from .state import Destination, Region, Search, TrustRegionState
from .subproblem import StepPlan, argmin_last, evaluate_visits, solve_subproblem

Displacement = NDArray[np.float64]


@dataclass
class Look:
    """What the phases share during one call of `step`."""

    observation: Observation  # in image units, relative to where the arm is by its images
    residuals: ResidualFunction  # in image units; the phases change which points it uses
    images: ImageData  # predicts the own images from all visits
    tracking: bool  # whether the demonstrator keeps moving
    options: TrustRegionOptions
    plan: StepPlan = field(init=False)  # made by MATCH
    place: Displacement = field(init=False)  # (m,) rad, where to rest; chosen by VERIFY
    status: ServoStatus = ServoStatus.MOVING  # to report there


def with_plan(state: TrustRegionState, look: Look) -> TrustRegionState:
    """Evaluate E at all visits, update the radius, and solve the subproblem."""
    options, transfer = look.options, current_transfer(state, look)
    visited = evaluate_visits(look.images, look.residuals, transfer, state.search.min_points, options)
    state = replace(state, region=updated_region(state, visited.E, options))
    look.plan = solve_subproblem(
        look.images, visited, state.effective_radius, look.observation, look.residuals, transfer, options
    )
    return state


def updated_region(state: TrustRegionState, E: NDArray[np.float64], options: TrustRegionOptions) -> Region:
    """Update the radius by ρ, the actual over the predicted reduction of E; E: (n,) px² at all visits."""
    region = replace(state.region, predicted_reduction=None)
    if state.region.predicted_reduction is None or len(E) < 2:
        return region
    best = argmin_last(E[:-1])
    if np.isinf(E[best]):  # too few points at all earlier visits: nothing could be predicted
        return region
    rho = float(E[best] - E[-1]) / max(state.region.predicted_reduction, 1e-12)
    step = np.abs(state.known[-1].displacement - state.known[best].displacement).max()
    step = min(step, region.radius)  # it is longer, if later images have made another visit the best
    radius, n_rejected = region.radius, 0
    if rho < options.shrink_below:
        radius = max(options.shrink_factor * step, options.min_radius)
        n_rejected = region.n_rejected + 1 if rho <= 0 and step < 2 * options.min_radius else 0
    elif rho > options.grow_above and step > options.full_step * radius:
        radius = max(radius, min(options.grow_factor * radius, options.max_radius))
    return Region(float(radius), None, n_rejected)


def accepts_step(state: TrustRegionState, look: Look) -> bool:
    """Whether the planned step is worth a motion: a short one only for the certainty that it promises."""
    plan, options = look.plan, look.options
    certainty = plan.max_displacement_at_minimum < options.xtol_converged <= plan.max_displacement
    long_enough = plan.step_length >= options.xtol or (plan.step_length >= options.min_step and certainty)
    reducible = plan.E > PREDICTION_TOL_PX**2 and state.region.n_rejected < options.max_rejections
    return bool(long_enough and reducible)


def take_step(state: TrustRegionState, look: Look) -> tuple[TrustRegionState, Displacement]:
    """Move to the predicted minimum; the last short steps go a little beyond it, where evidence is missing."""
    plan, options = look.plan, look.options
    short = plan.step_length < options.overshoot_below or state.has_global_model
    last = short and plan.max_displacement_at_minimum < options.xtol_converged
    unverified = state.search.n_verifications < len(plan.minimum.theta) and plan.noise_reference is None
    if plan.certify is not None and last and unverified and not look.tracking:
        offset = plan.certify(plan.minimum.theta).verification_step
        beyond = offset_inside_limits(look.observation, plan.minimum.theta, offset)
        if offset.any() and distance_to_visits(state.known, beyond[None])[0] > options.min_step:
            return move(with_verification(state), look, beyond)
    region = replace(state.region, predicted_reduction=float(plan.E - plan.minimum.E))
    return move(replace(state, region=region), look, plan.minimum.theta)


def next_attempt(state: TrustRegionState) -> int:
    """Return the number of the next search for swapped matches; the first one needs kinematics, or is left out."""
    return state.matching.n_attempts if state.kinematics is not None else max(state.matching.n_attempts, 1)


def objective_floor(look: Look) -> float:
    """Return E below which no swapped correspondence is suspected, px²."""
    observation, options = look.observation, look.options
    extent = float(observation.own[observation.seen.all(-1)].var(0).sum())
    return max(options.floor_image_share * extent, options.floor_noise_ratio * observation.noise_px**2)


def mismatch_suspected(state: TrustRegionState, look: Look) -> bool:
    """Whether to search for swapped matches: at some visits, while E is large."""
    attempt, plan, at = next_attempt(state), look.plan, look.options.match_at
    if state.exchanged or attempt >= len(at) or len(state.known) < at[attempt] + len(plan.minimum.theta):
        return False
    E = look.observation.E if plan.noise_reference is None else plan.E
    return bool(objective_floor(look) < E < np.inf)


def current_transfer(state: TrustRegionState, look: Look) -> str | None:
    """Return the transfer in use; None for the chosen one."""
    return look.options.ladder[state.search.rung][0]


def current_certificate(state: TrustRegionState, look: Look) -> Certificate | None:
    """Return the certificate made at this look; None if E is another transfer's, or of too few points."""
    return state.certificate if current_transfer(state, look) is None else None


def noise_floor(look: Look) -> float:
    """Return E up to which noise explains it, px²."""
    points, options = look.plan.n_points, look.options
    freedom = degrees_of_freedom(points, len(look.observation.displacement))
    return conflict_quantile(points, freedom, options.noise_slack * look.observation.noise_px, options.noise_sigmas)


def rest_candidate(state: TrustRegionState, look: Look) -> tuple[TrustRegionState, Displacement]:
    """Choose the posture to rest at, (m,) rad, and test it.

    With noise it is the predicted minimum, without noise the best visit. An arm that does not reach the postures that
    it is sent to rests at the best visit, or where it is if no motion leads there.
    """
    plan, best = look.plan, look.plan.model.centre
    place = best if plan.noise_reference is None or state.mismatch is not None else plan.minimum.theta
    if state.mismatch is not None and state.destination.status is not None and is_cycling(state, look):
        place = look.observation.displacement
    state = replace(state, region=replace(state.region, n_rejected=0))
    if plan.certify is None:
        return (replace(state, certificate=None) if current_transfer(state, look) is None else state), place
    certificate = plan.certify(place).per_pixel(state.unit_px)
    if state.mismatch is not None and not np.array_equal(place, best):
        certificate = replace(certificate, verified=False)
    return replace(state, certificate=certificate), place


def may_verify(certificate: Certificate, state: TrustRegionState, look: Look) -> bool:
    """Whether the certificate asks for a verification motion, and some are left."""
    most = look.options.max_verifications * len(look.observation.displacement)
    return bool(certificate.verification_step.any() and state.search.n_verifications < most)


def verification_motion(
    state: TrustRegionState, look: Look, offset: Displacement
) -> tuple[TrustRegionState, Displacement]:
    """Move to one side of the posture to rest at."""
    noisy = look.observation.noise_px > 0
    target = (
        farthest_offset(state.known, look.observation, look.place, offset)
        if noisy
        else offset_inside_limits(look.observation, look.place, offset)
    )
    return move(with_verification(state), look, target)


def with_verification(state: TrustRegionState) -> TrustRegionState:
    """Count a verification motion."""
    return replace(state, search=replace(state.search, n_verifications=state.search.n_verifications + 1))


def partial_points_help(certificate: Certificate, state: TrustRegionState, look: Look) -> bool:
    """Whether points that one camera alone sees may determine a joint that the others do not."""
    return bool(
        certificate.unobservable_at_minimum and not state.search.partial_points and look.observation.n_partial > 0
    )


def more_points_elsewhere(state: TrustRegionState, look: Look) -> bool:
    """Whether more points may be visible elsewhere, where these leave a joint unobservable."""
    certificate, observation = current_certificate(state, look), look.observation
    if certificate is None or not certificate.unobservable_at_minimum:
        return False
    visible = observation.n_visible + (observation.n_partial if state.search.partial_points else 0)
    learns = certificate.needs_more_data and may_verify(certificate, state, look)
    return not learns and look.plan.n_points < visible and state.search.n_restarts < observation.max_restarts


def goal_with_other_points(state: TrustRegionState, look: Look) -> Displacement:
    """Return a posture far away on the line that these points leave open; if it is all visited, one anywhere."""
    observation, count = look.observation, look.options.restart_candidates
    goal = maximin(state.known, sample_line(observation, look.place, look.plan.flattest_direction, count))
    if distance_to_visits(state.known, goal[None])[0] < look.options.first_radius:
        goal = maximin(state.known, sample_box(observation, count))
    return goal


def on_rung(state: TrustRegionState, look: Look, rung: int) -> TrustRegionState:
    """Begin a rung of the ladder; swapped matches that did not make E small are dropped."""
    look.residuals = with_swapped(look.residuals, state.exchanged)
    return replace(
        state,
        search=replace(state.search, rung=rung),
        region=Region(look.options.ladder[rung][1]),
        matching=replace(state.matching, pairs=()),
        target_moved=(state.target_moved[0], False),
    )


def restart(
    state: TrustRegionState, look: Look, goal: Displacement, min_points: int
) -> tuple[TrustRegionState, Displacement]:
    """Begin the search again at a goal, (m,) rad; min_points: that must determine E there."""
    search = Search(n_restarts=state.search.n_restarts + 1, min_points=min_points)
    region = Region(look.options.first_radius)
    return travel(replace(state, search=search, region=region, destination=Destination(goal)), look)


def move(state: TrustRegionState, look: Look, target: Displacement) -> tuple[TrustRegionState, Displacement]:
    """Move to the target, or towards it by `max_step`, where images are predicted near visits only."""
    step = target - look.observation.displacement
    longest = np.abs(step).max()
    if longest > look.options.max_step and not state.has_global_model:
        step = step * (look.options.max_step / longest)
        state = replace(state, region=replace(state.region, predicted_reduction=None))
    return replace(state, status=ServoStatus.MOVING), step


def travel(state: TrustRegionState, look: Look) -> tuple[TrustRegionState, Displacement]:
    """Move on to the destination. If the arm is there already, and was to rest there, stop."""
    destination, observation, options = state.destination, look.observation, look.options
    goal = observation.displacement if destination.displacement is None else destination.displacement
    if state.mismatch is not None:  # the limits, relative to where the arm is, have changed on the way
        goal = np.clip(goal, observation.lower, observation.upper)
    arrives = state.has_global_model or np.abs(goal - observation.displacement).max() <= options.max_step
    state, step = move(state, look, goal)
    state = replace(state, destination=replace(destination, displacement=None if arrives else goal))
    error = 0.0 if state.certificate is None else float(state.certificate.std_error.max())
    tolerance = np.clip(options.arrival_tolerance * error, options.xtol / 10, options.xtol)
    if destination.status is not None and np.abs(step).max() < tolerance:
        return stopped(state, destination.status), np.zeros_like(step)
    return state, step


def stopped(state: TrustRegionState, status: ServoStatus) -> TrustRegionState:
    """Rest with a status."""
    return replace(state, status=status, destination=replace(state.destination, displacement=None, status=None))


def is_cycling(state: TrustRegionState, look: Look) -> bool:
    """Whether the arm is at one posture for the third time."""
    here = look.observation.displacement[None]
    return bool(distance_to_visits(state.visits, here, 3)[0] < look.options.same_posture)


def at_joint_limit(look: Look) -> bool:
    """Whether the predicted minimum is at a joint limit."""
    theta, observation = look.plan.minimum.theta, look.observation
    room = np.minimum(theta - observation.lower, observation.upper - theta)
    return bool((room < look.options.same_posture).any())
