"""The paper's servo law, Section 4: E descends along a gradient learned from the learner's own motions.

ΔE = Ĵ u is fitted by recursive least squares with forgetting, and u = -K Ĵᵀ E, Eq. (13) with the transpose
that its print lacks (Ĵ is a row, u a column). K = 0.005 and ρ = 0.95, as printed in Section 5.3, are read in
degrees and px².

The paper gives no initial P, no bound of the step and no excitation: where Ĵ has found no slope, or the gain
has vanished with E, the arm stands still. `RETUNED` names values with which it mostly arrives. Nor does the
paper give a test of convergence, and E alone is none (its least value is not 0): this law never claims to be there.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..estimation.equations import HOLE, Equation, angles, column, each, number, row, short
from ..estimation.residuals import ResidualFunction
from .observation import Observation
from .servo import Moment
from .status import ServoStatus

_LAW = r"𝐮=-𝐊\,\hat{𝐉}^{\top}E"
PATIENCE, PROGRESS = 30, 0.99  # motions without E falling to this share of its least, after which it has stalled
TOGETHER = 16  # motions, whose dither is made at once


@dataclass(frozen=True)
class Constants:
    """gain: K = gain·I, degrees/px² per px²/degree; forgetting: ρ; jacobian: Ĵ_0, px²/degree, repeated for more
    joints; covariance: P_0 = covariance·I; max_step_deg, dither_deg: bound and excitation of a step."""

    gain: float
    forgetting: float
    jacobian: tuple[float, ...]
    covariance: float
    max_step_deg: float
    dither_deg: float


# Sec. 5.3 and Eq. (14); P_0 is not given there
PAPER = Constants(0.5e-2, 0.95, (-1.0, 1.0), covariance=1.0, max_step_deg=np.inf, dither_deg=0.0)
RETUNED = Constants(0.5, 0.95, (-1.0, 1.0), covariance=1e3, max_step_deg=2.0, dither_deg=0.2)


@dataclass(frozen=True)
class GradientState:
    """jacobian: (m,) px²/degree; covariance: (m, m); then what was seen last, and the progress."""

    jacobian: NDArray
    covariance: NDArray
    displacement: NDArray
    E: float
    best_E: float
    since_best: int = 0
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False


@dataclass(frozen=True)
class Gradient:
    """The law with its constants, and what is said of it with those. `seed` drives the dither only."""

    constants: Constants = PAPER
    seed: int = 0
    title: str = "Gradient (paper)"
    assumes: str = "That E is convex, and that a gradient learned on the way stays true."
    limitations: str = (
        "The input fades with E and the gradient goes stale: thousands of motions, mostly without arriving."
    )
    slow = True
    predicts = False
    stored = (GradientState,)

    def start(self, seen: Observation) -> GradientState:
        m = len(seen.displacement)
        c = self.constants
        return GradientState(np.resize(c.jacobian, m), c.covariance * np.eye(m), seen.displacement, seen.E, seen.E)

    def retarget(self, state: GradientState, seen: Observation) -> GradientState:
        """The jump of E is no effect of the last motion, and says nothing of progress."""
        return replace(
            state, displacement=seen.displacement, E=seen.E, best_E=np.inf, since_best=0, status=ServoStatus.MOVING
        )

    def step(
        self, state: GradientState, seen: Observation, residuals: ResidualFunction
    ) -> tuple[GradientState, NDArray]:
        moved = np.degrees(seen.displacement - state.displacement)
        jacobian, P = self._learn(state, moved, seen.E - state.E)
        u = self._bounded(-self.constants.gain * jacobian * seen.E)
        dither = self.constants.dither_deg * _excitation(self.seed, seen.motion, len(u))
        progress = seen.E < PROGRESS * state.best_E
        since_best = 0 if progress else state.since_best + 1
        best_E = seen.E if progress else state.best_E
        status = ServoStatus.NO_PROGRESS if since_best >= PATIENCE else ServoStatus.MOVING
        state = GradientState(jacobian, P, seen.displacement, seen.E, best_E, since_best, status)
        low, high = seen.lower - seen.displacement, seen.upper - seen.displacement
        inside = np.radians(u).clip(low, high)  # the dither comes after, to excite a joint that leans on its limit
        return state, (inside + np.radians(dither)).clip(low, high)

    def equations(self, state: GradientState | None, moment: Moment) -> tuple[Equation, ...]:
        c = self.constants
        if state is None:
            first = tuple(number(value) for value in c.jacobian)
            return (Equation("(13), (14)", "no motion yet", rf"{_LAW},\quad\hat{{𝐉}}_0={row(len(first))}", first),)
        u = -c.gain * state.jacobian * state.E
        m = len(u)
        note = "Ĵ learned from own motions, px² a degree; K fixed."
        if np.any(np.abs(np.degrees(moment.moved) - u) > 0.005):
            bound = f"bound {c.max_step_deg:g}°" if np.isfinite(c.max_step_deg) else "limits"
            note = f"Ĵ learned, K fixed. Made ({angles(moment.moved)}): {bound}{', dither' if c.dither_deg else ''}."
        latex = rf"{_LAW}=-{HOLE}\cdot{column(m)}\cdot{HOLE}={column(m)}"
        asked = (angle + "°" for angle in each(u, 2))
        numbers = (f"{c.gain:g}", *each(state.jacobian, 2), short(state.E), *asked)
        return (Equation("(13)", "this motion", latex, numbers, note, wide=True),)

    def says(self, state: GradientState, status: ServoStatus) -> str:
        return f"not lower for {state.since_best} motions" if status == ServoStatus.NO_PROGRESS else ""

    def _learn(self, state: GradientState, u: NDArray, dE: float) -> tuple[NDArray, NDArray]:
        """Weighted recursive least squares, ρ the forgetting factor."""
        J, P, rho = state.jacobian, state.covariance, self.constants.forgetting
        if not u.any():
            return J, P
        Pu = P @ u
        weight = rho + u @ Pu
        return J + (dE - J @ u) * Pu / weight, (P - Pu[:, None] * Pu / weight) / rho

    def _bounded(self, u: NDArray) -> NDArray:
        length = np.linalg.norm(u)
        return u * min(1.0, self.constants.max_step_deg / length) if length > 0 else u


def _excitation(seed: int, motion: int, count: int) -> NDArray:
    """(count,) standard normal, a stream of the seed for every motion; not to be written into."""
    return _excitations(seed, motion // TOGETHER, count)[motion % TOGETHER]


@lru_cache(256)  # many a session has the same seed: a class that begins with the same settings
def _excitations(seed: int, few: int, count: int) -> NDArray:
    """(TOGETHER, count), of the few-th so many motions: an array for each would take far more memory."""
    motions = range(few * TOGETHER, (few + 1) * TOGETHER)
    return np.array([np.random.default_rng([seed, motion]).standard_normal(count) for motion in motions])


RETUNED_LAW = Gradient(
    RETUNED,
    title="Gradient, retuned",
    assumes="The same, with a larger gain, bounded steps and a dither that keeps the gradient fresh.",
    limitations="Hundreds of motions; it never stands still, so it never says that it has arrived.",
)
