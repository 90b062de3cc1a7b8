"""What the laws have in common that estimate an image Jacobian with every motion: they probe each joint once, then ask
for ever smaller motions towards e = 0.

None has a test of arrival: they rest where the next motion would be too small, and claim nothing.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..estimation.equations import angles
from ..estimation.residuals import ResidualFunction
from .observation import Observation, probe_of
from .recursive_jacobian import RecursiveJacobian
from .servo import Moment
from .status import ServoStatus

LONGEST, DONE_STEP = np.radians((25.0, 0.1))  # a joint and motion; a motion shorter than this is not worth making
PATIENCE, PROGRESS = 30, 0.99  # motions without E falling to this share of its least, after which it has stalled

Law = Callable[[NDArray, NDArray, NDArray, NDArray], NDArray]  # J, e, lowest and highest step → (m,) rad
S = TypeVar("S", bound="RecursiveState")


@dataclass(frozen=True)
class RecursiveState:
    """model: of the own images; asked: (m,) rad, what the law wants, before bounds and limits; probes: joints still to
    probe; best_E, since_best: px², the least E so far, and the motions since."""

    model: RecursiveJacobian
    asked: NDArray
    probes: tuple[int, ...]
    best_E: float
    since_best: int = 0
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False


def begun(kind: type[S], seen: Observation, variance: float) -> S:
    """Before the first motion. variance: of the first Jacobian, as `RecursiveJacobian.start` has it."""
    m = len(seen.displacement)
    return kind(RecursiveJacobian.start(seen, variance), np.zeros(m), tuple(range(m)), seen.E)


def learned(state: S, model: RecursiveJacobian, E: float) -> S:
    """With what the last motion told. E: px²"""
    since_best, best_E = (0, E) if E < PROGRESS * state.best_E else (state.since_best + 1, state.best_E)
    return replace(state, model=model, best_E=best_E, since_best=since_best, status=ServoStatus.MOVING, probe=False)


def next_motion(state: S, seen: Observation, residuals: ResidualFunction, law: Law) -> tuple[S, NDArray]:
    """A probe, or what the law asks for, within bounds and limits; none where it rests or has stalled."""
    if state.probes:
        joint, *rest = state.probes
        return replace(state, probes=tuple(rest), probe=True), probe_of(joint, seen)
    e, J = state.model.linearised(residuals)
    if not np.isfinite(e).all() or state.since_best >= PATIENCE:
        return replace(state, status=ServoStatus.NO_PROGRESS), np.zeros_like(seen.displacement)
    low, high = seen.lower - seen.displacement, seen.upper - seen.displacement
    asked = law(J, e, low, high)
    step = np.clip(asked * min(1.0, LONGEST / max(np.abs(asked).max(), 1e-12)), low, high)
    if np.abs(step).max() < DONE_STEP:
        return replace(state, asked=asked, status=ServoStatus.SETTLED), np.zeros_like(step)
    return replace(state, asked=asked), step


def probe_note(moment: Moment) -> str:
    """Beside the law's equation, of a motion that is none of it."""
    return f"This motion, ({angles(moment.moved)}), is a probe: it teaches a first column of Ĵ."


def said(state: RecursiveState, status: ServoStatus) -> str:
    """Why it moves or rests."""
    if status == ServoStatus.NO_PROGRESS:
        return f"not lower for {state.since_best} motions" if state.since_best >= PATIENCE else "no way on from here"
    if status == ServoStatus.SETTLED:
        return f"next step under {np.degrees(DONE_STEP):g}°"
    return "a probe, to learn how the images move" if state.probe and status == ServoStatus.MOVING else ""
