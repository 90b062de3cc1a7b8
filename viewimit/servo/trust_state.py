"""What the trust region remembers from one motion to the next."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..views import Pairs
from .certificate import Certificate
from .observation import Observation
from .visit import Visit

FIRST_RADIUS = np.radians(25.0)
EVERYWHERE = float(np.inf)  # of a learner that has been all over its range
KEPT = 60  # visits


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
    that to be the best, as those of another did not tell all joints.
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
    slight: int = 0
    status: str = "moving"
    probe: bool = False
    certificate: Certificate | None = None
    moved: bool = False
    chasing: bool = False
    exchanged: Pairs = ()
    asked: int = 0
    rehearsed: tuple[Visit, ...] = ()
    needed: int = 0

    @property
    def known(self) -> tuple[Visit, ...]:
        """All that the images are predicted from, what was rehearsed first."""
        return (*self.rehearsed, *self.visits)


def visit_of(seen: Observation) -> Visit:
    return Visit.of(seen.displacement, seen.own, seen.seen)


def arrived(state: TrustState, seen: Observation) -> TrustState:
    """Remember what is seen here, once a posture, and whether the demonstrator has moved on the way."""
    visits = state.visits
    if np.array_equal(visits[-1].displacement, seen.displacement):
        visits = visits[:-1]
    return replace(state, visits=(*visits, visit_of(seen))[-KEPT:], moved=False, chasing=state.moved)


def first_radius(rehearsed: tuple[Visit, ...]) -> float:
    """rad"""
    return EVERYWHERE if rehearsed else float(FIRST_RADIUS)


def without_rehearsal(state: TrustState) -> TrustState:
    """Head, base or points are not where they were: what was seen since is all that is known."""
    visits, joints = state.visits, len(state.visits[0].displacement)
    return TrustState(visits, tuple(range(joints)) if len(visits) <= joints else (), chasing=state.chasing)
