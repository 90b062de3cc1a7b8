"""The trust-region servo.

Algorithm 1 (one call of `step`, before each motion)
----------------------------------------------------
The posture and its images are recorded as a visit. Then phases follow each other until one returns a motion.

PROBE     Move one joint alone, to learn how the images depend on it.
MATCH     If the demonstrator's points come without names, find them (see `naming`). If no naming explains the images,
          make a motion that improves the predictions.
PLAN      Measure E at all visits, update the radius by what the last step achieved, and solve the trust-region
          subproblem. If E is too large everywhere, search for swapped points, and plan again with them swapped back.
DESCEND   Move to the minimum of the predicted E.
VERIFY    Test whether the arm has arrived: E must leave no room for a displacement, and rise in every direction. Make
          a verification motion if neither visits show that yet, nor kinematics that have predicted one. With noise, one
          adjustment of both bodies' images then gives the posture to rest at, and refuses a claim about another body
          (`final_adjustment`). A demonstrator that was another body in earlier postures is adjusted in all of them.
          Where the points came without names, other names are looked for before a claim.
SEARCH    Look for a smaller E: try the next transfer, then restart far from all visits. None is looked for if there is
          a convincing reason why the demonstrator is no body like the own one (`misfit`).
REST      Return to the best posture and report: converged, unobservable, settled or no progress.

Transitions
-----------
start   ──> PROBE     if joints are left to probe
        ──> MATCH     if the demonstrator's points have no names yet
        ──> SEARCH    on the way to a posture where a restart begins
        ──> REST      on the way to the posture to rest at
        ──> PLAN      otherwise
PROBE   ──> motion
MATCH   ──> motion    none if names were found or corrected: the servo is asked again at once, with their residuals
PLAN    ──> MATCH     if a review corrected the names
        ──> PLAN      if swapped points were found
        ──> DESCEND   otherwise
DESCEND ──> motion    if the step is worth one; none while the demonstrator keeps moving
        ──> VERIFY    otherwise
VERIFY  ──> motion    if evidence is missing that a motion can give
        ──> PLAN      if points that one camera alone sees may determine a joint that the others do not, or the final
                      adjustment allows no claim by kinematics
        ──> REST      if the test has a result, or it is another body, as in earlier postures
        ──> SEARCH    if E is too large or another transfer's, or more points may be visible elsewhere
SEARCH  ──> motion    towards a posture where a restart begins
        ──> PLAN      if another transfer is left to try, or points that seem to be elsewhere are mixed up
        ──> REST      if nothing is left to try, or a misfit explains the images
REST    ──> motion    towards the posture to rest at; none when the arm is there

The image model predicts the learner's own image points at postures that it has not visited: kinematics, if they explain
all visits, or else a Gaussian process over the displacements. So E can be minimised without moving the arm.

A small E does not show that the arm has arrived: a flat valley has a small E far from its lowest point. With
E = ½ dᵀ H d, an E that is left allows a displacement up to √(2E/λ), λ the smallest eigenvalue of H. E leaves no room
where that is below `xtol_converged`, or where noise explains E. Then convergence is claimed by the second-order
sufficient conditions, tested on measured E: see `convergence`.

References
----------
Nocedal and Wright, Numerical Optimization, 2nd ed. 2006, Algorithm 4.1 and Theorem 2.4.
Conn, Gould and Toint, Trust-Region Methods, SIAM 2000, chapter 6.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...estimation.residuals import ResidualFunction
from ..observation import Observation, ScaledResiduals, in_units, probe_motion, unit_of
from ..status import ServoStatus
from .claims import with_claim_reviewed, with_kinematics_sought
from .image_models import ImageData
from .localisation import is_consistent
from .motions import maximin, sample_box
from .options import TrustRegionOptions
from .rules import (
    Displacement,
    StepContext,
    accepts_step,
    at_joint_limit,
    current_certificate,
    e_leaves_no_room,
    explained_early,
    goal_with_other_points,
    is_cycling,
    kinematics_suffice,
    may_verify,
    mixed_up_points,
    more_points_elsewhere,
    naming_motion,
    on_rung,
    partial_points_help,
    rest_candidate,
    restart,
    search_exhausted,
    status_at_rest,
    stopped,
    swap_suspected,
    take_step,
    travel,
    verification_motion,
    with_earlier_postures,
    with_estimate,
    with_explanation,
    with_final_adjustment,
    with_kinematics_doubted,
    with_names_reviewed,
    with_naming,
    with_partial_points,
    with_plan,
    with_swap_search,
    with_swapped,
)
from .state import (
    Destination,
    Phase,
    TrustRegionState,
    first_region,
    initial_state,
    record_visit,
    without_calibration,
)

Outcome = tuple[Phase, TrustRegionState, Displacement | None]  # if there is no displacement, that phase follows


@dataclass(frozen=True)
class TrustRegion:
    """Uncalibrated servo that learns the images as a function of the posture."""

    options: TrustRegionOptions = TrustRegionOptions()

    def start(self, observation: Observation) -> TrustRegionState:
        """Return the state before the first motion."""
        unit_px = unit_of(observation)
        return initial_state(in_units(observation, unit_px), unit_px, self.options)

    def retarget(self, state: TrustRegionState, observation: Observation) -> TrustRegionState:
        """Return the state after the demonstrator moved: visits, kinematics and how another body differs stay."""
        return TrustRegionState(
            state.visits,
            state.joints_to_probe,
            first_region(state.calibration, self.options),
            state.unit_px,
            earlier=state.known_postures(self.options),
            swaps=state.swaps,
            naming=state.naming,
            target_moved=(True, state.target_moved[1]),
            calibration=state.calibration,
            kinematics=state.kinematics,
            confirmed=state.confirmed,
            mismatch=state.mismatch,
            shortfall=state.shortfall,
            sent=state.sent,
        )

    def step(
        self, state: TrustRegionState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[TrustRegionState, Displacement]:
        """Return the next state and the displacement to make, (m,) rad; 0 to rest."""
        options = replace(self.options, seed=observation.seed)
        tracking = state.is_tracking  # read before `record_visit` shifts `target_moved`
        observation = in_units(replace(observation, calibration=()), state.unit_px)
        state, observation = record_visit(state, observation, options)
        residuals = ScaledResiduals(residuals, state.unit_px)
        residuals = residuals.with_partially_visible() if state.search.partial_points else residuals
        if state.calibration and state.kinematics is None:  # Kinematics explain all visits, those of calibration, too.
            if not is_consistent(state.calibration, state.visits, observation.noise_px):
                state = without_calibration(state, options)
        images = ImageData(state.known, observation.noise_px, state.kinematics, state.trusts_kinematics)
        context = StepContext(observation, residuals, images, tracking, options)
        phase, displacement = first_phase(state, observation), None
        while displacement is None:
            run, _ = PHASES[phase]
            phase, state, displacement = run(state, context)
        return replace(state, phase=phase), commanded(state, observation, displacement)


def commanded(state: TrustRegionState, observation: Observation, displacement: Displacement) -> Displacement:
    """Return the motion to command for a displacement, (m,) rad: an arm that stops short is sent farther."""
    if state.shortfall is None or not displacement.any():
        return displacement
    here = observation.displacement
    sent = state.shortfall.to_reach(here, here + displacement)
    return np.clip(sent, observation.lower, observation.upper) - state.sent[-1]


def first_phase(state: TrustRegionState, observation: Observation) -> Phase:
    """Return the phase that a step begins with: on the way to a destination, the one that sent the arm there."""
    if state.joints_to_probe:
        return Phase.PROBE
    if not observation.matched:
        return Phase.MATCH
    travels = state.destination.displacement is not None or state.trusts_explanation
    return state.phase if travels else Phase.PLAN


def probe(state: TrustRegionState, context: StepContext) -> Outcome:
    """Move the next joint alone."""
    joint, *rest = state.joints_to_probe
    state = replace(state, joints_to_probe=tuple(rest), status=ServoStatus.MOVING)
    return Phase.PROBE, state, probe_motion(joint, context.observation)


def match(state: TrustRegionState, context: StepContext) -> Outcome:
    """Name the demonstrator's points, or correct their names."""
    if not context.observation.matched:
        state = with_naming(state, context)
    if state.naming is not None and state.naming.accepted:
        return Phase.MATCH, replace(state, status=ServoStatus.MOVING), np.zeros_like(context.observation.displacement)
    if state.n_naming_motions < context.options.naming_motions:
        return Phase.MATCH, *naming_motion(state, context)
    return Phase.MATCH, stopped(state, ServoStatus.NO_PROGRESS), np.zeros_like(context.observation.displacement)


def plan(state: TrustRegionState, context: StepContext) -> Outcome:
    """Plan a step. Review names that are not settled, and if E stays large, search for swapped points."""
    state, corrections = with_plan(state, context), state.n_renamings
    state = with_names_reviewed(state, context)
    if state.n_renamings > corrections:
        return Phase.MATCH, state, None
    if not swap_suspected(state, context):
        return Phase.DESCEND, state, None
    state = with_swap_search(state, context)
    return Phase.PLAN if state.swaps.pairs else Phase.DESCEND, state, None


def descend(state: TrustRegionState, context: StepContext) -> Outcome:
    """Move to the predicted minimum, if that is worth a motion."""
    if accepts_step(state, context):
        return Phase.DESCEND, *take_step(state, context)
    if context.tracking:  # The arm waits, because a verification motion would leave it behind the demonstrator.
        return Phase.DESCEND, replace(state, status=ServoStatus.MOVING), np.zeros_like(context.plan.minimum.theta)
    return Phase.VERIFY, state, None


def verify(state: TrustRegionState, context: StepContext) -> Outcome:
    """Test whether the arm has arrived, and make a motion where evidence is missing."""
    state, context.place = rest_candidate(state, context)
    state = with_earlier_postures(state, context)
    if state.earlier and state.explanation is not None:
        context.status = ServoStatus.NO_PROGRESS
        return Phase.REST, state, None
    certificate = current_certificate(state, context)
    if certificate is None:
        return Phase.SEARCH, state, None
    if partial_points_help(certificate, state, context):
        return Phase.PLAN, with_partial_points(state, context), None
    if more_points_elsewhere(state, context):
        return Phase.SEARCH, state, None
    if e_leaves_no_room(state, context) or certificate.unobservable_at_minimum:
        if may_verify(certificate, state, context):
            return Phase.VERIFY, *verification_motion(state, context, certificate.verification_step)
        before, state = state, with_kinematics_sought(state, context)
        if state is not before:
            return Phase.PLAN, state, None
        state = with_estimate(state, context)
        if state.trusts_kinematics and not kinematics_suffice(state, context):
            return Phase.PLAN, with_kinematics_doubted(state, context), None
        state = with_claim_reviewed(with_final_adjustment(state, context), context)
        state, context.status = status_at_rest(context.status, state, context)
        return Phase.REST, state, None
    return Phase.SEARCH, state, None


def search(state: TrustRegionState, context: StepContext) -> Outcome:
    """Look for a smaller E: by the next transfer, or from a posture far from all visits."""
    options, observation = context.options, context.observation
    if state.destination.displacement is not None:
        return Phase.SEARCH, *travel(state, context)
    if more_points_elsewhere(state, context):
        return Phase.SEARCH, *restart(state, context, goal_with_other_points(state, context), context.plan.n_points + 1)
    if (explanation := explained_early(state, context)) is not None:
        if explanation.misfit.points and (pairs := mixed_up_points(context)):
            return Phase.PLAN, with_swapped(state, context, pairs), None
        context.status = ServoStatus.NO_PROGRESS
        return Phase.REST, replace(state, explanation=explanation), None
    if state.search.rung + 1 < len(options.ladder):
        # Swapped points did not make E small, so they are swapped back, and the ladder begins again without them.
        return Phase.PLAN, on_rung(state, context, 0 if state.swaps.pairs else state.search.rung + 1), None
    if not search_exhausted(state, context):
        goal = maximin(state.known, sample_box(observation, options.restart_candidates))
        return Phase.SEARCH, *restart(state, context, goal, 0)
    if 0 < state.search.min_points <= context.plan.n_points:
        # The visits that show more points do not make E small, so those that show fewer are compared again.
        return Phase.PLAN, on_rung(replace(state, search=replace(state.search, min_points=0)), context, 0), None
    observable = state.certificate is None or bool(state.certificate.observable.all())
    context.status = ServoStatus.NO_PROGRESS if observable else ServoStatus.UNOBSERVABLE
    return Phase.REST, state, None


def rest(state: TrustRegionState, context: StepContext) -> Outcome:
    """Return to the best posture, and stop there.

    On arrival E is measured again. If that makes another posture the best, REST follows once more, but not for ever.
    Where no posture explains the demonstrator's images, the reason is looked for first. If that gives the joint angles,
    as of another body, the arm goes there, and E is not asked again.
    """
    if state.destination.displacement is None and not state.trusts_explanation:
        state = with_explanation(state, context)
        has_rested = state.destination.status is not None
        at_limit = at_joint_limit(context)
        goal = Destination(context.place, context.status, at_limit, context.by_explanation)
        state = replace(state, destination=goal)
        if has_rested and is_cycling(state, context):
            return Phase.REST, stopped(state, context.status), np.zeros_like(context.place)
        state = replace(state, region=replace(state.region, descend_allowed=False))
    return Phase.REST, *travel(state, context)


PHASES: dict[Phase, tuple[Callable[[TrustRegionState, StepContext], Outcome], set[Phase]]] = {
    # phase: (function, phases that may follow in the same step, if it makes no motion)
    Phase.PROBE: (probe, set()),
    Phase.MATCH: (match, set()),
    Phase.PLAN: (plan, {Phase.MATCH, Phase.PLAN, Phase.DESCEND}),
    Phase.DESCEND: (descend, {Phase.VERIFY}),
    Phase.VERIFY: (verify, {Phase.PLAN, Phase.SEARCH, Phase.REST}),
    Phase.SEARCH: (search, {Phase.PLAN, Phase.REST}),
    Phase.REST: (rest, set()),
}
