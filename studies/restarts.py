"""Restarts for laws that descend once: the same starts and the same rule for each.

A law that rests, makes no progress or sees too few points has ended a descent. If E is larger there than noise and
rounding explain, the arm goes to the next start, and the law begins again. After the last descent it returns to the
end with the smallest E. Every motion counts.
"""

from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from viewimit.estimation.residuals import ResidualFunction
from viewimit.servo import Observation, ServoMethod, ServoStatus

SMALL_E_NOISE = 25.0  # times the noise variance: E that is small
SMALL_E_PX2 = 0.01  # without noise: a residual of 0.07 px in each coordinate
CANDIDATES = 200  # random postures, of which the farthest from all others is a start
START_STREAM = 2  # of random numbers for the starts, beside that of the draw

Floats = NDArray[np.float64]


@runtime_checkable
class Restartable(Protocol):
    """A law that keeps what it has learned for another descent. Other laws begin as at first."""

    def restart(self, state: Any, observation: Observation) -> Any:
        """Return the state before a descent from here. state: returned by the last call of `step`."""
        ...


@dataclass(frozen=True)
class RestartState:
    """State of `Restarts`."""

    starts: tuple[Floats, ...]  # (m,) rad each: those that are left
    law: Any = None  # the state of the law
    begins: bool = True  # whether a descent begins here
    best: Floats | None = None  # (m,) rad: the end with the smallest E; None before the first end
    best_E: float = np.inf  # px²
    status: ServoStatus = ServoStatus.MOVING
    probe: bool = False


@dataclass(frozen=True)
class Restarts:
    """Lets a law begin again from far postures where E stays large."""

    method: ServoMethod  # of the law
    seed: tuple[int, ...]  # of the starts
    max_motions: int  # of the run: the last one is left for the return
    count: int = 4

    def start(self, observation: Observation) -> RestartState:
        """Return the state before the first motion."""
        rng = np.random.default_rng([*self.seed, START_STREAM])
        return RestartState(far_postures(observation, self.count, rng))

    def step(
        self, state: RestartState, observation: Observation, residuals: ResidualFunction
    ) -> tuple[RestartState, Floats]:
        """Return the next state and the motion, (m,) rad."""
        here, rest = observation.displacement, np.zeros_like(observation.displacement)
        if state.status.is_at_rest:  # the arm has returned
            return state, rest
        law, step, status = state.law, rest, ServoStatus.NO_PROGRESS
        E = observation.E if np.isfinite(observation.E) else np.inf
        if np.isfinite(E) or self.method.predicts:
            law = self._begun(state, observation) if state.begins else law
            law, step = self.method.step(law, observation, residuals)
            status = ServoStatus(getattr(law, "status", ServoStatus.MOVING))
        is_last = observation.motion >= self.max_motions - 1
        if step.any() and status != ServoStatus.NO_PROGRESS and not (is_last and E > state.best_E):
            return replace(state, law=law, begins=False, probe=bool(getattr(law, "probe", False))), step
        best, best_E = state.best, state.best_E
        if best is None or E < best_E:
            best, best_E = here, E
        state = replace(state, law=law, begins=True, best=best, best_E=best_E, probe=False)
        is_small = is_small_E(best_E, observation.noise_px)
        if state.starts and not is_small and not is_last:
            start, *others = state.starts
            return replace(state, starts=tuple(others)), start - here
        return replace(state, status=ServoStatus.SETTLED if is_small else ServoStatus.NO_PROGRESS), best - here

    def _begun(self, state: RestartState, observation: Observation) -> Any:
        """Return the law's state before a descent from here."""
        if state.law is not None and isinstance(self.method.servo, Restartable):
            return self.method.servo.restart(state.law, observation)
        return self.method.start(observation)


def is_small_E(E: float, noise_px: float) -> bool:
    """Whether noise or rounding may explain E [px²], so that nothing lower is searched for."""
    return E <= SMALL_E_PX2 + SMALL_E_NOISE * noise_px**2


def far_postures(observation: Observation, count: int, rng: np.random.Generator) -> tuple[Floats, ...]:
    """Return postures far from the present one and from each other, (m,) rad each."""
    chosen = [observation.displacement]
    for _ in range(count):
        candidates = rng.uniform(observation.lower, observation.upper, (CANDIDATES, len(observation.lower)))
        distance = np.abs(candidates[:, None] - np.array(chosen)).max(-1).min(1)
        chosen.append(candidates[distance.argmax()])
    return tuple(chosen[1:])
