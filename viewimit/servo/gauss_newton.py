"""Damped Gauss-Newton on images whose Jacobian recursive least squares estimate online, after Piepmeier, McMurray &
Lipkin (IEEE Transactions on Robotics and Automation 20(1), 2004).

u = -(JᵀJ + μ D)⁻¹ Jᵀe, D the diagonal of JᵀJ, with J = Ĵ_e the derivative of the residual, asked of the transfer at the
image Jacobian Ĵ. Ĵ is what all motions so far tell, those long past with weight λ each (recursive least squares with
forgetting). A motion after which E is larger raises μ, one after which it is less lowers it (Levenberg 1944, Marquardt
1963); the arm goes on from where it stands, as a step back would be a motion as well. The target stands still, so the
term of that paper for one that moves is 0.
"""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..estimation.equations import HOLE, Equation, column, each, number
from ..estimation.residuals import ResidualFunction
from .observation import Observation, Visit
from .recursive_jacobian import RecursiveJacobian
from .recursive_law import RecursiveState, begun, learned, next_motion, probe_note, said
from .servo import Moment
from .status import ServoStatus

FORGETTING = 0.5  # λ, a motion
FIRST = 1e6  # /rad², P_0: nothing is known of the first Jacobian
DAMPING, LEAST_DAMPING, MOST_DAMPING, FACTOR = 1e-2, 1e-4, 1e2, 10.0  # μ, relative to the diagonal of JᵀJ

_LAW = r"𝐮=-(\hat{𝐉}_e^{\top}\hat{𝐉}_e+\mu 𝐃)^{-1}\hat{𝐉}_e^{\top}𝐞"
_WEIGHTS = r"\hat{𝐉}=\mathrm{arg\,min}\sum_i\lambda^{k-i}\,|Δ𝐲_i-𝐉𝐡_i|^2"


@dataclass(frozen=True)
class GaussNewtonState(RecursiveState):
    """damping: μ; before: px², E before the motion just made, None if that is not to be judged by it."""

    damping: float = DAMPING
    before: float | None = None


@dataclass(frozen=True)
class GaussNewton:
    """See the module. It has no constants to tune beyond the module's."""

    title = "Damped Gauss-Newton"
    assumes = "That the images are linear in the joints over the last few motions, and E in one valley."
    limitations = (
        "Where the Jacobian of some motions ago misleads: it damps its motions until it stands still, and stalls."
    )
    slow = False
    predicts = False
    stored = (GaussNewtonState, RecursiveJacobian, Visit)

    def start(self, seen: Observation) -> GaussNewtonState:
        return begun(GaussNewtonState, seen, FIRST)

    def retarget(self, state: GaussNewtonState, seen: Observation) -> GaussNewtonState:
        """What was learned of the own images stays; the damping was about another E."""
        return replace(state, best_E=np.inf, damping=DAMPING, before=None, since_best=0, status=ServoStatus.MOVING)

    def step(
        self, state: GaussNewtonState, seen: Observation, residuals: ResidualFunction
    ) -> tuple[GaussNewtonState, NDArray]:
        model = state.model.learn(seen, FORGETTING, forgetting=FORGETTING)
        state = learned(_judged(state, seen.E), model, seen.E)
        state, step = next_motion(state, seen, residuals, partial(_damped, damping=state.damping))
        if state.status == ServoStatus.NO_PROGRESS:
            return state, step
        return replace(state, before=None if state.probe else seen.E), step

    def equations(self, state: GaussNewtonState | None, moment: Moment) -> tuple[Equation, ...]:
        weighted = Equation("", "Jacobian: least squares with forgetting", _WEIGHTS, wide=True)
        if state is None:
            return (Equation("", "no motion yet", _LAW, wide=True), weighted)
        if state.probe:
            note = probe_note(moment)
            return (Equation("", "servo: damped Gauss-Newton", _LAW, note=note, wide=True), weighted)
        asked = tuple(angle + "°" for angle in each(np.degrees(state.asked), 2))
        latex = rf"{_LAW}={column(len(asked))},\quad\mu={HOLE}"
        return (
            Equation("", "servo: damped Gauss-Newton", latex, (*asked, number(state.damping, 4)), wide=True),
            weighted,
        )

    def says(self, state: GaussNewtonState, status: ServoStatus) -> str:
        return said(state, status)


def _judged(state: GaussNewtonState, E: float) -> GaussNewtonState:
    """With more damping after a motion that raised E, else with less. E: px²."""
    if state.before is None:
        return state
    factor = FACTOR if E > state.before else 1 / FACTOR
    return replace(state, damping=float(np.clip(state.damping * factor, LEAST_DAMPING, MOST_DAMPING)))


def _damped(J: NDArray, e: NDArray, low: NDArray, high: NDArray, damping: float) -> NDArray:
    """(m,) rad; joints that stand at a limit and would go beyond are held."""
    gradient, normal = J.T @ e, J.T @ J
    free = ~(((low >= 0) & (gradient > 0)) | ((high <= 0) & (gradient < 0)))
    own = np.diag(normal) + 1e-12 * max(float(np.trace(normal)), 1e-300)
    damped = np.where(np.outer(free, free), normal + damping * np.diag(own), np.diag(own))
    return -np.linalg.solve(damped, np.where(free, gradient, 0.0))
