"""What a servo is: two methods, from what the learner sees to its next motion.

A servo sees image points and its own displacements, never a posture, a body or a camera. Its methods have no side
effects. Everything that is said about a servo is in `registry`.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..estimation.equations import Equation
from ..estimation.residuals import ResidualFunction
from ..estimation.views import Pairs
from .certificate import Certificate
from .misfit import Misfit
from .naming import Naming
from .observation import Observation, Visit
from .status import ServoStatus

SIGNATURES = {"start": "start(observation)", "step": "step(state, observation, residuals)"}  # of a servo, by name
SERVO_STATUSES = (ServoStatus.MOVING, *(status for status in ServoStatus if status.is_at_rest))


@runtime_checkable
class Servo(Protocol):
    """A servo: an object with `start` and `step`.

    States are passed back unchanged, and may be any objects. If a state has the attributes of `ServoState`, they are
    used; keys of a dictionary are not. A servo without memory may use None: `start` is then called before each step.
    A servo may also have the method of `Retargetable`.
    """

    def start(self, observation: Observation) -> Any:
        """Return the state before the first motion.

        Parameters
        ----------
        observation : Observation
            What the learner sees at its start.

        Returns
        -------
        any
            State that is passed to `step`.
        """
        ...

    def step(
        self, state: Any, observation: Observation, residuals: ResidualFunction
    ) -> tuple[Any, NDArray[np.float64]]:
        """Return the next state and the motion to make.

        Parameters
        ----------
        state : any
            Returned by `start`, or by the last call of `step`.
        observation : Observation
            What the learner sees now.
        residuals : ResidualFunction
            Computes the residuals of images that the servo predicts; that needs no motion.

        Returns
        -------
        state : any
            The next state; None only if `start` returns None.
        displacement : (m,) array
            Motion of each joint [rad]; all 0 to rest. It is shortened to the joint limits. A motion that is not 0
            counts as one, even if the limits leave nothing of it.
        """
        ...


@runtime_checkable
class Retargetable(Protocol):
    """A servo that goes on from its state after E has changed by itself. Other servos start again."""

    def retarget(self, state: Any, observation: Observation) -> Any:
        """Return the state after E has changed by itself, as when the demonstrator moved.

        Parameters
        ----------
        state : any
            Returned by the last call of `start` or `step`.
        observation : Observation
            What the learner sees now.

        Returns
        -------
        any
            State that is passed to `step`.
        """
        ...


@dataclass(frozen=True)
class ServoState:
    """What a session reads from a servo's state: attributes of these names. A state may lack any of them.

    Attributes
    ----------
    status : str or None
        Why the servo rests, as a `ServoStatus` or its value: converged, settled, unobservable or no-progress. It is
        moving with a motion that is not 0. A servo that rests and still reports moving has found no way to a smaller
        E: no-progress. Without this attribute a servo that rests has settled. Converged needs `certificate`.
    probe : bool
        Whether the motion is made to learn from it, and not to arrive.
    certificate : Certificate or None
        Evidence of convergence at the posture where E is smallest. None: then it cannot be claimed.
    naming : Naming or None
        Names of the demonstrator's points, if they came without. Only an accepted naming is used. Once it is, the
        session asks the servo again, with residuals of named points.
    exchanged : tuple of pairs of int
        Pairs of the demonstrator's points that the servo takes for swapped; the session swaps them back.
    calibration : tuple of Visit
        Visits of an earlier calibration that the servo uses.
    misfit : Misfit or None
        Why the demonstrator's images fit no posture of the own body. None: no sign of that.
    """

    status: str | None = None
    probe: bool = False
    certificate: Certificate | None = None
    naming: Naming | None = None
    exchanged: Pairs = ()
    calibration: tuple[Visit, ...] = ()
    misfit: Misfit | None = None

    @classmethod
    def of(cls, state: Any) -> "ServoState":
        """Read a servo's state; None: the servo was not asked yet."""
        return cls(**{field.name: getattr(state, field.name) for field in fields(cls) if hasattr(state, field.name)})

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
        if self.status not in SERVO_STATUSES:
            raise ValueError(f"a servo's status must be one of {', '.join(SERVO_STATUSES)}, got {self.status!r}")
        found = ServoStatus(self.status)
        if found.is_claim and self.certificate is None:
            raise ValueError("a servo's status is 'converged', but its state has no certificate: report 'settled'")
        return found

    @property
    def status_at_rest(self) -> ServoStatus:
        """The status of a servo that asks for no motion."""
        status = self.status_or(ServoStatus.SETTLED)
        return ServoStatus.NO_PROGRESS if status == ServoStatus.MOVING else status


@dataclass(frozen=True)
class LastMotion:
    """What the equations of a servo are shown for."""

    E: float  # px²; NaN with too few points
    seen: NDArray[np.bool_]  # (N, 2): own points visible in L, in R
    displacement: NDArray[np.float64]  # (m,) rad: commanded since the start
    moved: NDArray[np.float64]  # (m,) rad: the last motion as it was made
    status: ServoStatus


@dataclass(kw_only=True)
class ServoMethod:
    """A servo with everything that is said about it."""

    servo: Servo
    title: str = ""  # in dropdowns; by default the name of its class
    assumes: str = ""  # one sentence: when it works
    limitations: str = ""  # one sentence: where it fails
    slow: bool = False  # whether it makes hundreds of motions
    predicts: bool = False  # whether it predicts its images: it can use a calibration, and moves on where few are seen
    names_points: bool = False  # whether it finds the names of a demonstrator's points that come without
    rigid: bool = False  # whether it needs a body of rigid links: it claims nothing of images that show none
    mirror_columns: bool = False  # whether residuals get three more columns where images fit only a mirror image
    equations: Callable[[Any, LastMotion], tuple[Equation, ...]] = lambda state, motion: ()  # state: None at the start
    describe_status: Callable[[Any, ServoStatus], str] = lambda state, status: ""  # what it does, or why it rests

    def __post_init__(self) -> None:
        self.title = self.title or type(self.servo).__name__

    def start(self, observation: Observation) -> Any:
        """Return the state before the first motion."""
        return self.servo.start(observation)

    def step(
        self, state: Any, observation: Observation, residuals: ResidualFunction
    ) -> tuple[Any, NDArray[np.float64]]:
        """Return the next state and the motion to make, (m,) rad."""
        return self.servo.step(state, observation, residuals)

    def retarget(self, state: Any, observation: Observation) -> Any:
        """Return the state after E has changed by itself; by default start again."""
        if isinstance(self.servo, Retargetable):
            return self.servo.retarget(state, observation)
        return self.servo.start(observation)


def servo_method(given: ServoMethod | Servo) -> ServoMethod:
    """Return a `ServoMethod` unchanged, or make one of an object with `start` and `step`.

    Raises
    ------
    TypeError
        For a class, or an object without these methods.
    """
    if isinstance(given, ServoMethod):
        return given
    if isinstance(given, type):
        raise TypeError(f"the servo {given.__name__} is a class; make one, {given.__name__}(…)")
    missing = [said for name, said in SIGNATURES.items() if not callable(getattr(given, name, None))]
    if missing:
        raise TypeError(f"the servo {given!r} has no {' and no '.join(missing)}: see viewimit.servo.Servo")
    return ServoMethod(servo=given)
