"""A servo that predicts its own images at postures not visited, and asks the transfer about them.

After a probe of each joint the learner knows how its joints turn its points, if they turn as rigid bodies do: with
these kinematics it predicts its images at every posture, and goes where E should be least of all. As long as no
kinematics explain what it saw, a Gaussian process tells the image as a function of the displacement; the argmin of the
predicted E inside a trust region is visited next, and the E then measured judges the region. Where that ends
without enough evidence, another transfer's E leads on, then the first one's again; then it begins anew, far from all
that was visited. A learner that has watched itself before needs no probes: it predicts from what it rehearsed as well,
until its images say that this is past.

E small is no evidence of arrival by itself: a flat valley has small E far from its floor. With E ≈ δθᵀQδθ, what is
left of E could be a displacement of up to √(E/λ), λ the smallest eigenvalue of Q. Where that is less than CERTAIN, or E
is what the noise of the images makes, a certificate decides: "converged" is said only if visits, or check motions made
for it, have shown that E rises in every direction. The last short motions go a little beyond their target, where the
least is known of that.

An arm that moves in steps, or against a stop, does not stand where it was sent. Where its images say so, it probes anew
and goes by them alone; then it claims to be as near as its motions lead, and expects to be off by what they leave.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...estimation.equations import Equation
from ...estimation.residuals import ResidualFunction, noise_conflict
from ...geometry.kinematics.adjustment import PREDICTION_TOL_PX
from ...geometry.kinematics.model import ProjectiveKinematics, StereoFrame
from ...geometry.rectification import Rectification
from ..observation import Observation, ScaledResiduals, Visit, in_units, unit_of
from ..servo import LastMotion
from ..status import ServoStatus
from .convergence import CHECK, Certificate, curvature_directions
from .correspondences import likely_exchange, with_exchanged
from .explanation import equations, says
from .image_models import ImageData
from .local_model import freedom_of
from .localisation import is_consistent
from .motions import DONE_STEP, along, anywhere, aside, check, farthest, move, nearest, probe, towards
from .state import (
    CERTAIN,
    CLOSE,
    FIRST_RADIUS,
    MOST_FAILURES,
    PHASES,
    TrustState,
    arrived,
    first_radius,
    visit_of,
    without_rehearsal,
)
from .subproblem import Outlook, last_least, look_out, measure

MAX_RADIUS, MIN_RADIUS = np.radians((45.0, 0.5))
LEAST_STEP = np.radians(0.01)
SHORT = np.radians(5.0)  # a motion that may be lengthened to look beyond its target
DOUBTFUL = np.radians(5.0)
SHRINK_BELOW, GROW_ABOVE = 0.25, 0.6  # ratios of actual to predicted decrease
NOISE_DEVIATIONS = 3.0  # standard deviations of E beyond what noise makes of it
NOISE_SLACK = 1.2  # times the noise, as that is measured itself
MOST_CHECKS = 3
SLIGHT, MOST_SLIGHT = 0.01, 8  # share of E; motions that may gain less, though they keep what they promise
ASKED_AT = 1, 5, 10, 16, 24  # visits, more than joints, after which E must be small, or points may be exchanged; the
# first is for a learner that foresees E all over its range
SUSPECT, SURE = 1e-3, 25.0  # of the mean square of the own image; times the noise's square: E that is small


@dataclass(frozen=True)
class TrustRegion:
    """See the module. It has no constants to tune beyond the module's."""

    title = "Trust region on images"
    assumes = "That joints turn points as rigid bodies; or else that the images follow the joints smoothly."
    fails = "Where two postures give the same images, or every transfer misleads: then it says that it stalled."
    slow = False
    predicts = True
    stored = (TrustState, Visit, Certificate, ProjectiveKinematics, StereoFrame, Rectification)

    def start(self, seen: Observation) -> TrustState:
        probes, unit_px = () if seen.rehearsed else tuple(range(len(seen.displacement))), unit_of(seen)
        seen = in_units(seen, unit_px)
        return TrustState(
            (visit_of(seen),), probes, first_radius(seen.rehearsed), rehearsed=seen.rehearsed, unit_px=unit_px
        )

    def retarget(self, state: TrustState, seen: Observation) -> TrustState:
        """What was learned of the own images stays; all else was about another E."""
        anew = TrustState(state.visits, state.probes, first_radius(state.rehearsed), moved=True)
        kept = {
            name: getattr(state, name)
            for name in ("chasing", "exchanged", "asked", "rehearsed", "strayed", "kinematics", "unit_px")
        }
        return replace(anew, **kept)

    def step(self, state: TrustState, seen: Observation, residuals: ResidualFunction) -> tuple[TrustState, NDArray]:
        chasing = state.moved and state.chasing
        seen = replace(seen, rehearsed=())  # the state has it, in units
        state, seen = arrived(state, in_units(seen, state.unit_px))
        residuals = ScaledResiduals(residuals, state.unit_px)
        residuals = residuals.with_partially_visible() if state.lines else residuals
        if (
            state.rehearsed
            and state.kinematics is None
            and not is_consistent(state.rehearsed, state.visits, seen.noise_px)
        ):
            state = without_rehearsal(state)
        if state.probes:
            return probe(state, seen)
        if state.goal is not None:
            return towards(state, seen, state.goal)
        return self._step(state, seen, residuals, chasing)

    def _step(
        self, state: TrustState, seen: Observation, residuals: ResidualFunction, chasing: bool
    ) -> tuple[TrustState, NDArray]:
        by = PHASES[state.phase][0]
        learned = ImageData(state.known, seen.noise_px, state.kinematics)
        measured = measure(learned, residuals, by, state.needed)
        state = _judge(state, measured.E, noise_E(seen, int(measured.count[measured.best])))
        ahead = look_out(learned, measured, state.reach, seen, residuals, by)
        if _puzzled(state, seen, ahead, weighted=measured.noise_reference is not None):
            state = _identified(state, seen, learned, residuals)
            if state.exchanged:
                return self._step(state, seen, with_exchanged(residuals, state.exchanged), chasing)
        if _worthwhile(state, seen, ahead):
            return _onwards(state, seen, ahead, weighted=measured.noise_reference is not None, chasing=chasing)
        if chasing:
            return replace(state, promised=None, status=ServoStatus.MOVING, probe=False), np.zeros_like(
                seen.displacement
            )
        state, place = _placed(state, seen, ahead, weighted=measured.noise_reference is not None)
        if _lines_may_tell(state, seen):
            state = replace(state, lines=True, radius=first_radius(state.rehearsed), failures=0, promised=None)
            return self._step(state, seen, residuals.with_partially_visible(), chasing=False)
        settled = _settle(state, seen, place, ahead, int(measured.count[measured.best]))
        if settled is None:
            return self._step(*_otherwise(state, seen, residuals), chasing=False)
        return settled

    def equations(self, state: TrustState | None, moment: LastMotion) -> tuple[Equation, ...]:
        return equations(state, moment)

    def says(self, state: TrustState, status: ServoStatus) -> str:
        return says(state, status)


def noise_E(seen: Observation, points: int) -> float:
    """px²: E up to which noise explains it, of so many points."""
    freedom = freedom_of(points, len(seen.displacement))
    return noise_conflict(points, freedom, NOISE_SLACK * seen.noise_px, NOISE_DEVIATIONS)


def _turn(state: TrustState) -> int:
    """How often it has been asked, or was left out, what seems to be exchanged."""
    return state.asked if state.kinematics is not None else max(state.asked, 1)


def _small(seen: Observation) -> float:
    """px²: an E that explains itself."""
    return max(SUSPECT * float(seen.own[seen.seen.all(-1)].var(0).sum()), SURE * seen.noise_px**2)


def _puzzled(state: TrustState, seen: Observation, ahead: Outlook, weighted: bool) -> bool:
    """Whether to ask what seems to be exchanged: now and then while E stays too large, unless it is foreseen to be
    small somewhere."""
    turn = _turn(state)
    if state.exchanged or turn >= len(ASKED_AT) or len(state.known) < ASKED_AT[turn] + len(seen.displacement):
        return False
    foreseen = ahead.found.E if state.kinematics is not None and ahead.certify is not None else np.inf
    E = ahead.E if weighted else seen.E
    return bool(np.isfinite(E) and min(E, foreseen) > _small(seen))


def _identified(state: TrustState, seen: Observation, learned: ImageData, residuals: ResidualFunction) -> TrustState:
    """With what seems to be exchanged of the demonstrator's points, if anything does."""
    pairs = likely_exchange(learned.fit().predict, residuals, seen.lower, seen.upper, _small(seen))
    state = replace(state, asked=_turn(state) + 1)
    if not pairs:
        return state
    return replace(state, exchanged=pairs, phase=0, radius=first_radius(state.rehearsed), failures=0, promised=None)


def _worthwhile(state: TrustState, seen: Observation, ahead: Outlook) -> bool:
    """Whether to go where E should be least. A short motion is made only for the certainty that it promises."""
    step, found = ahead.step, ahead.found
    promises = step >= DONE_STEP or (step >= LEAST_STEP and ahead.doubt_there < CERTAIN <= ahead.doubt)
    stands_there = np.abs(found.theta - seen.displacement).max() < LEAST_STEP
    return bool(promises and not stands_there and ahead.E > PREDICTION_TOL_PX**2 and state.failures < MOST_FAILURES)


def _onwards(
    state: TrustState, seen: Observation, ahead: Outlook, weighted: bool, chasing: bool
) -> tuple[TrustState, NDArray]:
    """To where E should be least; the last short motions a little beyond, where the least is known of how E rises."""
    found = ahead.found
    brief = ahead.step < SHORT or state.foresees
    last = brief and ahead.doubt_there < CERTAIN and state.checks < len(found.theta)
    if ahead.certify is not None and not weighted and last and not chasing:
        asked = ahead.certify(found.theta).check
        beyond = aside(seen, found.theta, asked)
        if asked.any() and nearest(state.known, beyond[None])[0] > LEAST_STEP:
            return move(state, seen, beyond, checks=state.checks + 1)
    return move(state, seen, found.theta, promised=float(ahead.E - found.E))


def _placed(state: TrustState, seen: Observation, ahead: Outlook, weighted: bool) -> tuple[TrustState, NDArray]:
    """And where to rest, (m,) rad, certified: where E should be least, as noise hides where it was; an arm that does
    not stand where it is sent, at the best posture visited, or where it stands if no motion leads there, though E is
    no least then."""
    best = ahead.model.centre
    place = ahead.found.theta if weighted and state.strayed is None else best
    if state.strayed is not None and state.ending and (state.still or _often(state, seen)):
        place = seen.displacement
    if ahead.certify is None:
        return (replace(state, certificate=None) if PHASES[state.phase][0] is None else state), place
    certificate = ahead.certify(place).per_pixel(state.unit_px)
    if state.strayed is not None and not np.array_equal(place, best):
        certificate = replace(certificate, shown=False)
    return replace(state, certificate=certificate), place


def _otherwise(
    state: TrustState, seen: Observation, residuals: ResidualFunction
) -> tuple[TrustState, Observation, ResidualFunction]:
    """Without the exchange that was to lower E, if there is one; else the next transfer takes over. After the last,
    what few points tell must do."""
    last = state.phase + 1 == len(PHASES)
    phase = 0 if state.exchanged or last else state.phase + 1
    begun = replace(state, exchanged=(), phase=phase, radius=float(PHASES[phase][1]), failures=0, slight=0)
    begun = replace(begun, needed=0 if last else state.needed, chasing=False)
    return begun, seen, with_exchanged(residuals, state.exchanged)


def _judge(state: TrustState, E: NDArray, noise_E: float) -> TrustState:
    """Size the region by how true the promise of the last motion was. E: of all visits, px²; noise_E: up to which that
    is noise."""
    if state.promised is None:
        return state
    if len(E) < 2:
        return replace(state, promised=None)
    before = last_least(E[:-1])
    if np.isinf(E[before]):  # nothing was told of any posture before: nothing could be promised
        return replace(state, promised=None)
    gained = float(E[before] - E[-1])
    ratio = gained / max(state.promised, 1e-12)
    step = np.abs(state.known[-1].displacement - state.known[before].displacement).max()
    step = min(step, state.radius)  # farther, if what was best then is not any more, by what has been seen since
    radius, failures, slight = state.radius, 0, state.slight
    if gained >= SLIGHT * E[before]:
        slight = 0
    elif gained > 0 and E[before] > noise_E:
        slight += 1
    if ratio < SHRINK_BELOW:
        radius = max(0.4 * step, MIN_RADIUS)
        failures = state.failures + 1 if ratio <= 0 and step < 2 * MIN_RADIUS else 0
    elif ratio > GROW_ABOVE and step > 0.8 * radius:
        radius = max(radius, min(2 * radius, MAX_RADIUS))
    if slight > MOST_SLIGHT:  # along a valley that hardly sinks, as of points that tell next to nothing
        failures = MOST_FAILURES
    return replace(state, radius=float(radius), failures=failures, slight=slight, promised=None)


def _settle(
    state: TrustState, seen: Observation, place: NDArray, ahead: Outlook, told_by: int
) -> tuple[TrustState, NDArray] | None:
    """Nothing is left to gain by what is known: arrived at the place, or look for evidence, or elsewhere. None: the
    next phase. told_by: so many points."""
    doubt, certificate, state = ahead.doubt, state.certificate, replace(state, failures=0)
    if PHASES[state.phase][0] is None and certificate is not None:
        lost = certificate.lost
        asks = certificate.check.any() and state.checks < MOST_CHECKS * len(place)
        if (
            lost
            and not (asks and certificate.learnable)
            and told_by < _shown(state, seen)
            and state.restarts < seen.restarts
        ):
            return _where_more_is_seen(state, seen, place, ahead, told_by)
        barred = state.strayed is not None and ahead.doubt_there < CERTAIN  # its steps lead no nearer
        if barred or doubt < CERTAIN or ahead.E < noise_E(seen, told_by) or lost:
            if asks:
                return check(state, seen, place, certificate.check)
            return _to_rest(state, seen, place, certificate.claim)
        if doubt < DOUBTFUL and state.checks < MOST_CHECKS:
            return check(state, seen, place, CHECK * curvature_directions(ahead.found.hessian)[:, 0])
    if state.phase + 1 < len(PHASES):
        return None
    if state.restarts < seen.restarts:
        return towards(replace(_anew(state), needed=0), seen, farthest(state.known, anywhere(seen)))
    if 0 < state.needed <= told_by:
        return None
    told = certificate is None or bool(certificate.told.all())
    limited = bool((np.minimum(ahead.found.theta - seen.lower, seen.upper - ahead.found.theta) < CLOSE).any())
    ending = ServoStatus.NO_PROGRESS if told else ServoStatus.UNOBSERVABLE
    return _to_rest(replace(state, limited=limited), seen, place, ending)


def _lines_may_tell(state: TrustState, seen: Observation) -> bool:
    """Whether points that one camera alone sees may tell a joint that the others do not. They cannot be held against
    the other camera, so that they are asked only then."""
    certificate = state.certificate if PHASES[state.phase][0] is None else None
    return certificate is not None and certificate.lost and not state.lines and seen.half_shown > 0


def _shown(state: TrustState, seen: Observation) -> int:
    """How many points may tell of a posture."""
    return seen.shown + (seen.half_shown if state.lines else 0)


def _to_rest(state: TrustState, seen: Observation, place: NDArray, ending: ServoStatus) -> tuple[TrustState, NDArray]:
    """There, what did not come true from there is not tried once more. By the third time at a posture that is best by
    turns with another, here."""
    if state.ending and _often(state, seen):
        return replace(state, ending=None, status=ending), np.zeros_like(place)
    return towards(replace(state, ending=ending, failures=MOST_FAILURES), seen, place)


def _often(state: TrustState, seen: Observation) -> bool:
    """Whether it is for the third time where it is."""
    return bool(nearest(state.visits, seen.displacement[None], 3)[0] < CLOSE)


def _where_more_is_seen(
    state: TrustState, seen: Observation, place: NDArray, ahead: Outlook, told_by: int
) -> tuple[TrustState, NDArray]:
    """Far away on the line that so many points do not tell, as long as that is unknown: others of the demonstrator's
    may be seen there. Then anywhere."""
    flattest = curvature_directions(ahead.found.hessian)[:, 0]
    goal = farthest(state.known, along(seen, place, flattest))
    if nearest(state.known, goal[None])[0] < FIRST_RADIUS:
        goal = farthest(state.known, anywhere(seen))
    return towards(replace(_anew(state), needed=told_by + 1), seen, goal)


def _anew(state: TrustState) -> TrustState:
    return replace(
        state, phase=0, radius=float(FIRST_RADIUS), restarts=state.restarts + 1, checks=0, slight=0, lines=False
    )
