"""Servos on a recursively estimated image Jacobian: a Kalman filter, and damped Gauss-Newton.

Both move each joint once, as a probe. Then they bring the residual e towards zero, with J = Ĵ_e, the derivative of e by
the displacement. It follows from the image Jacobian Ĵ (`RecursiveJacobian`) and the transfer:

    Kalman        u = -g J⁺ e,                       Ĵ by a Kalman filter,                        g = 1
    GaussNewton   u = -(JᵀJ + μ D)⁻¹ Jᵀ e,           Ĵ by least squares with forgetting λ = 0.5   D = diag(JᵀJ)

Neither tests whether it has arrived: they settle where the next motion would be too short, and never claim convergence.
In the cited papers e is the distance of own points from fixed targets; here the targets depend on the own images too.

References
----------
Qian and Su, "Online estimation of image Jacobian matrix by Kalman-Bucy filter", ICRA 2002.
Piepmeier, McMurray and Lipkin, "Uncalibrated dynamic visual servoing", IEEE Trans. Robotics and Automation 20(1), 2004,
whose term for a moving target is 0 here.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import ResidualFunction
from .image_jacobian import MIN_STEP_RAD, RecursiveJacobian
from .observation import Observation, probe_motion
from .status import ServoStatus

MAX_STEP_RAD = np.radians(25.0)  # of a joint, in one motion
PATIENCE, PROGRESS = 30, 0.99  # motions after which E must have fallen to this share of its minimum

KALMAN_GAIN = 1.0  # g
JACOBIAN_STD, DRIFT_STD = 500.0, 150.0  # px/rad: of the first Jacobian, and of its change from motion to motion
LINEARITY_PX = 1.0  # standard deviation of an image from the prediction of its Jacobian, without noise

FORGETTING = 0.5  # λ, per motion
INITIAL_VARIANCE = 1e6  # of the rows of the first Jacobian, which is unknown
DAMPING, MIN_DAMPING, MAX_DAMPING, DAMPING_FACTOR = 1e-2, 1e-4, 1e2, 10.0  # μ

_Law = Callable[
    [NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]
]  # J, e, lowest and highest step → (m,) rad
_State = TypeVar("_State", bound="RecursiveState")


@dataclass(frozen=True)
class RecursiveState:
    """State of a servo on a recursive Jacobian."""

    model: RecursiveJacobian
    requested: NDArray[np.float64]  # (m,) rad: the law's motion, before bounds and limits
    joints_to_probe: tuple[int, ...]
    best_E: float  # px²: the smallest E so far
    n_since_best: int = 0  # motions since then
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False

    @property
    def has_patience(self) -> bool:
        """Whether E has fallen recently."""
        return self.n_since_best < PATIENCE


@dataclass(frozen=True)
class GaussNewtonState(RecursiveState):
    """State of `GaussNewton`."""

    damping: float = DAMPING  # μ
    previous_E: float | None = None  # px²: before the last motion; None if that is not to be judged


class Kalman:
    """Proportional control on the residual; a Kalman filter estimates the image Jacobian as a random walk."""

    def start(self, observation: Observation) -> RecursiveState:
        """Return the state before the first motion."""
        return _initial(RecursiveState, observation, JACOBIAN_STD**2)

    def retarget(self, state: RecursiveState, observation: Observation) -> RecursiveState:
        """Forget the progress of E, and keep the image Jacobian."""
        return replace(state, best_E=np.inf, n_since_best=0, status=ServoStatus.MOVING)

    def step(
        self, state: RecursiveState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[RecursiveState, NDArray[np.float64]]:
        """Return the next state and the motion, (m,) rad."""
        r = LINEARITY_PX**2 + 2 * observation.noise_px**2  # of a difference of two images
        state = _with_update(state, state.model.update(observation, r, DRIFT_STD**2), observation.E)
        return _next_motion(state, observation, residuals, _proportional_step)


class GaussNewton:
    """Damped Gauss-Newton steps; least squares with forgetting estimate the image Jacobian.

    A motion after which E is larger raises the damping, another one lowers it (Levenberg 1944, Marquardt 1963). The arm
    goes on from where it is, as a step back would be another motion.
    """

    def start(self, observation: Observation) -> GaussNewtonState:
        """Return the state before the first motion."""
        return _initial(GaussNewtonState, observation, INITIAL_VARIANCE)

    def retarget(self, state: GaussNewtonState, observation: Observation) -> GaussNewtonState:
        """Forget the progress of E and the damping, and keep the image Jacobian."""
        return replace(
            state, best_E=np.inf, damping=DAMPING, previous_E=None, n_since_best=0, status=ServoStatus.MOVING
        )

    def step(
        self, state: GaussNewtonState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[GaussNewtonState, NDArray[np.float64]]:
        """Return the next state and the motion, (m,) rad."""
        model = state.model.update(observation, FORGETTING, forgetting=FORGETTING)
        state = _with_update(_with_damping(state, observation.E), model, observation.E)
        state, step = _next_motion(state, observation, residuals, partial(_damped_step, damping=state.damping))
        if state.status == ServoStatus.NO_PROGRESS:
            return state, step
        return replace(state, previous_E=None if state.probe else observation.E), step


def _initial(kind: type[_State], observation: Observation, variance: float) -> _State:
    """State before the first motion. variance: of the rows of the first Jacobian."""
    m = len(observation.displacement)
    return kind(RecursiveJacobian.start(observation, variance), np.zeros(m), tuple(range(m)), observation.E)


def _with_update(state: _State, model: RecursiveJacobian, E: float) -> _State:
    """State after the last motion, which led to E px²."""
    has_progressed = PROGRESS * state.best_E > E
    n_since_best, best_E = (0, E) if has_progressed else (state.n_since_best + 1, state.best_E)
    return replace(state, model=model, best_E=best_E, n_since_best=n_since_best, status=ServoStatus.MOVING, probe=False)


def _next_motion(
    state: _State, observation: Observation, residuals: ResidualFunction, law: _Law
) -> tuple[_State, NDArray[np.float64]]:
    """A probe, or the law's motion within bounds and limits; no motion where it settles or makes no progress."""
    if state.joints_to_probe:
        joint, *rest = state.joints_to_probe
        return replace(state, joints_to_probe=tuple(rest), probe=True), probe_motion(joint, observation)
    e, J = state.model.linearise(residuals)
    if not np.isfinite(e).all() or not state.has_patience:
        return replace(state, status=ServoStatus.NO_PROGRESS), np.zeros_like(observation.displacement)
    low, high = observation.lower - observation.displacement, observation.upper - observation.displacement
    requested = law(J, e, low, high)
    step = np.clip(requested * min(1.0, MAX_STEP_RAD / max(np.abs(requested).max(), 1e-12)), low, high)
    if np.abs(step).max() < MIN_STEP_RAD:
        return replace(state, requested=requested, status=ServoStatus.SETTLED), np.zeros_like(step)
    return replace(state, requested=requested), step


def _proportional_step(
    J: NDArray[np.float64], e: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64]
) -> NDArray[np.float64]:
    """-g J⁺e, (m,) rad; joints at a limit that would leave it are held, and the others solved for again."""
    free: NDArray[np.bool_] = np.ones(len(low), bool)
    while True:
        step = np.zeros(len(low))
        step[free] = -KALMAN_GAIN * np.linalg.lstsq(J[:, free], e, rcond=None)[0]
        leaves = ((low >= 0) & (step < 0)) | ((high <= 0) & (step > 0))
        if not leaves.any():
            return step
        free &= ~leaves


def _with_damping(state: GaussNewtonState, E: float) -> GaussNewtonState:
    """Raise the damping if the last motion has raised E, px², and lower it otherwise."""
    if state.previous_E is None:
        return state
    factor = DAMPING_FACTOR if E > state.previous_E else 1 / DAMPING_FACTOR
    return replace(state, damping=float(np.clip(state.damping * factor, MIN_DAMPING, MAX_DAMPING)))


def _damped_step(
    J: NDArray[np.float64], e: NDArray[np.float64], low: NDArray[np.float64], high: NDArray[np.float64], damping: float
) -> NDArray[np.float64]:
    """-(JᵀJ + μ D)⁻¹ Jᵀe, (m,) rad; joints at a limit that would leave it are held."""
    gradient, normal = J.T @ e, J.T @ J
    free = ~(((low >= 0) & (gradient > 0)) | ((high <= 0) & (gradient < 0)))
    diagonal = np.diag(normal) + 1e-12 * max(float(np.trace(normal)), 1e-300)
    damped = np.where(np.outer(free, free), normal + damping * np.diag(diagonal), np.diag(diagonal))
    return -np.linalg.solve(damped, np.where(free, gradient, 0.0))
