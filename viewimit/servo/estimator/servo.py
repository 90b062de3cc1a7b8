"""The estimator as a servo: all images so far are one estimation problem, and there is one rule.

    probe each joint once; then at each step
    body = learn(all own images)                                         `geometry.kinematics.own_body`
    best = likeliest hypothesis about the demonstrator's images          `hypotheses`
    go to the estimate, look from elsewhere first, or stay: the choice with the least loss        `rule`
    claim where it stays, if noise explains what the best hypothesis leaves and the expected error is small

Without a body, as with few points or short motions, the arm moves farther and farther about its start. Where the images
leave a joint open, it goes to the least E before it rests. A demonstrator that keeps moving is followed by its angles
alone: the place where it stands is known.
"""

from dataclasses import dataclass, replace

import numpy as np

from ...estimation.residuals import ResidualFunction
from ...estimation.transfers.transfer import conflict
from ...geometry.kinematics.clusters import Observations
from ...geometry.kinematics.own_body import OwnBody, idle_joints, learn
from ..certificate import Certificate
from ..misfit import BeyondLimit, Misfit, MisfitKind
from ..observation import Observation, ScaledResiduals, in_units, probe_motion, unit_of
from ..status import ServoStatus
from . import hypotheses
from .following import follow
from .hypotheses import MAX_IMITATED_STD, Estimate, Evidence
from .naming import KnownBody, find_naming
from .options import EstimatorOptions
from .rule import Choice, choose, first_largest
from .state import Displacement, EstimatorState, Purpose
from .swaps import swapped, with_swaps

FIRST_REACH, REACHES, PLACES = np.radians(15.0), (1.0, -1.0, 0.3, -0.3), 64  # of motions about the start
LEAST_MOTION = 1e-2  # image units: a joint that moves no point farther moves none in sight
NAMING_MOTIONS = 4  # further motions, at most, before the points count as impossible to name
SAME_PLACE = np.radians(0.01)  # a shorter motion is none
Outcome = tuple[EstimatorState, Displacement]


@dataclass(frozen=True)
class Estimator:
    """Uncalibrated servo by maximum likelihood."""

    options: EstimatorOptions = EstimatorOptions()

    def start(self, observation: Observation) -> EstimatorState:
        """Return the state before the first motion."""
        see = in_units(observation, unit_px := unit_of(observation))
        probes = () if see.calibration else tuple(range(len(see.displacement)))
        return EstimatorState(see.calibration, probes, unit_px, len(see.calibration))

    def retarget(self, state: EstimatorState, observation: Observation) -> EstimatorState:
        """Return the state after the demonstrator moved: the body stays."""
        best = None if state.best is not None and state.best.explanation is not None else state.best
        return replace(
            state, best=best, n_explored=0, n_moved=0, n_naming_motions=0, went_nearest=False, certificate=None,
            misfit=None, moved=True, probe=False, status=ServoStatus.MOVING,
        )  # fmt: skip

    def step(self, state: EstimatorState, observation: Observation, residuals: ResidualFunction) -> Outcome:
        """Return the next state and the motion to make, (m,) rad; 0 to rest."""
        see = in_units(replace(observation, calibration=()), state.unit_px)
        residuals = ScaledResiduals(residuals, state.unit_px)
        given, state = state, replace(state, streak=state.streak + 1 if state.moved else 0, moved=False)
        state = state if state.streak else replace(state, trail=())
        follows = state.streak > 1 and state.best is not None and state.best.fit is not None
        if follows and state.body is not None and len(state.visits) >= self.options.enough_visits:
            return follow(state, state.body, see)
        state, is_new = state.recorded(see, self.options)
        if not is_new and given.status.is_at_rest:
            return given, np.zeros_like(see.displacement)
        raised = repetition(state.seen) if see.noise_px > 0 else 1.0
        see = replace(see, noise_px=see.noise_px * raised, demo_noise_px=see.demonstrator[1])
        if state.joints_to_probe:
            joint, *left = state.joints_to_probe
            state = replace(state, joints_to_probe=tuple(left), probe=True, purpose=Purpose.PROBE)
            return state, probe_motion(joint, see)
        if is_new or state.body is None:
            state = replace(state, body=learn(state.seen, see.noise_px, see.rectification, state.body))
        if state.body is None:
            return self._without_body(state, see, residuals)
        if not see.matched:
            return self._named(state, state.body, see)
        if follows:
            return follow(state, state.body, see)
        evidence = Evidence(state.body, see, residuals, self.options)
        state = self._likeliest(state, evidence)
        if state.best is None:
            if state.n_explored < self.options.growing * len(see.lower):
                return self._grow(state, see)
            return self._at_least_E(state, evidence)
        return self._decide(state, state.best, evidence)

    def _likeliest(self, state: EstimatorState, evidence: Evidence) -> EstimatorState:
        """Find the likeliest hypothesis: the same body; if that does not fit, with points swapped; else another one."""
        before, see, options = state.best, evidence.see, self.options
        why = None if before is None else before.explanation
        if before is not None and why is not None and not before.fits(options) and before.is_clear(options):
            return state  # nothing to imitate
        best = hypotheses.refitted(before, evidence) if before and why and before.fits(options) else None
        if best is None:
            best = hypotheses.same_body(evidence, before if why is None else None)
        if best is None or best.fits(options):
            return state.with_estimate(best)
        best = hypotheses.refined(best, evidence)
        if best.fits(options):
            return state.with_estimate(best)
        n, m = len(state.visits), len(see.lower)
        searches = not state.exchanged and n - m in options.search_swaps_at
        if searches and (pairs := hypotheses.find_pairs(evidence)):
            demo = swapped(see.demonstrator[0], pairs)
            put_right = replace(see, demo=demo, demo_average=None)
            right = replace(evidence, see=put_right, residuals=with_swaps(evidence.residuals, pairs))
            again = hypotheses.same_body(right)
            if again is not None and again.fits(options):
                return replace(state, exchanged=pairs).with_estimate(again)
        if best.open_joints(options, evidence.noise_px).any():  # no other hypothesis, with more unknowns, tells more
            return state.with_estimate(replace(best, theta=hypotheses.least_E(best)))
        if n >= 2 * m and (before is None or why is None or before.fits(options) or (n - 2 * m) % 2 == 0):
            return state.with_estimate(hypotheses.likeliest_other(best, evidence))
        return state.with_estimate(replace(best, explanation=why, theta=hypotheses.least_E(best)))

    def _decide(self, state: EstimatorState, best: Estimate, evidence: Evidence) -> Outcome:
        """Go where the rule says, or rest, and claim if the best hypothesis allows it."""
        see, body, options = evidence.see, evidence.body, self.options
        here, m = body.here, len(see.lower)
        best, choice = self._chosen(state, best, evidence)
        noise, fits = evidence.noise_px, best.fits(options)
        open_joints = best.open_joints(options, noise)
        std = np.where(open_joints, np.inf, best.std)
        lost = fits and self._is_lost(best, evidence)
        goes = not lost or (choice.explores and not state.went_nearest)
        place = choice.place if goes and state.n_moved < options.most * m else None
        error = std if place is not None else np.hypot(std, np.abs(best.theta - here))
        state = replace(state, best=best, certificate=Certificate(error, best.std_per_unit(noise) / state.unit_px))
        if place is not None:
            n_explored = state.n_explored + choice.explores
            purpose = Purpose.LOOK if choice.explores else Purpose.ARRIVE
            state = replace(state, n_moved=state.n_moved + 1, n_explored=n_explored, probe=choice.explores)
            return moved(replace(state, purpose=purpose), body, see, place)
        if not fits:
            return rest(state, see, ServoStatus.NO_PROGRESS)
        if open_joints.any():  # as long as points are hidden somewhere, other places may show more
            left = options.exploring_unexplained * m - state.n_explored
            more_to_see = left > 0 and not body.seen.visible_in_both.all()
            return self._grow(state, see) if more_to_see else self._at_least_E(state, evidence)
        if beyond := self._beyond_limits(best, see):
            refused = replace(state, misfit=Misfit(MisfitKind.LIMIT, limits=beyond))
            return rest(refused, see, ServoStatus.NO_PROGRESS)
        two_answers = state.naming is not None and state.naming.is_ambiguous
        claims = error.max() < options.max_claimed_error and not two_answers
        return rest(state, see, ServoStatus.CONVERGED if claims else ServoStatus.SETTLED)

    def _is_lost(self, best: Estimate, evidence: Evidence) -> bool:
        """Whether the images leave a joint open, and the estimate is not worth going to."""
        is_open = best.open_joints(self.options, evidence.noise_px).any()
        return bool(is_open and best.std.max() > MAX_IMITATED_STD)

    def _chosen(self, state: EstimatorState, best: Estimate, evidence: Evidence) -> tuple[Estimate, Choice]:
        """Apply the rule. Before the arm rests, rivals of the estimate are asked for."""
        see, body, options = evidence.see, evidence.body, self.options

        def chosen(best: Estimate, explained: bool) -> Choice:
            fits = best.fits(options)
            most = options.exploring if fits else options.exploring_unexplained
            # without noise, looks from elsewhere lessen no error
            useful = not explained or (fits and see.noise_px > 0)
            may_explore = useful and state.n_explored < most * len(see.lower)
            target = np.clip(best.theta, see.lower, see.upper)
            return choose(best, body, see, target, options, may_explore, not explained)

        choice = chosen(best, best.fits(options) or best.explanation is None or best.is_clear(options))
        if choice.place is None and best.explanation is None:
            if best.fits(options):
                best = hypotheses.with_rivals(best, evidence)
                return best, chosen(best, True)
            return best, chosen(best, False)
        return best, choice

    def _beyond_limits(self, best: Estimate, see: Observation) -> tuple[BeyondLimit, ...]:
        """By how much the estimate is beyond the limits of which joints, where its standard error is no reason."""
        beyond = best.theta - np.clip(best.theta, see.lower, see.upper)
        excluded = np.abs(beyond) > self.options.max_limit_sigmas * np.maximum(best.std, SAME_PLACE)
        return tuple(BeyondLimit(int(j), float(beyond[j]), float(best.std[j])) for j in np.flatnonzero(excluded))

    def _without_body(self, state: EstimatorState, see: Observation, residuals: ResidualFunction) -> Outcome:
        """No body explains the own images: forget a calibration, or move farther and farther about the start."""
        if state.n_calibration:
            probes, visits = tuple(range(1, len(see.displacement))), state.visits[state.n_calibration :]
            state = replace(state, visits=visits, n_calibration=0, joints_to_probe=probes, probe=True)
            return replace(state, purpose=Purpose.PROBE), probe_motion(0, see)
        seen, options = state.seen, self.options
        idle, counts = np.flatnonzero(idle_joints(seen, see.noise_px, LEAST_MOTION)), seen.visible_in_both.sum(1)
        more_to_see = not seen.visible_in_both.all()
        most = options.growing if more_to_see or not len(idle) else 1
        if state.n_explored >= most * len(see.lower):
            if not len(idle) and see.noise_px > 0:
                meets = see.rectification is not None and see.rectification.meets_epipole(seen.images)
                state = replace(state, misfit=Misfit(MisfitKind.EPIPOLE if meets else MisfitKind.NOT_RIGID))
            status = ServoStatus.UNOBSERVABLE if len(idle) else ServoStatus.NO_PROGRESS
            return self._at_least_seen_E(state, see, residuals, status)
        if len(idle) and counts[-1] > counts[0]:  # joints that moved no visible point, where more points are visible
            joint, *left = idle.tolist()
            state = replace(state, joints_to_probe=tuple(left), n_explored=state.n_explored + 1, probe=True)
            return replace(state, purpose=Purpose.PROBE), probe_motion(joint, see)
        return self._grow(state, see)

    def _grow(self, state: EstimatorState, see: Observation, purpose: Purpose = Purpose.GROW) -> Outcome:
        """Go where the arm has not been: farther and farther about the start."""
        m = len(see.lower)
        rng = np.random.default_rng([see.seed, see.motion, m])
        reach = FIRST_REACH * (1 + state.n_explored / 2)
        places = state.visits[0].displacement + reach * rng.choice(REACHES, (PLACES, m))
        places = np.clip(places, see.lower, see.upper)
        visited = np.array([visit.displacement for visit in state.visits])
        place = places[first_largest(np.abs(places[:, None] - visited).max(-1).min(1))]
        state = replace(state, n_explored=state.n_explored + 1, probe=True, purpose=purpose)
        return moved(state, state.body, see, place)

    def _named(self, state: EstimatorState, body: OwnBody, see: Observation) -> Outcome:
        """Name the demonstrator's points; without success look from elsewhere."""
        here = body.here
        model = KnownBody(body.kinematics, body.seen, max(see.noise_px, LEAST_MOTION))
        found = find_naming(see.demonstrator[0], model, see.lower, see.upper, see.seed)
        state = replace(state, naming=None if found is None else found.per_pixel(state.unit_px))
        if found is not None and found.accepted:
            return replace(state, purpose=Purpose.NAME), np.zeros_like(here)
        if state.n_naming_motions < NAMING_MOTIONS:
            state = replace(state, n_naming_motions=state.n_naming_motions + 1)
            return self._grow(state, see, Purpose.NAME)
        return rest(replace(state, purpose=Purpose.NAME), see, ServoStatus.NO_PROGRESS)

    def _at_least_E(self, state: EstimatorState, evidence: Evidence) -> Outcome:
        """The images leave a joint open: rest at the least predicted E."""
        best, see = state.best, evidence.see
        minima = best.minima if best is not None and best.minima else evidence.postures()
        if best is not None and not self._is_lost(best, evidence):
            place = np.clip(best.theta, see.lower, see.upper)
        else:
            place = minima[0][1] if minima else see.displacement
        return nearest(state, evidence.body, see, place, ServoStatus.UNOBSERVABLE)

    def _at_least_seen_E(
        self, state: EstimatorState, see: Observation, residuals: ResidualFunction, status: ServoStatus
    ) -> Outcome:
        """No body predicts E: rest at the visit with the least E."""
        E = np.array([float(conflict(residuals(visit.own))) for visit in state.visits])
        place = state.visits[int(E.argmin())].displacement if np.isfinite(E).any() else see.displacement
        return nearest(state, None, see, place, status)


def repetition(seen: Observations) -> float:
    """By how much rounded images raise the noise, 1 for others: looks that show a coordinate alike count as one look.

    A point that does not move is rounded alike at each visit, so that no number of visits lessens the error.
    """
    counts, distinct = seen.visible_in_both.sum(0), np.ones(seen.images.shape[1:])
    for k, column in enumerate(seen.images.reshape(len(seen.images), -1).T):
        distinct.flat[k] = len(np.unique(column[np.isfinite(column)]))
    share = np.maximum(counts[:, None] / np.maximum(distinct, 1), 1.0)[counts > 0]
    return float(np.sqrt(share.mean())) if len(share) else 1.0


def nearest(
    state: EstimatorState, body: OwnBody | None, see: Observation, place: Displacement, status: ServoStatus
) -> Outcome:
    """Go to a posture once, and rest there."""
    here = see.displacement if body is None else body.here
    if state.went_nearest or np.abs(place - here).max() < SAME_PLACE:
        return rest(state, see, status)
    return moved(replace(state, purpose=Purpose.NEAREST, went_nearest=True), body, see, place)


def moved(state: EstimatorState, body: OwnBody | None, see: Observation, target: Displacement) -> Outcome:
    """Command the motion that brings the arm from where it is to a target, within its limits."""
    sent = target if body is None else body.to_reach(see.displacement, target)
    return state, np.clip(sent, see.lower, see.upper) - see.displacement


def rest(state: EstimatorState, see: Observation, status: ServoStatus) -> Outcome:
    """Stay."""
    return replace(state, status=status), np.zeros_like(see.displacement)
