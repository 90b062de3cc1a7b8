"""Proportional control on images whose Jacobian a Kalman filter estimates, after Qian & Su (ICRA 2002).

The rows of the image Jacobian are the state of a filter, a random walk; every motion measures them. The residual e is
brought down by a share a motion, u = -g Ĵ_e⁺ e. There, e is the distance of own points to fixed targets; here the
targets follow from the own images as well, so that Ĵ_e, the derivative of e, is asked of the transfer at Ĵ. After one
probe a joint, as other laws make them, nothing excites the filter but the motions towards the goal.

Law and filter have no test of arrival: it rests where the next motion would be too small, and claims nothing.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..equations import HOLE, Equation, angles, column, each, number
from .observation import Conflict, Observation
from .probing import probe_of
from .recursive_jacobian import RecursiveJacobian
from .servo import Moment
from .visit import Visit

GAIN = 1.0  # g
FIRST, DRIFT = 500.0, 150.0  # px/rad, standard deviations: of the first Jacobian, of its change from motion to motion
BEND = 1.0  # px, standard deviation of an image from what its Jacobian foretells, without noise
LONGEST, DONE_STEP = np.radians((25.0, 0.1))  # a joint and motion; a motion shorter than this is not worth making
PATIENCE, PROGRESS = 30, 0.99  # motions without E falling to this share of its least, after which it has stalled

_LAW = r"𝐮=-g\,\hat{𝐉}_e^{+}𝐞"
_FILTER = r"𝐤=\frac{𝐏𝐡}{r+𝐡^{\top}𝐏𝐡}"


@dataclass(frozen=True)
class KalmanState:
    """model: of the own images; asked: (m,) rad, what the law wants, before bounds and limits; probes: joints still to
    probe; best_E, since_best: px², the least E so far, and the motions since."""

    model: RecursiveJacobian
    asked: NDArray
    probes: tuple[int, ...]
    best_E: float
    since_best: int = 0
    status: str = "moving"
    probe: bool = False


@dataclass(frozen=True)
class Kalman:
    """See the module. It has no constants to tune beyond the module's."""

    title = "Kalman filter"
    assumes = "That the image Jacobian changes little from motion to motion, and that e is small enough to be linear."
    fails = "Far from the goal: long motions change the Jacobian more than its filter allows, and nothing judges them."
    slow = False
    predicts = False
    stored = (KalmanState, RecursiveJacobian, Visit)

    def start(self, seen: Observation) -> KalmanState:
        m = len(seen.displacement)
        return KalmanState(RecursiveJacobian.start(seen, FIRST**2), np.zeros(m), tuple(range(m)), seen.E)

    def retarget(self, state: KalmanState, seen: Observation) -> KalmanState:
        """What was learned of the own images stays."""
        return replace(state, best_E=np.inf, since_best=0, status="moving")

    def step(self, state: KalmanState, seen: Observation, conflict: Conflict) -> tuple[KalmanState, NDArray]:
        r = BEND**2 + 2 * seen.noise_px**2  # of a difference of two images
        model = state.model.learn(seen, r, DRIFT**2)
        progress = seen.E < PROGRESS * state.best_E
        since_best, best_E = (0, seen.E) if progress else (state.since_best + 1, state.best_E)
        state = replace(state, model=model, best_E=best_E, since_best=since_best, status="moving", probe=False)
        if state.probes:
            joint, *rest = state.probes
            return replace(state, probes=tuple(rest), probe=True), probe_of(joint, seen)
        e, J = model.linearised(conflict)
        if not np.isfinite(e).all() or since_best >= PATIENCE:
            return replace(state, status="stalled"), np.zeros_like(seen.displacement)
        low, high = seen.lower - seen.displacement, seen.upper - seen.displacement
        asked = _within(J, e, low, high)
        step = np.clip(asked * min(1.0, LONGEST / max(np.abs(asked).max(), 1e-12)), low, high)
        if np.abs(step).max() < DONE_STEP:
            return replace(state, asked=asked, status="rests"), np.zeros_like(step)
        return replace(state, asked=asked), step

    def equations(self, state: KalmanState | None, moment: Moment) -> tuple[Equation, ...]:
        if state is None:
            return (Equation("", "no motion yet", _LAW), Equation("", "filter of the image Jacobian", _FILTER))
        latex, numbers = rf"𝐡^{{\top}}𝐤={HOLE},\quad {_FILTER}", (number(state.model.believed, 2),)
        learned = Equation("", "filter: share believed of what was seen", latex, numbers)
        if state.probe:
            note = f"This motion, ({angles(moment.moved)}), is a probe: it teaches a first column of Ĵ."
            return (Equation("", "servo: a share of the residual a motion", _LAW, note=note), learned)
        latex = rf"{_LAW}={column(len(state.asked))},\quad g={HOLE}"
        asked = tuple(angle + "°" for angle in each(np.degrees(state.asked), 2))
        title = "servo: a share of the residual a motion"
        return (Equation("", title, latex, (*asked, f"{GAIN:g}"), wide=True), learned)

    def says(self, state: KalmanState, status: str) -> str:
        return said(state.probe, state.since_best, status)


def _within(J: NDArray, e: NDArray, low: NDArray, high: NDArray) -> NDArray:
    """-g J⁺e, (m,) rad, of the joints that do not stand at a limit beyond which they would go: those are held."""
    free: NDArray = np.ones(len(low), bool)
    while True:
        asked = np.zeros(len(low))
        asked[free] = -GAIN * np.linalg.lstsq(J[:, free], e, rcond=None)[0]
        beyond = ((low >= 0) & (asked < 0)) | ((high <= 0) & (asked > 0))
        if not beyond.any():
            return asked
        free &= ~beyond


def said(probe: bool, since_best: int, status: str) -> str:
    """Why a law that asks for ever smaller motions moves or rests."""
    if status == "stalled":
        return f"not lower for {since_best} motions" if since_best >= PATIENCE else "no way on from here"
    if status == "rests":
        return f"next step under {np.degrees(DONE_STEP):g}°"
    return "a probe, to learn how the images move" if probe and status == "moving" else ""
