"""What the trust region remembers from one motion to the next."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ...estimation.views import Pairs
from ...geometry.kinematics.adjustment import fit_kinematics
from ...geometry.kinematics.model import ProjectiveKinematics
from ..observation import Observation, Visit
from ..status import ServoStatus
from .convergence import Certificate
from .image_models import observations_of
from .localisation import contradicts_command, localise

FIRST_RADIUS, LAST_RADIUS = np.radians((25.0, 12.0))
CERTAIN = np.radians(0.3)  # a displacement that E may leave room for where a servo claims to have arrived
EVERYWHERE = float(np.inf)  # of a learner that has been all over its range
KEPT = 60  # visits
CLOSE = 1e-9  # rad, between two times at one posture
ALL_OF = 0.9  # share of the region, from which a motion has made use of all of it
MOST_FAILURES = 2
PHASES = ((None, FIRST_RADIUS), ("linear", FIRST_RADIUS), (None, LAST_RADIUS))  # transfer, None: the chosen one
ASKED = 1, 2, 3, 5, 8, 13, 21, 34, 55  # visits, more than joints, at which kinematics are looked for


@dataclass(frozen=True)
class TrustState:
    """visits: the last of them is where the arm is. goal: (m,) rad, on the way to a restart or back to the best, where
    the status becomes `ending`.

    promised: decrease of E predicted for the motion just made, None if it was not made for that. slight: motions that
    kept such a promise, but lowered E by next to nothing, since one that did not. certificate: of the best posture,
    None before E was small anywhere. moved: the demonstrator has, since the last motion; chasing: and before that one
    as well, so that a motion aside would only leave the learner behind. exchanged: of the demonstrator's points, as it
    seems; asked: how often that was asked. rehearsed: what was seen before, as long as it holds: it takes the place of
    probes, and with it the whole range is the first region. needed: points by which E must be told at a posture for
    that to be the best, as those of another did not tell all joints. strayed: (m,) rad, from where the arm stands by
    its images to where it was sent, None as long as these agree; still: it stayed where it was, though it was sent
    elsewhere. limited: where it stalled, E should be least where a joint cannot be sent on. lines: points that one
    camera alone sees are asked, as the others do not tell every joint. kinematics: that explain all that is known of
    the own images, if any do: then they are foretold everywhere. unit_px: pixels of one unit, which all images and E
    are in here.
    """

    visits: tuple[Visit, ...]
    probes: tuple[int, ...]
    radius: float = float(FIRST_RADIUS)
    phase: int = 0
    promised: float | None = None
    goal: NDArray | None = None
    ending: ServoStatus | None = None
    restarts: int = 0
    checks: int = 0
    failures: int = 0
    slight: int = 0
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False
    certificate: Certificate | None = None
    moved: bool = False
    chasing: bool = False
    exchanged: Pairs = ()
    asked: int = 0
    rehearsed: tuple[Visit, ...] = ()
    needed: int = 0
    strayed: NDArray | None = None
    still: bool = False
    limited: bool = False
    lines: bool = False
    kinematics: ProjectiveKinematics | None = None
    unit_px: float = 1.0

    @property
    def foresees(self) -> bool:
        """Whether its images are foretold over the whole range."""
        return bool(self.rehearsed) or self.kinematics is not None

    @property
    def reach(self) -> float:
        """rad, a joint, from the best posture to where the predicted E is asked for."""
        return EVERYWHERE if self.kinematics is not None else self.radius

    @property
    def known(self) -> tuple[Visit, ...]:
        """All that the images are predicted from, what was rehearsed first."""
        return (*self.rehearsed, *self.visits)


def visit_of(seen: Observation) -> Visit:
    return Visit.of(seen.displacement, seen.own, seen.seen)


def arrived(state: TrustState, seen: Observation) -> tuple[TrustState, Observation]:
    """Remember what is seen here, once a posture, and whether the demonstrator has moved on the way → and what is seen,
    told from where the arm stands."""
    state, here = replace(state, moved=False, chasing=state.moved, still=False), visit_of(seen)
    if state.strayed is not None:
        return _by_images(state, seen, state.strayed)
    again = np.array_equal(state.visits[-1].displacement, seen.displacement)
    after = replace(state, visits=(*state.visits[: -1 if again else None], here)[-KEPT:])
    if again and len(after.visits) > 1:
        return after, seen
    after = _with_kinematics(after, seen)
    if not again and after.kinematics is None and contradicts_command(state.known, here, seen.noise_px):
        return _disobeyed(state, here), seen
    return after, seen


def _with_kinematics(state: TrustState, seen: Observation) -> TrustState:
    """That explain all visits, if any do; as long as none do they are looked for now and then."""
    since = len(state.visits) - (0 if state.rehearsed else len(seen.displacement))
    if state.kinematics is None and since not in ASKED:
        return state
    found = fit_kinematics(observations_of(state.known), seen.noise_px, seen.rectification, state.kinematics)
    return replace(state, kinematics=found)


def _disobeyed(state: TrustState, here: Visit) -> TrustState:
    """Of an arm that does not stand where it was sent: it probes anew, and its images alone tell its postures."""
    joints = len(here.displacement)
    anew = TrustState(
        (here,), tuple(range(joints)), restarts=state.restarts, strayed=np.zeros(joints), unit_px=state.unit_px
    )
    return replace(anew, chasing=state.chasing, exchanged=state.exchanged, asked=state.asked)


def _by_images(state: TrustState, seen: Observation, strayed: NDArray) -> tuple[TrustState, Observation]:
    """As `arrived`. A motion that was to lower E, but led to where the arm has been, has nothing more to gain, unless
    it was only as long as the region allowed: for an arm that moves in steps that may be too short."""
    last, sent = state.visits[-1].displacement, visit_of(seen.displaced(strayed))
    if np.abs(sent.displacement - last).max() < CLOSE:
        here, been = replace(sent, displacement=last), False
    else:
        here, been = localise(state.known, sent, seen.noise_px)
    still = been and np.array_equal(here.displacement, last)
    if been and state.promised is not None:
        barred = still and np.abs(sent.displacement - last).max() > ALL_OF * state.radius
        told = {"radius": 2 * state.radius} if barred else {"failures": MOST_FAILURES}
        state = replace(state, promised=None, **told)
    before = state.visits[:-1] if np.array_equal(here.displacement, last) else state.visits
    state = replace(state, visits=(*before, here)[-KEPT:], still=still)
    strayed = seen.displacement - here.displacement
    return replace(state, strayed=strayed), replace(seen.displaced(strayed), displacement=here.displacement)


def first_radius(rehearsed: tuple[Visit, ...]) -> float:
    """rad"""
    return EVERYWHERE if rehearsed else float(FIRST_RADIUS)


def without_rehearsal(state: TrustState) -> TrustState:
    """Head, base or points are not where they were: what was seen since is all that is known."""
    visits, joints = state.visits, len(state.visits[0].displacement)
    probes = tuple(range(joints)) if len(visits) <= joints else ()
    return TrustState(visits, probes, chasing=state.chasing, unit_px=state.unit_px)
