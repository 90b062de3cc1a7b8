"""What a session reads from a servo's state, which may be any object, and how it asks the servo for a motion."""

import warnings
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..estimation.residuals import ResidualFunction
from ..estimation.views import Pairs
from ..servo import Certificate, Misfit, Naming, Observation, ServoMethod, ServoStatus
from ..servo.observation import Visit
from .settings import level_outside

SERVO_STATUSES = (ServoStatus.MOVING, *(status for status in ServoStatus if status.is_at_rest))


@dataclass(frozen=True)
class StateAttributes:
    """The attributes of `ServoState` that a state has, and defaults for those that it lacks."""

    status: str | None = None
    probe: bool = False
    certificate: Certificate | None = None
    naming: Naming | None = None
    exchanged: Pairs = ()
    calibration: tuple[Visit, ...] = ()
    misfit: Misfit | None = None

    @classmethod
    def of(cls, servo_state: Any) -> "StateAttributes":
        """Read a servo's state; None: the servo was not asked yet."""
        return cls(**{name: getattr(servo_state, name) for name in _DECLARED if hasattr(servo_state, name)})

    @property
    def names(self) -> NDArray[np.int_] | None:
        """(N,): the demonstrator's point of each own point, -1 of points left out; None before they are found."""
        return self.naming.used if self.naming is not None and self.naming.accepted else None

    def status_or(self, usual: ServoStatus) -> ServoStatus:
        """Return the status, or the usual one for a state without.

        Raise ValueError for an unknown status, and for a claim of convergence without a certificate.
        """
        if self.status is None:
            return usual
        try:
            found = ServoStatus(self.status)
        except ValueError:
            found = None
        if found not in SERVO_STATUSES:
            raise ValueError(f"a servo's status must be one of {', '.join(SERVO_STATUSES)}, got {self.status!r}")
        if found.is_claim and self.certificate is None:
            raise ValueError("a servo's status is 'converged', but its state has no certificate: report 'settled'")
        return found

    @property
    def status_at_rest(self) -> ServoStatus:
        """The status of a servo that asks for no motion."""
        status = self.status_or(ServoStatus.SETTLED)
        return ServoStatus.NO_PROGRESS if status == ServoStatus.MOVING else status


_DECLARED = [field.name for field in fields(StateAttributes)]


def ask_servo(
    servo: ServoMethod, servo_state: Any, observation: Observation, residuals: ResidualFunction
) -> tuple[Any, NDArray[np.float64]]:
    """Ask a servo for its next motion, and check the answer.

    Parameters
    ----------
    servo : ServoMethod
        Control law.
    servo_state : any
        Its last state; None: it starts.
    observation : Observation
        What the learner sees now.
    residuals : ResidualFunction
        Residuals of images that the servo predicts.

    Returns
    -------
    servo_state : any
        Its next state.
    displacement : (m,) array
        The motion [rad].

    Raises
    ------
    TypeError, ValueError
        For an answer that is no state and m finite angles, and for None as the next of a state that is not None.
    """
    state = servo.start(observation) if servo_state is None else servo_state
    answer = servo.step(state, observation, residuals)
    if not (isinstance(answer, tuple) and len(answer) == 2):
        raise TypeError(f"the servo {servo.title!r} must return its state and its motion, (m,) rad, got {answer!r}")
    if answer[0] is None and state is not None:
        raise TypeError(f"the servo {servo.title!r} returned None as its next state; only stateless servos may")
    state, displacement = answer[0], np.asarray(answer[1], float)
    if displacement.shape != observation.displacement.shape or not np.isfinite(displacement).all():
        expected = f"{len(observation.displacement)} finite angles in rad"
        raise ValueError(f"the servo {servo.title!r} must return its state and {expected}, got {displacement}")
    target = observation.displacement + displacement
    if (np.abs(target - target.clip(observation.lower, observation.upper)) >= 2 * np.pi).any():
        asked = f"the servo {servo.title!r} asks for a motion of {displacement} rad"
        warnings.warn(f"{asked}, a turn or more beyond the limits: are these degrees?", stacklevel=level_outside())
    return state, displacement
