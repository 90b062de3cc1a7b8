"""A servo that predicts its own images at postures not visited, and asks the transfer about them.

The surrogate learns the image as a function of the displacement; the argmin of the predicted E inside a trust region
is visited next, and the E then measured judges the region. Where that ends without enough evidence, another transfer's
E leads on, then the first one's again; then it begins anew, far from all that was visited. A learner that has watched
itself before needs no probes: it predicts from what it rehearsed as well, until its images say that this is past.

E small is no evidence of arrival by itself: a flat valley has small E far from its floor. With E ≈ δθᵀQδθ, what is
left of E could be a displacement of up to √(E/λ), λ the smallest eigenvalue of Q. Where that is less than CERTAIN, or E
is what the noise of the images makes, a certificate decides: "converged" is said only if visits, or check motions made
for it, have shown that E rises in every direction. The last short motions go a little beyond their target, where the
least is known of that.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..equations import Equation, angles, short
from ..evaluation import conflict as evaluate
from ..views import Pairs
from .certificate import CHECK, UNTOLD, Certificate, certify
from .identities import likely_exchange, with_exchanged
from .image_model import ENOUGH
from .innovation import holds
from .minimise import Minimum, minimise
from .observation import Conflict, Observation
from .servo import Moment
from .surrogate import Surrogate, learn
from .surroundings import FREE, Known, survey
from .visit import Visit

_LAW = (
    r"\hat{𝐲}(𝛉)=𝐲_c+\sum_{k}𝛂_k\,\kappa(𝛉-𝐜,\,𝛉_k-𝐜),\quad "
    r"𝛉^{*}=\underset{|𝛉-𝐜|_{\infty}\le D}{\mathrm{arg\,min}}\;E(\hat{𝐲}(𝛉))"
)
PROBE = np.radians(15.0)
FIRST_RADIUS, LAST_RADIUS, MAX_RADIUS, MIN_RADIUS = np.radians((25.0, 12.0, 45.0, 0.5))
LONGEST = np.radians(45.0)  # a joint and motion
EVERYWHERE = float(np.inf)  # of a learner that has been all over its range
DONE_STEP, LEAST_STEP = np.radians((0.1, 0.01))
SHORT = np.radians(5.0)  # a motion that may be lengthened to look beyond its target
CERTAIN, DOUBTFUL = np.radians((0.3, 5.0))
SHRINK_BELOW, GROW_ABOVE = 0.25, 0.6  # ratios of actual to predicted decrease
RESTS = 0.1  # of the expected error from the goal
NOISE_FLOOR = 2.5  # E up to so many times the noise's square is noise
PHASES = ((None, FIRST_RADIUS), ("linear", FIRST_RADIUS), (None, LAST_RADIUS))  # transfer, None: the chosen one
MOST_RESTARTS, MOST_CHECKS, MOST_FAILURES = 4, 3, 2
ASKED_AT = 5, 10, 16, 24  # visits and as many as joints, after which E must be small, or points may be exchanged
SUSPECT, SURE = 1e-3, 25.0  # of the mean square of the own image; times the noise's square: E that is small
KEPT = 60  # visits
GRID, SCATTERED, POLISHED = 7, 48, 3  # candidates a joint, with many joints in all; those that are refined
FAR_CANDIDATES = 200


@dataclass(frozen=True)
class TrustState:
    """visits: the last of them is where the arm is. goal: (m,) rad, on the way to a restart or back to the best, where
    the status becomes `ending`.

    promised: decrease of E predicted for the motion just made, None if it was not made for that. certificate: of the
    best posture, None before E was small anywhere. moved: the demonstrator has, since the last motion; chasing: and
    before that one as well, so that a motion aside would only leave the learner behind. exchanged: of the
    demonstrator's points, as it seems; asked: how often that was asked. rehearsed: what was seen before, as long as it
    holds: it takes the place of probes, and with it the whole range is the first region.
    """

    visits: tuple[Visit, ...]
    probes: tuple[int, ...]
    radius: float = float(FIRST_RADIUS)
    phase: int = 0
    promised: float | None = None
    goal: NDArray | None = None
    ending: str = ""
    restarts: int = 0
    checks: int = 0
    failures: int = 0
    status: str = "moving"
    probe: bool = False
    certificate: Certificate | None = None
    moved: bool = False
    chasing: bool = False
    exchanged: Pairs = ()
    asked: int = 0
    rehearsed: tuple[Visit, ...] = ()

    @property
    def known(self) -> tuple[Visit, ...]:
        """All that the images are predicted from, what was rehearsed first."""
        return (*self.rehearsed, *self.visits)


@dataclass(frozen=True)
class TrustRegion:
    """See the module. It has no constants to tune beyond the module's."""

    title = "Trust region on images"
    assumes = "That the images follow the joints smoothly; it predicts them from all postures visited."
    fails = "Where two postures give the same images, or every transfer misleads: then it says that it stalled."
    slow = False
    uses_rehearsal = True
    stored = (TrustState, Visit, Certificate)

    def start(self, seen: Observation) -> TrustState:
        probes = () if seen.rehearsed else tuple(range(len(seen.displacement)))
        return TrustState((_visit(seen),), probes, _first_radius(seen.rehearsed), rehearsed=seen.rehearsed)

    def retarget(self, state: TrustState, seen: Observation) -> TrustState:
        """What was learned of the own images stays; all else was about another E."""
        anew = TrustState(state.visits, state.probes, _first_radius(state.rehearsed), moved=True)
        kept = {name: getattr(state, name) for name in ("chasing", "exchanged", "asked", "rehearsed")}
        return replace(anew, **kept)

    def step(self, state: TrustState, seen: Observation, conflict: Conflict) -> tuple[TrustState, NDArray]:
        chasing = state.moved and state.chasing
        state = replace(_arrived(state, seen), moved=False, chasing=state.moved)
        if state.rehearsed and not holds(state.rehearsed, state.visits, seen.noise_px):
            state = _without_rehearsal(state)
        if state.probes:
            return _probe(state, seen)
        if state.goal is not None:
            return _towards(state, seen, state.goal)
        state, conflict = _identified(state, seen, conflict)
        by = PHASES[state.phase][0]
        own, like = _smoothed(state.known, seen.noise_px), None
        E, of, best = _measured(state.known, own, lambda images: conflict(images, by))
        if seen.noise_px > 0 and by is None:
            like = own[best]
            E, of, best = _measured(state.known, own, lambda images: conflict(images, by, like))
        state = _judge(state, E)
        model = learn(list(state.known), best, seen.noise_px)
        same = np.where(of[best], 0.0, np.nan)[:, None]  # points as those of the best visit's E
        residual_at = lambda theta: conflict(model.predict(theta) + same, by, like)
        found = _search(model, state.radius, seen, residual_at)
        step = np.max(np.abs(found.theta - model.centre))
        doubt = _doubt(float(E[best]), found)
        about = None
        if by is None:
            known = Known(state.known, best, float(E[best]), model, seen, lambda own: conflict(own, None, like))
            about = lambda place: certify(survey(known, found, place))
        # a short motion is made only for the certainty that it promises
        worthwhile = step >= DONE_STEP or (step >= LEAST_STEP and _doubt(found.E, found) < CERTAIN <= doubt)
        stands_there = np.max(np.abs(found.theta - seen.displacement)) < LEAST_STEP
        if worthwhile and not stands_there and state.failures < MOST_FAILURES:
            short = step < SHORT or bool(state.rehearsed)
            last = short and _doubt(found.E, found) < CERTAIN and state.checks < len(model.centre)
            if about is not None and like is None and last and not chasing:
                beyond = about(found.theta).check
                if beyond.any():
                    state = replace(state, checks=state.checks + 1)
                    return _move(state, seen, _aside(seen, found.theta, beyond))
            return _move(replace(state, promised=float(E[best] - found.E)), seen, found.theta)
        if chasing:
            return replace(state, promised=None, status="moving", probe=False), np.zeros_like(found.theta)
        place = model.centre if like is None else found.theta
        if about is not None:
            state = replace(state, certificate=about(place))
        settled = _settle(state, seen, place, float(E[best]), found)
        if settled is None:
            state, conflict = _otherwise(state, conflict)
            return self.step(state, seen, conflict)
        return settled

    def equations(self, state: TrustState | None, moment: Moment) -> tuple[Equation, ...]:
        if state is None:
            return (Equation("", "no motion yet", _LAW, wide=True),)
        known = f"The images are predicted from {len(state.visits)} postures visited; "
        note = f"{known}D = {np.degrees(state.radius):.3g}°. {_outcome(state, moment)}"
        return (Equation("", "servo: the images are predicted, E is asked", _LAW, note=note, wide=True),)

    def says(self, state: TrustState, status: str) -> str:
        if status == "converged":
            return f"E leaves no room for {np.degrees(CERTAIN):.1g}° and rises every way"
        if status == "rests":
            return "no evidence yet that E rises every way"
        if status == "untold":
            return "E does not rise every way"
        if status == "stalled":
            return f"nothing lower in {state.restarts} searches elsewhere"
        if state.ending:
            return "back to the best posture"
        if state.restarts:
            return f"looking for something lower, as noise explains less: search {state.restarts} of {MOST_RESTARTS}"
        if state.probe:
            return "a probe, to learn how the images move"
        other = PHASES[state.phase][0]
        return f"asks the {other} transfer for a way on" if other else ""


def _outcome(state: TrustState, moment: Moment) -> str:
    """What the last motion was for, or why there is none."""
    made = f"This motion, ({angles(moment.moved)}), "
    if state.probe:
        return f"{made}is a probe: it teaches what the predictions know least."
    if moment.status == "converged":
        return "What is left of E leaves no room for a displacement worth a motion: the servo rests."
    if moment.status == "stalled":
        return "Neither transfer nor restart led further: the servo rests."
    if state.promised is not None:
        return f"{made}was to lower E by <b>{short(state.promised)}</b> px²."
    return ""


def _visit(seen: Observation) -> Visit:
    return Visit.of(seen.displacement, seen.own, seen.seen)


def _arrived(state: TrustState, seen: Observation) -> TrustState:
    """Remember what is seen here, once a posture."""
    visits = state.visits
    if np.array_equal(visits[-1].displacement, seen.displacement):
        visits = visits[:-1]
    return replace(state, visits=(*visits, _visit(seen))[-KEPT:])


def _identified(state: TrustState, seen: Observation, conflict: Conflict) -> tuple[TrustState, Conflict]:
    """Now and then, while E stays too large: with what seems to be exchanged of the demonstrator's points, and the
    conflict that is left then."""
    small = max(SUSPECT * float(seen.own[seen.seen.all(-1)].var(0).sum()), SURE * seen.noise_px**2)
    asked = state.asked < len(ASKED_AT) and len(state.known) >= ASKED_AT[state.asked] + len(seen.displacement)
    if state.exchanged or not asked or not seen.E > small:
        return state, conflict
    model = learn(list(state.known), len(state.known) - 1, seen.noise_px)
    pairs = likely_exchange(model.predict, conflict, seen.lower, seen.upper, small)
    state = replace(state, asked=state.asked + 1)
    if pairs:
        state = replace(
            state, exchanged=pairs, phase=0, radius=_first_radius(state.rehearsed), failures=0, promised=None
        )
    return state, with_exchanged(conflict, pairs)


def _otherwise(state: TrustState, conflict: Conflict) -> tuple[TrustState, Conflict]:
    """Without the exchange that was to lower E, if there is one; else the next transfer takes over."""
    phase = 0 if state.exchanged else state.phase + 1
    begun = replace(state, exchanged=(), phase=phase, radius=float(PHASES[phase][1]), failures=0)
    return begun, with_exchanged(conflict, state.exchanged)


def _smoothed(visits: tuple[Visit, ...], noise_px: float) -> NDArray:
    """(n, N, 4) px of all visits, as they tell of each other: noise is averaged, points not seen are completed."""
    own = np.array([visit.own for visit in visits])
    unseen = np.isnan(own)
    if noise_px == 0 and not unseen.any():
        return own
    model = learn(list(visits), len(visits) - 1, noise_px)
    told = model.predict(np.array([visit.displacement for visit in visits]))
    return told if noise_px > 0 else np.where(unseen, told, own)


def _measured(
    visits: tuple[Visit, ...], own: NDArray, residual_of: Callable[[NDArray], NDArray]
) -> tuple[NDArray, NDArray, int]:
    """E of all visits, (n,) px², the points that it is of, (n, N) bool, and the best visit.

    Each by the points that were really seen there, if they are ENOUGH; else by all, as the other visits tell of them.
    Of fewer points E is smaller by itself, as FREE of them fit any images: that is made up for.
    """
    seen = np.array([visit.seen.all(-1) for visit in visits])
    if seen.all():
        E = evaluate(residual_of(own))
        return E, seen, int(np.argmin(E))
    E, count = np.empty((2, len(visits)))
    for k, (images, these) in enumerate(zip(own, seen)):
        e = residual_of(np.where(these[:, None], images, np.nan))
        if e.shape[-2] < ENOUGH:
            e, these[:] = residual_of(images), True
        E[k], count[k] = evaluate(e), e.shape[-2]
    return E, seen, int(np.argmin(E * count / np.maximum(count - FREE, 1)))


def _judge(state: TrustState, E: NDArray) -> TrustState:
    """Size the region by how true the promise of the last motion was. E: of all visits, px²."""
    if state.promised is None or len(E) < 2:
        return replace(state, promised=None)
    before = int(np.argmin(E[:-1]))
    ratio = (E[before] - E[-1]) / max(state.promised, 1e-12)
    step = np.max(np.abs(state.known[-1].displacement - state.known[before].displacement))
    radius, failures = state.radius, 0
    if ratio < SHRINK_BELOW:
        radius = max(0.4 * step, MIN_RADIUS)
        failures = state.failures + 1 if ratio <= 0 and step < 2 * MIN_RADIUS else 0
    elif ratio > GROW_ABOVE and step > 0.8 * radius:
        radius = max(radius, min(2 * radius, MAX_RADIUS))
    return replace(state, radius=float(radius), failures=failures, promised=None)


def _search(model: Surrogate, radius: float, seen: Observation, residual_at) -> Minimum:
    """argmin of the predicted E within the region and the limits: the best of many candidates, refined."""
    low, high = np.maximum(seen.lower, model.centre - radius), np.minimum(seen.upper, model.centre + radius)
    m = len(low)
    if m <= 2:
        axes = [np.linspace(a, b, GRID) for a, b in zip(low, high)]
        scattered = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, m)
    else:
        scattered = np.random.default_rng(seen.motion).uniform(low, high, (SCATTERED, m))
    E = evaluate(residual_at(scattered))
    starts = np.concatenate([model.centre[None], scattered[np.argsort(E)[:POLISHED]]])
    return minimise(residual_at, starts, low, high)


def _settle(
    state: TrustState, seen: Observation, place: NDArray, E: float, found: Minimum
) -> tuple[TrustState, NDArray] | None:
    """Nothing is left to gain by what is known: arrived at the place, or look for evidence, or elsewhere. None: the
    next phase."""
    doubt, certificate, state = _doubt(E, found), state.certificate, replace(state, failures=0)
    if PHASES[state.phase][0] is None and certificate is not None:
        lost = certificate.spent and not certificate.told.all()
        if doubt < CERTAIN or E < NOISE_FLOOR * seen.noise_px**2 or lost:
            if certificate.check.any() and state.checks < MOST_CHECKS * len(place):
                return _check(state, seen, place, certificate.check)
            return _towards(replace(state, ending=certificate.claim), seen, place)
        if doubt < DOUBTFUL and state.checks < MOST_CHECKS:
            return _check(state, seen, place, CHECK * np.linalg.eigh(found.hessian)[1][:, 0])
    if state.phase + 1 < len(PHASES):
        return None
    if state.restarts < MOST_RESTARTS:
        goal = _farthest(state.known, seen)
        begun = replace(state, phase=0, radius=float(FIRST_RADIUS), restarts=state.restarts + 1, checks=0)
        return _towards(begun, seen, goal)
    told = certificate is None or bool(certificate.told.all())
    return _towards(replace(state, ending="stalled" if told else "untold"), seen, place)


def _doubt(E: float, found: Minimum) -> float:
    """How far off, rad, a displacement can be that makes E, by E ≈ δθᵀQδθ, along what is told at all."""
    curvatures = np.linalg.eigvalsh(found.hessian)
    told = curvatures[curvatures * found.points > UNTOLD**-2]
    return float(np.sqrt(2 * E / max(told[0] if len(told) else curvatures[0], 1e-12)))


def _first_radius(rehearsed: tuple[Visit, ...]) -> float:
    """rad"""
    return EVERYWHERE if rehearsed else float(FIRST_RADIUS)


def _without_rehearsal(state: TrustState) -> TrustState:
    """Head, base or points are not where they were: what was seen since is all that is known."""
    visits, joints = state.visits, len(state.visits[0].displacement)
    return TrustState(visits, tuple(range(joints)) if len(visits) <= joints else (), chasing=state.chasing)


def _probe(state: TrustState, seen: Observation) -> tuple[TrustState, NDArray]:
    """Turn one joint by 15°, towards where its limits leave more room."""
    joint, *rest = state.probes
    above, below = seen.upper[joint] - seen.displacement[joint], seen.displacement[joint] - seen.lower[joint]
    step = np.zeros_like(seen.displacement)
    step[joint] = min(PROBE, above) if above >= min(PROBE, below) else -min(PROBE, below)
    return replace(state, probes=tuple(rest), status="moving", probe=True), step


def _check(state: TrustState, seen: Observation, place: NDArray, away: NDArray) -> tuple[TrustState, NDArray]:
    """A short motion to one side of a place: it teaches what the surrogate knows least."""
    state, step = _move(replace(state, checks=state.checks + 1), seen, _aside(seen, place, away))
    return replace(state, probe=True), step


def _aside(seen: Observation, place: NDArray, away: NDArray) -> NDArray:
    """(m,) rad, away from a place or the other way, where the limits leave more room."""
    either = np.clip(np.stack([place + away, place - away]), seen.lower, seen.upper)
    return either[int(np.argmax(np.abs(either - place).sum(1)))]


def _move(state: TrustState, seen: Observation, target: NDArray) -> tuple[TrustState, NDArray]:
    """One motion to the target, or as far towards it as one motion may go."""
    step = target - seen.displacement
    longest = np.max(np.abs(step))
    if longest > LONGEST and not state.rehearsed:
        step, state = step * (LONGEST / longest), replace(state, promised=None)
    return replace(state, status="moving", probe=False), step


def _towards(state: TrustState, seen: Observation, goal: NDArray) -> tuple[TrustState, NDArray]:
    """On to the goal; there, a learner that drove back to its best posture rests."""
    there = bool(state.rehearsed) or np.max(np.abs(goal - seen.displacement)) <= LONGEST
    state, step = _move(replace(state, promised=None, goal=None if there else goal), seen, goal)
    expected = 0.0 if state.certificate is None else float(state.certificate.expected.max())
    if state.ending and np.max(np.abs(step)) < np.clip(RESTS * expected, DONE_STEP / 10, DONE_STEP):
        return replace(state, ending="", status=state.ending), np.zeros_like(step)
    return state, step


def _farthest(visits: tuple[Visit, ...], seen: Observation) -> NDArray:
    """The posture, of many, that is farthest from all visited."""
    candidates = np.random.default_rng(seen.motion).uniform(seen.lower, seen.upper, (FAR_CANDIDATES, len(seen.lower)))
    visited = np.array([visit.displacement for visit in visits])
    apart = np.abs(candidates[:, None] - visited).max(-1).min(1)
    return candidates[int(np.argmax(apart))]
