"""The paper's servo (Section 4): E descends along a gradient learned from the learner's own motions.

The gradient Ĵ of E is fitted to ΔE = Ĵ u by recursive least squares with forgetting ρ, and the motion is

    u = -K Ĵᵀ E,     Eq. (13), with the transpose that its print lacks (Ĵ is a row, u a column).

K = 0.005 and ρ = 0.95 of Section 5.3 are in degrees and px². The paper gives no initial covariance P, no bound of the
step and no excitation: the arm rests where Ĵ has found no slope, or the gain has vanished with E. `RETUNED` has
constants with which it mostly arrives. The paper gives no test of convergence either, and a small E is none, as its
minimum is not 0: this servo never claims to have converged.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import ResidualFunction
from .observation import Observation
from .status import ServoStatus

PATIENCE, PROGRESS = 30, 0.99  # motions after which E must have fallen to this share of its minimum
MOTIONS_PER_BLOCK = 16  # whose dither is drawn at once


@dataclass(frozen=True)
class GradientOptions:
    """Constants of the law, in degrees and px²."""

    gain: float  # K = gain·I, degrees/px² per px²/degree
    forgetting: float  # ρ
    jacobian: tuple[float, ...]  # Ĵ_0, px²/degree, repeated for more joints
    covariance: float  # P_0 = covariance·I
    max_step_deg: float  # bound of a motion's length
    dither_deg: float  # standard deviation of the excitation of a joint


# Sec. 5.3 and Eq. (14); P_0 is not given there
PAPER = GradientOptions(0.5e-2, 0.95, (-1.0, 1.0), covariance=1.0, max_step_deg=np.inf, dither_deg=0.0)
RETUNED = GradientOptions(0.5, 0.95, (-1.0, 1.0), covariance=1e3, max_step_deg=2.0, dither_deg=0.2)


@dataclass(frozen=True)
class GradientState:
    """State of `Gradient`."""

    jacobian: NDArray[np.float64]  # (m,) px²/degree
    covariance: NDArray[np.float64]  # (m, m)
    displacement: NDArray[np.float64]  # (m,) rad: at the last observation
    E: float  # px²: at the last observation
    best_E: float  # px²: the smallest E so far
    n_since_best: int = 0  # motions since then
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False


@dataclass(frozen=True)
class Gradient:
    """Gradient descent on E with a learned gradient."""

    options: GradientOptions = PAPER
    seed: int = 0  # of the dither

    def start(self, observation: Observation) -> GradientState:
        """Return the state before the first motion."""
        m, options = len(observation.displacement), self.options
        jacobian, covariance = np.resize(options.jacobian, m), options.covariance * np.eye(m)
        return GradientState(jacobian, covariance, observation.displacement, observation.E, observation.E)

    def retarget(self, state: GradientState, observation: Observation) -> GradientState:
        """Ignore the change of E, which no motion has caused, and forget the progress of E."""
        return replace(
            state,
            displacement=observation.displacement,
            E=observation.E,
            best_E=np.inf,
            n_since_best=0,
            status=ServoStatus.MOVING,
        )

    def step(
        self, state: GradientState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[GradientState, NDArray[np.float64]]:
        """Return the next state and the motion, (m,) rad."""
        here, E = observation.displacement, observation.E
        jacobian, P = self._update(state, np.degrees(here - state.displacement), E - state.E)
        u = self._bounded(-self.options.gain * jacobian * E)
        dither = self.options.dither_deg * _excitation(self.seed, observation.motion, len(u))
        has_progressed = E < PROGRESS * state.best_E
        n_since_best, best_E = (0, E) if has_progressed else (state.n_since_best + 1, state.best_E)
        status = ServoStatus.NO_PROGRESS if n_since_best >= PATIENCE else ServoStatus.MOVING
        state = GradientState(jacobian, P, here, E, best_E, n_since_best, status)
        low, high = observation.lower - here, observation.upper - here
        inside = np.radians(u).clip(low, high)  # the dither comes after, to excite a joint that is at its limit
        return state, (inside + np.radians(dither)).clip(low, high)

    def _update(
        self, state: GradientState, u: NDArray[np.float64], dE: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Weighted recursive least squares with forgetting ρ."""
        J, P, rho = state.jacobian, state.covariance, self.options.forgetting
        if not u.any():
            return J, P
        Pu = P @ u
        weight = rho + u @ Pu
        return J + (dE - J @ u) * Pu / weight, (P - Pu[:, None] * Pu / weight) / rho

    def _bounded(self, u: NDArray[np.float64]) -> NDArray[np.float64]:
        length = float(np.linalg.norm(u))
        return u * min(1.0, self.options.max_step_deg / length) if length > 0 else u


def _excitation(seed: int, motion: int, n_joints: int) -> NDArray[np.float64]:
    """(m,) standard normal numbers of a random stream for each motion; not to be written into."""
    return _excitation_block(seed, motion // MOTIONS_PER_BLOCK, n_joints)[motion % MOTIONS_PER_BLOCK]


@lru_cache(256)  # sessions of a class have the same seed; blocks, as one array per motion would take far more memory
def _excitation_block(seed: int, block: int, n_joints: int) -> NDArray[np.float64]:
    """(MOTIONS_PER_BLOCK, m)."""
    motions = range(block * MOTIONS_PER_BLOCK, (block + 1) * MOTIONS_PER_BLOCK)
    return np.array([np.random.default_rng([seed, motion]).standard_normal(n_joints) for motion in motions])
