"""Proportional control on images whose Jacobian a Kalman filter estimates, after Qian & Su (ICRA 2002).

The rows of the image Jacobian are the state of a filter, a random walk; every motion measures them. The residual e is
brought down by a share a motion, u = -g Ĵ_e⁺ e. There, e is the distance of own points to fixed targets; here the
targets follow from the own images as well, so that Ĵ_e, the derivative of e, is asked of the transfer at Ĵ. After one
probe a joint, as other laws make them, nothing excites the filter but the motions towards the goal.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..estimation.equations import HOLE, Equation, column, each, number
from ..estimation.residuals import ResidualFunction
from .observation import Observation, Visit
from .recursive_jacobian import RecursiveJacobian
from .recursive_law import RecursiveState, begun, learned, next_motion, probe_note, said
from .servo import Moment
from .status import ServoStatus

GAIN = 1.0  # g
FIRST, DRIFT = 500.0, 150.0  # px/rad, standard deviations: of the first Jacobian, of its change from motion to motion
BEND = 1.0  # px, standard deviation of an image from what its Jacobian foretells, without noise

_LAW = r"𝐮=-g\,\hat{𝐉}_e^{+}𝐞"
_FILTER = r"𝐤=\frac{𝐏𝐡}{r+𝐡^{\top}𝐏𝐡}"


@dataclass(frozen=True)
class KalmanState(RecursiveState):
    """Nothing beyond what all such laws remember."""


@dataclass(frozen=True)
class Kalman:
    """See the module. It has no constants to tune beyond the module's."""

    title = "Kalman filter"
    assumes = "That the image Jacobian changes little from motion to motion, and that e is small enough to be linear."
    limitations = (
        "Far from the goal: long motions change the Jacobian more than its filter allows, and nothing judges them."
    )
    slow = False
    predicts = False
    stored = (KalmanState, RecursiveJacobian, Visit)

    def start(self, seen: Observation) -> KalmanState:
        return begun(KalmanState, seen, FIRST**2)

    def retarget(self, state: KalmanState, seen: Observation) -> KalmanState:
        """What was learned of the own images stays."""
        return replace(state, best_E=np.inf, since_best=0, status=ServoStatus.MOVING)

    def step(self, state: KalmanState, seen: Observation, residuals: ResidualFunction) -> tuple[KalmanState, NDArray]:
        r = BEND**2 + 2 * seen.noise_px**2  # of a difference of two images
        state = learned(state, state.model.learn(seen, r, DRIFT**2), seen.E)
        return next_motion(state, seen, residuals, _within)

    def equations(self, state: KalmanState | None, moment: Moment) -> tuple[Equation, ...]:
        if state is None:
            return (Equation("", "no motion yet", _LAW), Equation("", "filter of the image Jacobian", _FILTER))
        latex, numbers = rf"𝐡^{{\top}}𝐤={HOLE},\quad {_FILTER}", (number(state.model.believed, 2),)
        share = Equation("", "filter: share believed of what was seen", latex, numbers)
        if state.probe:
            title, note = "servo: a share of the residual a motion", probe_note(moment)
            return (Equation("", title, _LAW, note=note), share)
        latex = rf"{_LAW}={column(len(state.asked))},\quad g={HOLE}"
        asked = tuple(angle + "°" for angle in each(np.degrees(state.asked), 2))
        title = "servo: a share of the residual a motion"
        return (Equation("", title, latex, (*asked, f"{GAIN:g}"), wide=True), share)

    def says(self, state: KalmanState, status: ServoStatus) -> str:
        return said(state, status)


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
