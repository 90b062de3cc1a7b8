"""The conditions on which the phases of the trust region decide, and the motions that they make.

Functions take the state and the context of the step. Those that return a state return a new one; only the context is
changed in place.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ...estimation.noise import conflict_quantile
from ...estimation.residuals import ResidualFunction
from ...estimation.views import Pairs
from ...geometry.kinematics.adjustment import NOISE_FLOOR_PX, PREDICTION_TOL_PX, fit_kinematics
from ..observation import Observation
from ..status import ServoStatus
from .convergence import Certificate, certificate_of
from .correspondences import find_swaps, swapped, with_swaps
from .final_adjustment import estimate_posture
from .image_models import ImageData, KinematicImages, observations_of
from .local_model import degrees_of_freedom
from .misfit import Explanation, MisfitKind, explain, explain_again
from .motions import distance_to_visits, farthest_offset, maximin, offset_inside_limits, sample_box, sample_line
from .naming import find_naming, find_rival, grid_size, mixed_up, review_naming
from .options import TrustRegionOptions
from .state import Destination, Region, Search, Swaps, TrustRegionState, first_region
from .subproblem import StepPlan, argmin_last, evaluate_visits, solve_subproblem

Displacement = NDArray[np.float64]


@dataclass
class StepContext:
    """What the phases of one call of `step` share, and pass on to each other."""

    observation: Observation  # in image units; displacement and limits are relative to where the arm really is
    residuals: ResidualFunction  # in image units; phases swap points in it, and include partially visible ones
    images: ImageData  # predicts the own images from all visits
    tracking: bool  # whether the demonstrator keeps moving
    options: TrustRegionOptions
    plan: StepPlan = field(init=False)  # PLAN makes it for all later phases
    place: Displacement = field(init=False)  # (m,) rad, the posture to rest at, which VERIFY chooses
    status: ServoStatus = ServoStatus.MOVING  # to report at rest, which VERIFY and SEARCH choose
    certified: bool = False  # whether E allows a claim that the final adjustment refuses
    by_explanation: bool = False  # whether `place` is the posture of an explanation


def naming_model(context: StepContext) -> KinematicImages | None:
    """Return kinematics that predict the own images everywhere: those of the servo, or less exact ones; None without.

    Where exact kinematics are not found, those that fit with some noise may suffice: their prior leads to a minimum.
    """
    model, observation, rough = context.images.fit(), context.observation, context.options.naming_rough_noise_px
    if isinstance(model, KinematicImages) or observation.noise_px >= rough:
        return model if isinstance(model, KinematicImages) else None
    visits = observations_of(context.images.visits)
    kinematics = fit_kinematics(visits, rough, observation.rectification)
    return None if kinematics is None else KinematicImages(kinematics, observation.displacement, visits, rough, None)


def with_naming(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Search for the names of the demonstrator's points, if kinematics predict the own images everywhere."""
    model, observation = naming_model(context), context.observation
    if model is None or observation.demo is None:
        return replace(state, naming=None)
    step = context.options.naming_grid_step * context.options.naming_refinement**state.n_naming_motions
    options = replace(context.options, naming_grid_step=step)
    found = find_naming(observation.demo, model, observation.lower, observation.upper, options)
    found = None if found is None else found.per_pixel(state.unit_px)
    grid = grid_size(observation.lower, observation.upper, options)
    return replace(state, naming=found, unnamed=observation.demo, naming_grid=grid)


def with_names_reviewed(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Review names that are not settled: later visits predict the images better."""
    naming, observation = state.naming, context.observation
    if naming is None or naming.is_settled or state.unnamed is None or (model := naming_model(context)) is None:
        return state
    found = review_naming(naming, state.unnamed, model, observation.lower, observation.upper, context.options)
    if found is naming:
        return state
    found = found.per_pixel(state.unit_px)
    if np.array_equal(found.used, naming.used):
        return replace(state, naming=found)
    if state.swaps.pairs or state.n_renamings >= context.options.naming_corrections:
        return state
    return replace(state, naming=found, n_renamings=state.n_renamings + 1)


def with_rival_sought(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Look for other names that explain the images, before a claim: more visits than at first predict them now."""
    naming, observation = state.naming, context.observation
    if naming is None or naming.is_ambiguous or state.unnamed is None or (model := naming_model(context)) is None:
        return state
    found = find_rival(naming, state.unnamed, model, observation.lower, observation.upper, context.options)
    return replace(state, naming=found)


def naming_motion(state: TrustRegionState, context: StepContext) -> tuple[TrustRegionState, Displacement]:
    """Move to improve the predictions: to the posture of the last naming, or far from all visits.

    Kinematics are found from visits near each other, and then extended: the arm goes farther from motion to motion.
    """
    observation, options = context.observation, context.options
    first, reach = state.known[0].displacement, options.first_radius
    if state.kinematics is not None:
        reach = reach * (1 + state.n_naming_motions)
    within = lambda theta: np.clip(theta, first - reach, first + reach)
    target = None if state.naming is None else within(state.naming.displacement)
    if target is None or distance_to_visits(state.known, target[None])[0] < options.naming_grid_step:
        target = maximin(state.known, within(sample_box(observation, options.restart_candidates)))
    return move(replace(state, n_naming_motions=state.n_naming_motions + 1), context, target)


def status_at_rest(
    status: ServoStatus, state: TrustRegionState, context: StepContext
) -> tuple[TrustRegionState, ServoStatus]:
    """Return the status to report; where other names explain the images as well, nothing is claimed."""
    if status.is_claim and state.destination.status is None:
        state = with_rival_sought(state, context)
    ambiguous = state.naming is not None and state.naming.is_ambiguous
    return state, ServoStatus.SETTLED if ambiguous and status.is_claim else status


def with_plan(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Evaluate E at all visits, update the radius, and solve the subproblem."""
    options, transfer = context.options, current_transfer(state, context)
    visited = evaluate_visits(context.images, context.residuals, transfer, state.search.min_points, options)
    state = replace(state, region=updated_region(state, visited.E, options), refusal=None)
    context.plan = solve_subproblem(
        context.images, visited, state.effective_radius, context.observation, context.residuals, transfer, options
    )
    return state


def updated_region(state: TrustRegionState, E: NDArray[np.float64], options: TrustRegionOptions) -> Region:
    """Update the radius by ρ, the actual over the predicted reduction of E; E: (n,) px² at all visits."""
    region = replace(state.region, predicted_reduction=None)
    if state.region.predicted_reduction is None or len(E) < 2:
        return region
    best = argmin_last(E[:-1])
    if np.isinf(E[best]):  # No earlier visit showed enough points, so no reduction was predicted.
        return region
    rho = float(E[best] - E[-1]) / max(state.region.predicted_reduction, 1e-12)
    step = np.abs(state.known[-1].displacement - state.known[best].displacement).max()
    step = min(step, region.radius)  # It is longer if later images have made another visit the best.
    radius, n_rejected = region.radius, 0
    if rho < options.shrink_below:
        radius = max(options.shrink_factor * step, options.min_radius)
        n_rejected = region.n_rejected + 1 if rho <= 0 and step < 2 * options.min_radius else 0
    elif rho > options.grow_above and step > options.full_step * radius:
        radius = max(radius, min(options.grow_factor * radius, options.max_radius))
    return Region(float(radius), None, n_rejected)


def accepts_step(state: TrustRegionState, context: StepContext) -> bool:
    """Whether the planned step is worth a motion.

    The arm must not stand at its end already. It must be `xtol` long. A shorter one of at least `min_step` is worth a
    motion only if it decides: if E leaves room at the best visit, and no room at the predicted minimum. Where noise
    explains E, trusted kinematics need no step: the final adjustment finds the posture.
    """
    plan, region, options = context.plan, state.region, context.options
    decides = plan.max_displacement_at_minimum < options.xtol_converged <= plan.max_displacement
    long_enough = plan.step_length >= options.xtol or (plan.step_length >= options.min_step and decides)
    is_there = np.linalg.norm(plan.minimum.theta - context.observation.displacement) < options.min_step
    model_reduces_E = region.descend_allowed and region.n_rejected < options.max_rejections
    if (
        state.trusts_kinematics
        and plan.noise_reference is not None
        and plan.E < noise_floor(context)
        and not context.tracking
    ):
        return False
    return bool(long_enough and not is_there and model_reduces_E and plan.E > PREDICTION_TOL_PX**2)


def take_step(state: TrustRegionState, context: StepContext) -> tuple[TrustRegionState, Displacement]:
    """Move to the predicted minimum."""
    plan = context.plan
    region = replace(state.region, predicted_reduction=float(plan.E - plan.minimum.E))
    return move(replace(state, region=region), context, plan.minimum.theta)


def next_swap_search(state: TrustRegionState) -> int:
    """Return the index of the next search for swaps in `swap_search_at`; the first is made with kinematics only."""
    return state.swaps.n_searches if state.kinematics is not None else max(state.swaps.n_searches, 1)


def objective_floor(context: StepContext) -> float:
    """Return E below which no swapped points are suspected, px²."""
    observation, options = context.observation, context.options
    extent = float(observation.own[observation.seen.all(-1)].var(0).sum())
    return max(options.floor_image_share * extent, options.floor_noise_ratio * observation.noise_px**2)


def swap_suspected(state: TrustRegionState, context: StepContext) -> bool:
    """Whether to search for swapped points: while E is large, at a few numbers of visits, as the search is costly."""
    index, plan, at = next_swap_search(state), context.plan, context.options.swap_search_at
    if state.swaps.pairs or index >= len(at) or len(state.known) < at[index] + len(plan.minimum.theta):
        return False
    E = context.observation.E if plan.noise_reference is None else plan.E
    return bool(np.isfinite(E) and E > objective_floor(context))


def with_swap_search(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Search for swapped points. If some are found, begin the search for the minimum again with them swapped back."""
    observation, options = context.observation, context.options
    pairs = find_swaps(
        context.images.fit().predict,
        context.residuals,
        observation.lower,
        observation.upper,
        objective_floor(context),
        options,
        name_all=lambda: mixed_up_points(context),
    )
    if not pairs:
        return replace(state, swaps=Swaps((), next_swap_search(state) + 1))
    return with_swapped(state, context, pairs)


def with_swapped(state: TrustRegionState, context: StepContext, pairs: Pairs) -> TrustRegionState:
    """Begin the search for the minimum again with points swapped."""
    swap_points(context, pairs)
    return replace(
        state,
        swaps=Swaps(pairs, next_swap_search(state) + 1),
        search=replace(state.search, rung=0),
        region=first_region(state.calibration, context.options),
    )


def mixed_up_points(context: StepContext) -> Pairs:
    """Return swaps, one after the other, that put mixed-up points right; none if no naming explains the images."""
    model, observation = context.images.fit(), context.observation
    if not isinstance(model, KinematicImages) or observation.demo is None:
        return ()
    return mixed_up(observation.demo, model, observation.lower, observation.upper, context.options)


def swap_points(context: StepContext, pairs: Pairs) -> None:
    """Swap points of the demonstrator in all that the phases of this step see of it."""
    context.residuals = with_swaps(context.residuals, pairs)
    if context.observation.demo is not None:
        context.observation = replace(context.observation, demo=swapped(context.observation.demo, pairs))


def current_transfer(state: TrustRegionState, context: StepContext) -> str | None:
    """Return the transfer in use; None for the chosen one."""
    return context.options.ladder[state.search.rung][0]


def current_certificate(state: TrustRegionState, context: StepContext) -> Certificate | None:
    """Return the certificate of this step; None if E is another transfer's, or too few points determine it."""
    return state.certificate if current_transfer(state, context) is None else None


def e_leaves_no_room(state: TrustRegionState, context: StepContext) -> bool:
    """Whether E leaves no displacement worth a motion possible, or noise explains E.

    An arm that is not where it was sent may never reach the predicted minimum. For it, the E predicted there counts.
    """
    plan, bound = context.plan, context.options.xtol_converged
    cannot_get_nearer = state.mismatch is not None and plan.max_displacement_at_minimum < bound
    return plan.max_displacement < bound or plan.E < noise_floor(context) or cannot_get_nearer


def noise_floor(context: StepContext) -> float:
    """Return E up to which noise explains it, px²."""
    points, options = context.plan.n_points, context.options
    freedom = degrees_of_freedom(points, len(context.observation.displacement))
    return conflict_quantile(points, freedom, options.noise_slack * context.observation.noise_px, options.noise_sigmas)


def rest_candidate(state: TrustRegionState, context: StepContext) -> tuple[TrustRegionState, Displacement]:
    """Choose the posture to rest at, (m,) rad, and test it for convergence.

    With noise it is the predicted minimum, which averages the noise of all visits. Without noise it is the best visit,
    where E was measured. An arm that is not where it was sent may never reach the minimum, so it returns to the best
    visit in both cases. If it does not reach that either, it rests where it is.
    """
    plan, best = context.plan, context.plan.model.centre
    place = best if plan.noise_reference is None or state.mismatch is not None else plan.minimum.theta
    if state.mismatch is not None and state.destination.status is not None and is_cycling(state, context):
        place = context.observation.displacement
    state = replace(state, region=replace(state.region, n_rejected=0, descend_allowed=True))
    if not plan.can_certify:
        if current_transfer(state, context) is None:  # Another transfer says nothing about the last certificate.
            state = replace(state, certificate=None)
        return state, place
    certificate = plan.certify(place).per_pixel(state.unit_px)
    if state.mismatch is not None and not np.array_equal(place, best):
        certificate = replace(certificate, verified=False)  # E was measured to rise about the best visit, not here.
    return replace(state, certificate=certificate), place


def with_estimate(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Adjust own and demonstrator's images together.

    Without noise the best visit is exact already, and errors of rounded images are no independent noise. An arm at the
    adjusted posture is not adjusted again.
    """
    observation, certificate = context.observation, state.certificate
    assert certificate is not None
    if observation.noise_px == 0 or state.kinematics is None or not certificate.observable.all():
        return replace(state, estimate=None)
    if context.images.is_rounded():
        return replace(state, estimate=None)
    if state.estimate is not None and state.destination.status is not None:
        return state
    estimate = estimate_posture(state.kinematics, state.known, observation, context.place, context.options)
    return replace(state, estimate=estimate)


def kinematics_suffice(state: TrustRegionState, context: StepContext) -> bool:
    """Whether a claim may rest on kinematics: without noise, or if the estimate fits and is accurate."""
    estimate, options = state.estimate, context.options
    if estimate is None:
        return context.observation.noise_px == 0
    fits = estimate.sigmas < options.max_body_sigmas
    return bool(fits and estimate.std_error.max() < options.max_claimed_std)


def with_kinematics_doubted(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Take kinematics for no evidence any more: E is to be measured to rise in every direction."""
    context.images = replace(context.images, trusted=False)
    return replace(state, doubted=True)


def with_final_adjustment(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Choose posture and status to rest with by the final adjustment."""
    certificate, estimate, options = state.certificate, state.estimate, context.options
    assert certificate is not None
    context.status = certificate.status
    if estimate is None:
        return state
    if estimate.sigmas >= options.max_body_sigmas:
        context.status, context.certified = ServoStatus.NO_PROGRESS, certificate.status.is_claim
        return state
    place = np.clip(estimate.theta, context.observation.lower, context.observation.upper)
    if (np.abs(place - context.place) > options.same_minimum * certificate.std_error).any():
        certificate = context.plan.certify(place).per_pixel(state.unit_px)
    context.place, context.status = place, certificate.status
    return replace(state, certificate=certificate.with_std_error(estimate.std_error))


def find_explanation(state: TrustRegionState, context: StepContext) -> Explanation | None:
    """Return the reason why no posture explains the demonstrator's images; None if there is none to find."""
    if state.explanation is not None or state.kinematics is None:
        return state.explanation
    found = explain(state.kinematics, state.known, context.observation, context.place, context.options)
    return None if found is None else replace(found, misfit=found.misfit.per_pixel(state.unit_px))


def with_earlier_postures(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Adjust a demonstrator that was another body with its earlier postures; forget these if they do not fit.

    The same images once more are no new ones. If the angles remain uncertain, as where points are hidden, E decides.
    """
    kinematics, observation, options = state.kinematics, context.observation, context.options
    if not state.earlier or state.explanation is not None or kinematics is None or observation.demo is None:
        return state
    demo = observation.demo
    earlier = tuple(one for one in state.earlier if not np.array_equal(one.demo, demo, equal_nan=True))
    state = replace(state, earlier=earlier)
    if not earlier:
        return state
    demos = np.array([demo, *(one.demo for one in earlier)])
    postures = np.array([context.place, *(one.theta for one in earlier)])
    found = explain_again(kinematics, state.known, demos, postures, observation.noise_px, options)
    if found is None:
        return replace(state, earlier=())
    return replace(state, explanation=found) if found.estimate.std_error.max() < options.max_imitated_std else state


def explained_early(state: TrustRegionState, context: StepContext) -> Explanation | None:
    """Return a reason that spares the search for a smaller E elsewhere; None without.

    Looking is costly: it is done with the first transfer alone, and before every second restart. Points that were
    swapped in vain are swapped back first: else the demonstrator is none that was seen.
    """
    search, options = state.search, context.options
    if search.rung or search.min_points or search.n_restarts % 2 or state.swaps.pairs:
        return None
    found = find_explanation(state, context)
    convinces = found is not None and found.is_convincing(options.max_body_sigmas, options.early_criterion)
    return found if convinces else None


def with_explanation(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Find out why no posture explains the demonstrator's images; imitate the joint angles of another body.

    A claim about another body, or by images that a lens bends, rests on the adjustment alone: noise explains what it
    leaves, no other reason is nearly as good, and the expected error is small. Other cameras leave E as it is, so with
    them E must allow the claim, too. Angles whose expected error is too large for a claim may still be imitated.
    """
    observation, options = context.observation, context.options
    found = find_explanation(state, context) if context.status is ServoStatus.NO_PROGRESS else None
    if found is None:
        return state
    state, kind, estimate = replace(state, explanation=found), found.misfit.kind, found.estimate
    place = np.clip(estimate.theta, observation.lower, observation.upper)
    inside = (np.abs(place - estimate.theta) < estimate.std_error).all()
    by_adjustment = kind in (MisfitKind.ANOTHER_BODY, MisfitKind.LENS)
    claimable = by_adjustment or (kind is MisfitKind.TWO_HEADS and context.certified)
    if not (claimable and inside and found.is_convincing(options.max_body_sigmas, options.clear_criterion)):
        return state
    error = estimate.std_error.max()
    if error >= options.max_imitated_std:
        return state
    context.place, context.by_explanation = place, True
    certificate = certificate_of(estimate.std_error, max(observation.noise_px, NOISE_FLOOR_PX) * state.unit_px)
    if error < options.max_claimed_std:
        state, context.status = status_at_rest(certificate.status, state, context)
        return replace(state, certificate=certificate)
    return replace(state, certificate=replace(certificate, verified=False))


def may_verify(certificate: Certificate, state: TrustRegionState, context: StepContext) -> bool:
    """Whether the certificate asks for a verification motion, and some are left."""
    most = context.options.max_verifications * len(context.observation.displacement)
    return bool(certificate.verification_step.any() and state.search.n_verifications < most)


def verification_motion(
    state: TrustRegionState, context: StepContext, offset: Displacement
) -> tuple[TrustRegionState, Displacement]:
    """Move to one side of the posture to rest at, by (m,) rad; with noise away from all visits, to average it."""
    observation, place = context.observation, context.place
    if observation.noise_px > 0:
        target = farthest_offset(state.known, observation, place, offset)
    else:
        target = offset_inside_limits(observation, place, offset)
    return move(with_verification(state), context, target)


def with_verification(state: TrustRegionState) -> TrustRegionState:
    """Count a verification motion."""
    return replace(state, search=replace(state.search, n_verifications=state.search.n_verifications + 1))


def partial_points_help(certificate: Certificate, state: TrustRegionState, context: StepContext) -> bool:
    """Whether points that one camera alone sees may determine a joint that the others do not."""
    unused = context.observation.n_partial > 0 and not state.search.partial_points
    return certificate.unobservable_at_minimum and unused


def with_partial_points(state: TrustRegionState, context: StepContext) -> TrustRegionState:
    """Use points that one camera alone sees, too, and begin the search for the minimum again with them."""
    context.residuals = context.residuals.with_partially_visible()
    search, region = replace(state.search, partial_points=True), first_region(state.calibration, context.options)
    return replace(state, search=search, region=region)


def more_points_elsewhere(state: TrustRegionState, context: StepContext) -> bool:
    """Whether more points may be visible elsewhere, where these leave a joint unobservable."""
    certificate, observation = current_certificate(state, context), context.observation
    if certificate is None or not certificate.unobservable_at_minimum:
        return False
    visible = observation.n_visible + (observation.n_partial if state.search.partial_points else 0)
    learns_here = certificate.needs_more_data and may_verify(certificate, state, context)
    return not learns_here and context.plan.n_points < visible and not search_exhausted(state, context)


def search_exhausted(state: TrustRegionState, context: StepContext) -> bool:
    """Whether no restart is left."""
    return state.search.n_restarts >= context.observation.max_restarts


def goal_with_other_points(state: TrustRegionState, context: StepContext) -> Displacement:
    """Return a posture to restart from, (m,) rad, where other points may be visible.

    It is far from all visits on the line along which E hardly rises: there E stays small. If visits cover that line, it
    is anywhere.
    """
    observation, count = context.observation, context.options.restart_candidates
    goal = maximin(state.known, sample_line(observation, context.place, context.plan.flattest_direction, count))
    if distance_to_visits(state.known, goal[None])[0] < context.options.first_radius:
        goal = maximin(state.known, sample_box(observation, count))
    return goal


def on_rung(state: TrustRegionState, context: StepContext, rung: int) -> TrustRegionState:
    """Begin a rung of the ladder, with no points swapped.

    The demonstrator counts as moving again only after it has moved before two more motions.
    """
    swap_points(context, state.swaps.pairs[::-1])
    return replace(
        state,
        search=replace(state.search, rung=rung),
        region=Region(context.options.ladder[rung][1]),
        swaps=replace(state.swaps, pairs=()),
        target_moved=(state.target_moved[0], False),
    )


def restart(
    state: TrustRegionState, context: StepContext, goal: Displacement, min_points: int
) -> tuple[TrustRegionState, Displacement]:
    """Begin the search again at a goal, (m,) rad, with visits where at least `min_points` points determine E."""
    search = Search(n_restarts=state.search.n_restarts + 1, min_points=min_points)
    region = Region(context.options.first_radius)
    return travel(replace(state, search=search, region=region, destination=Destination(goal)), context)


def move(state: TrustRegionState, context: StepContext, target: Displacement) -> tuple[TrustRegionState, Displacement]:
    """Move to the target, (m,) rad, or towards it by `max_step` if images are predicted near visits only.

    A step cut short has another reduction of E than predicted, so the radius is not updated by it.
    """
    step = target - context.observation.displacement
    longest = np.abs(step).max()
    if longest > context.options.max_step and not state.has_global_model:
        step = step * (context.options.max_step / longest)
        state = replace(state, region=replace(state.region, predicted_reduction=None))
    return replace(state, status=ServoStatus.MOVING), step


def travel(state: TrustRegionState, context: StepContext) -> tuple[TrustRegionState, Displacement]:
    """Move on to the destination. If the arm is there already and is to rest there, stop.

    It counts as there within a small share of the expected error: a return by less would not improve the result.
    """
    destination, observation, options = state.destination, context.observation, context.options
    goal = observation.displacement if destination.displacement is None else destination.displacement
    if state.mismatch is not None:  # The limits are relative to where the arm is, and have changed on the way.
        goal = np.clip(goal, observation.lower, observation.upper)
    arrives = state.has_global_model or np.abs(goal - observation.displacement).max() <= options.max_step
    state, step = move(state, context, goal)
    state = replace(state, destination=replace(destination, displacement=None if arrives else goal))
    error = 0.0 if state.certificate is None else float(state.certificate.std_error.max())
    tolerance = np.clip(options.arrival_tolerance * error, options.xtol / 10, options.xtol)
    if destination.status is not None and np.abs(step).max() < tolerance:
        return stopped(state, destination.status), np.zeros_like(step)
    return state, step


def stopped(state: TrustRegionState, status: ServoStatus) -> TrustRegionState:
    """Return the state at rest, with a status to report."""
    return replace(state, status=status, destination=replace(state.destination, displacement=None, status=None))


def is_cycling(state: TrustRegionState, context: StepContext) -> bool:
    """Whether the arm is at one posture for the third time: two postures may be the best by turns, by noise."""
    here = context.observation.displacement[None]
    return bool(distance_to_visits(state.visits, here, 3)[0] < context.options.same_posture)


def at_joint_limit(context: StepContext) -> bool:
    """Whether the predicted minimum is at a joint limit."""
    theta, observation = context.plan.minimum.theta, context.observation
    room = np.minimum(theta - observation.lower, observation.upper - theta)
    return bool((room < context.options.same_posture).any())
