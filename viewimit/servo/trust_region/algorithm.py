"""The trust-region servo.

Algorithm 1 (one call of `step` per look)
-----------------------------------------
RECORD    Add the posture and its images to the visits; fit the image model again.
PROBE     Move each joint once, to learn how the images depend on the posture.
MATCH     Measure E at all visits and solve the trust-region subproblem. If E is too large everywhere, search for
          swapped correspondences.
DESCEND   Move to the minimum of the predicted E. At the next look, compare the actual with the predicted reduction
          and update the radius.
VERIFY    Near a minimum, test whether E rises along every direction. Make verification motions where no visit shows it.
SEARCH    If E is larger than noise explains, try the next transfer; then restart far from all visits.
REST      Return to the best posture and report: converged, unobservable, settled or no progress.

At each look the phases are tried in this order, until one makes a motion. `PHASES` lists all transitions.

The image model predicts the learner's own image points at postures that it has not visited: kinematics, if they explain
all visits, or else a Gaussian process over the displacements. So E can be minimised without moving the arm.

A small E does not show that the arm has arrived: a flat valley has a small E far from its lowest point. With
E = ½ dᵀ H d, an E that is left allows a displacement up to √(2E/λ), λ the smallest eigenvalue of H. VERIFY begins where
that is below `xtol_converged`, or where noise explains E. It claims convergence by the second-order sufficient
conditions, tested on measured E: see `convergence`.

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
from .correspondences import find_swapped_matches, with_swapped
from .image_models import ImageData
from .localisation import is_consistent
from .motions import maximin, sample_box
from .options import TrustRegionOptions
from .rules import (
    Displacement,
    Look,
    accepts_step,
    at_joint_limit,
    current_certificate,
    goal_with_other_points,
    is_cycling,
    may_verify,
    mismatch_suspected,
    more_points_elsewhere,
    next_attempt,
    noise_floor,
    objective_floor,
    on_rung,
    partial_points_help,
    rest_candidate,
    restart,
    stopped,
    take_step,
    travel,
    verification_motion,
    with_plan,
)
from .state import (
    Destination,
    Matching,
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
        """Return the state after the demonstrator moved: visits and kinematics stay."""
        return TrustRegionState(
            state.visits,
            state.joints_to_probe,
            first_region(state.calibration, self.options),
            state.unit_px,
            matching=state.matching,
            target_moved=(True, state.target_moved[1]),
            calibration=state.calibration,
            kinematics=state.kinematics,
            mismatch=state.mismatch,
        )

    def step(
        self, state: TrustRegionState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[TrustRegionState, Displacement]:
        """Return the next state and the displacement to make, (m,) rad; 0 to rest."""
        tracking, options = state.is_tracking, self.options
        observation = in_units(replace(observation, calibration=()), state.unit_px)
        state, observation = record_visit(state, observation, options)
        residuals = ScaledResiduals(residuals, state.unit_px)
        residuals = residuals.with_partially_visible() if state.search.partial_points else residuals
        outdated = state.calibration and state.kinematics is None
        if outdated and not is_consistent(state.calibration, state.visits, observation.noise_px):
            state = without_calibration(state, options)
        images = ImageData(state.known, observation.noise_px, state.kinematics)
        look = Look(observation, residuals, images, tracking, options)
        phase, displacement = first_phase(state), None
        while displacement is None:
            run, _ = PHASES[phase]
            phase, state, displacement = run(state, look)
        return replace(state, phase=phase), displacement


def first_phase(state: TrustRegionState) -> Phase:
    """Return the phase that a look begins with: on the way to a destination, the one that sent the arm there."""
    if state.joints_to_probe:
        return Phase.PROBE
    return Phase.MATCH if state.destination.displacement is None else state.phase


def probe(state: TrustRegionState, look: Look) -> Outcome:
    """Move the next joint alone."""
    joint, *rest = state.joints_to_probe
    state = replace(state, joints_to_probe=tuple(rest), status=ServoStatus.MOVING)
    return Phase.PROBE, state, probe_motion(joint, look.observation)


def match(state: TrustRegionState, look: Look) -> Outcome:
    """Plan a step. If no step makes E small, search for swapped correspondences, and plan again."""
    options, observation = look.options, look.observation
    state = with_plan(state, look)
    if not mismatch_suspected(state, look):
        return Phase.DESCEND, state, None
    predict, floor = look.images.fit().predict, objective_floor(look)
    pairs = find_swapped_matches(predict, look.residuals, observation.lower, observation.upper, floor, options)
    state = replace(state, matching=Matching(pairs, next_attempt(state) + 1))
    if not pairs:
        return Phase.DESCEND, state, None
    look.residuals = with_swapped(look.residuals, pairs)
    search, region = replace(state.search, rung=0), first_region(state.calibration, options)
    return Phase.MATCH, replace(state, search=search, region=region), None


def descend(state: TrustRegionState, look: Look) -> Outcome:
    """Move to the predicted minimum, if that is worth a motion."""
    if accepts_step(state, look):
        return Phase.DESCEND, *take_step(state, look)
    if look.tracking:  # a verification would only leave the learner behind
        return Phase.DESCEND, replace(state, status=ServoStatus.MOVING), np.zeros_like(look.plan.minimum.theta)
    return Phase.VERIFY, state, None


def verify(state: TrustRegionState, look: Look) -> Outcome:
    """Test the posture to rest at, and make a motion where evidence is missing."""
    plan, options = look.plan, look.options
    state, look.place = rest_candidate(state, look)
    certificate = current_certificate(state, look)
    if certificate is None:
        return Phase.SEARCH, state, None
    if partial_points_help(certificate, state, look):
        look.residuals = look.residuals.with_partially_visible()
        search, region = replace(state.search, partial_points=True), first_region(state.calibration, options)
        return Phase.MATCH, replace(state, search=search, region=region), None
    if more_points_elsewhere(state, look):
        return Phase.SEARCH, state, None
    barred = state.mismatch is not None and plan.max_displacement_at_minimum < options.xtol_converged
    small = plan.max_displacement < options.xtol_converged or plan.E < noise_floor(look)
    if small or barred or certificate.unobservable_at_minimum:
        if may_verify(certificate, state, look):
            return Phase.VERIFY, *verification_motion(state, look, certificate.verification_step)
        look.status = certificate.status
        return Phase.REST, state, None
    if plan.max_displacement < options.xtol_verify and state.search.n_verifications < options.max_verifications:
        return Phase.VERIFY, *verification_motion(state, look, options.verification_step * plan.flattest_direction)
    return Phase.SEARCH, state, None


def search(state: TrustRegionState, look: Look) -> Outcome:
    """Look for a smaller E: by the next transfer, or from a posture far from all visits."""
    options, observation, certificate = look.options, look.observation, state.certificate
    if state.destination.displacement is not None:
        return Phase.SEARCH, *travel(state, look)
    if more_points_elsewhere(state, look):
        return Phase.SEARCH, *restart(state, look, goal_with_other_points(state, look), look.plan.n_points + 1)
    if state.search.rung + 1 < len(options.ladder):
        return Phase.MATCH, on_rung(state, look, 0 if state.exchanged else state.search.rung + 1), None
    if state.search.n_restarts < observation.max_restarts:
        goal = maximin(state.known, sample_box(observation, options.restart_candidates))
        return Phase.SEARCH, *restart(state, look, goal, 0)
    if 0 < state.search.min_points <= look.plan.n_points:  # rest where fewer points determine E
        return Phase.MATCH, on_rung(replace(state, search=replace(state.search, min_points=0)), look, 0), None
    observable = certificate is None or bool(certificate.observable.all())
    look.status = ServoStatus.NO_PROGRESS if observable else ServoStatus.UNOBSERVABLE
    return Phase.REST, state, None


def rest(state: TrustRegionState, look: Look) -> Outcome:
    """Return to the best posture, and stop there."""
    if state.destination.displacement is None:
        destination = Destination(look.place, look.status, at_joint_limit(look))
        if state.destination.status is not None and is_cycling(state, look):
            state = replace(state, destination=destination)
            return Phase.REST, stopped(state, look.status), np.zeros_like(look.place)
        region = replace(state.region, n_rejected=look.options.max_rejections)
        state = replace(state, destination=destination, region=region)
    return Phase.REST, *travel(state, look)


PHASES: dict[Phase, tuple[Callable[[TrustRegionState, Look], Outcome], set[Phase]]] = {
    # phase: (function, phases that may follow at the same look, if it makes no motion)
    Phase.PROBE: (probe, set()),
    Phase.MATCH: (match, {Phase.MATCH, Phase.DESCEND}),
    Phase.DESCEND: (descend, {Phase.VERIFY}),
    Phase.VERIFY: (verify, {Phase.MATCH, Phase.SEARCH, Phase.REST}),
    Phase.SEARCH: (search, {Phase.MATCH, Phase.REST}),
    Phase.REST: (rest, set()),
}
