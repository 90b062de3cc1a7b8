"""The motions of the trust region: a probe, a check, a step to a target, or a long way to a goal."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..observation import Observation, Visit, probe_of
from ..status import ServoStatus
from .convergence import EQUAL
from .state import TrustState

LONGEST = np.radians(45.0)  # a joint and motion
DONE_STEP = np.radians(0.1)
RESTS = 0.1  # of the expected error from the goal
FAR_CANDIDATES = 200
EITHER_WAY = (1.0, -1.0, 0.5, -0.5)


def probe(state: TrustState, seen: Observation) -> tuple[TrustState, NDArray]:
    joint, *rest = state.probes
    return replace(state, probes=tuple(rest), status=ServoStatus.MOVING, probe=True), probe_of(joint, seen)


def check(state: TrustState, seen: Observation, place: NDArray, away: NDArray) -> tuple[TrustState, NDArray]:
    """A short motion to one side of a place: it teaches what the surrogate knows least."""
    goal = aside(seen, place, away) if seen.noise_px == 0 else apart(state.known, seen, place, away)
    return move(state, seen, goal, probe=True, checks=state.checks + 1)


def aside(seen: Observation, place: NDArray, away: NDArray) -> NDArray:
    """(m,) rad, away from a place, or the other way where the limits leave more room there."""
    either = np.clip(np.stack([place + away, place - away]), seen.lower, seen.upper)
    return either[_first_largest(np.abs(either - place).sum(1))]


def apart(visits: tuple[Visit, ...], seen: Observation, place: NDArray, away: NDArray) -> NDArray:
    """(m,) rad, away from a place, or the other way, or half as far, where it is farthest from what was visited: noise
    is averaged best by images that are not of one posture."""
    return farthest(visits, np.clip(place + np.outer(EITHER_WAY, away), seen.lower, seen.upper))


def move(
    state: TrustState, seen: Observation, target: NDArray, probe: bool = False, **changes: Any
) -> tuple[TrustState, NDArray]:
    """One motion to the target, or as far towards it as one motion may go. changes: of the state, by its fields."""
    step = target - seen.displacement
    longest = np.abs(step).max()
    if longest > LONGEST and not state.foresees:
        step, changes["promised"] = step * (LONGEST / longest), None
    return replace(state, status=ServoStatus.MOVING, probe=probe, **changes), step


def towards(state: TrustState, seen: Observation, goal: NDArray) -> tuple[TrustState, NDArray]:
    """On to the goal; there, a learner that drove back to its best posture rests."""
    if state.strayed is not None:  # what can be asked has changed on the way
        goal = np.clip(goal, seen.lower, seen.upper)
    there = state.foresees or np.abs(goal - seen.displacement).max() <= LONGEST
    state, step = move(state, seen, goal, promised=None, goal=None if there else goal)
    expected = 0.0 if state.certificate is None else float(state.certificate.expected.max())
    if state.ending and np.abs(step).max() < np.clip(RESTS * expected, DONE_STEP / 10, DONE_STEP):
        return replace(state, ending=None, status=state.ending), np.zeros_like(step)
    return state, step


def anywhere(seen: Observation) -> NDArray:
    """(k, m) rad: many postures."""
    return np.random.default_rng(seen.motion).uniform(seen.lower, seen.upper, (FAR_CANDIDATES, len(seen.lower)))


def along(seen: Observation, place: NDArray, way: NDArray) -> NDArray:
    """(k, m) rad: many postures on the line through a place, from limit to limit."""
    turned = way != 0  # no limit of the others is met
    ends = np.sort([(limit - place)[turned] / way[turned] for limit in (seen.lower, seen.upper)], axis=0)
    return place + np.linspace(ends[0].max(), ends[1].min(), FAR_CANDIDATES)[:, None] * way


def farthest(visits: tuple[Visit, ...], candidates: NDArray) -> NDArray:
    """The posture, of (k, m), that is farthest from all visited, of equal ones the first."""
    return candidates[_first_largest(nearest(visits, candidates))]


def _first_largest(values: NDArray) -> int:
    """Index of the largest of (n,) rad, of equal ones the first."""
    return int((values >= values.max() - EQUAL).argmax())


def nearest(visits: tuple[Visit, ...], candidates: NDArray, times: int = 1) -> NDArray:
    """(k,) rad, a joint, from each posture of (k, m) to as near as so many visits were, inf if there are fewer."""
    visited = np.array([visit.displacement for visit in visits])
    apart = np.sort(np.abs(candidates[:, None] - visited).max(-1), axis=1)
    return apart[:, times - 1] if len(visits) >= times else np.full(len(candidates), np.inf)
