"""What a servo is: from what the learner saw to its next displacement, and what is said of that.

A law needs `start` and `step` alone (`MinimalServo`); `completed_servo` gives all else a default.
"""

from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import NDArray

from ..estimation.equations import Equation
from ..estimation.residuals import ResidualFunction
from .observation import Observation
from .status import ServoStatus

NEEDED = {"start": "start(seen)", "step": "step(state, seen, residuals)"}  # of a servo, by name


class ServoState(Protocol):
    """What a servo remembers, a frozen dataclass. probe: the motion that it asked for last is to learn from, not to
    arrive. It may have a `certificate` of the posture in which E is least, and what it takes to be `exchanged` of the
    demonstrator's points, pairs of indices: what it is told and asks from then on has them exchanged back.

    status: moving, or one of those `ServoStatus` at which a servo is at rest, as a member or as its word; converged is
    allowed by a certificate only.
    """

    @property
    def status(self) -> str: ...

    @property
    def probe(self) -> bool: ...


@dataclass(frozen=True)
class Moment:
    """What the equations of a law are shown for.

    E: px², NaN with too few points; seen: (N, 2) bool, own points in L, in R; displacement: (m,) rad, asked for since
    the start; moved: (m,) rad, the last motion as it was made; status: as of the `Snapshot`.
    """

    E: float
    seen: NDArray
    displacement: NDArray
    moved: NDArray
    status: ServoStatus


class Servo(Protocol):
    """A law, with all that anybody says about it. Its methods have no side effects.

    title: in dropdowns; assumes, limitations: a sentence each; slow: whether it makes hundreds of motions or more;
    predicts: whether it predicts its images from all that it has seen: it begins with what was `rehearsed`, if anything
    was, and knows a way on from where too few of its own points are in sight.
    stored: the dataclasses that its state is made of, nested ones too; they are stored by their fields, which are
    arrays, scalars, strings, tuples or such dataclasses. States are its own alone: they are passed back as they were.
    """

    @property
    def title(self) -> str: ...

    @property
    def assumes(self) -> str: ...

    @property
    def limitations(self) -> str: ...

    @property
    def slow(self) -> bool: ...

    @property
    def predicts(self) -> bool: ...

    @property
    def stored(self) -> tuple[type, ...]: ...

    def start(self, seen: Observation) -> Any:
        """The state before the first motion."""
        ...

    def step(self, state: Any, seen: Observation, residuals: ResidualFunction) -> tuple[Any, NDArray]:
        """The state after this look, and the motion to make: (m,) rad, all 0 to rest."""
        ...

    def retarget(self, state: Any, seen: Observation) -> Any:
        """The state after E has changed by itself, because the demonstrator moved, say."""
        ...

    def equations(self, state: Any | None, moment: Moment) -> tuple[Equation, ...]:
        """The law with the numbers of a moment. state: None before the first motion."""
        ...

    def says(self, state: Any, status: ServoStatus) -> str:
        """What it does, or why it rests, in a few words; "" if there is nothing to add to the status."""
        ...


class MinimalServo(Protocol):
    """What a servo of one's own must have. Other members of `Servo`, if it has them, replace the defaults.

    A state may be any object; its `status` and `probe`, if it has them, are those of a `ServoState`.
    """

    def start(self, seen: Observation) -> Any:
        """The state before the first motion."""
        ...

    def step(self, state: Any, seen: Observation, residuals: ResidualFunction) -> tuple[Any, NDArray]:
        """The state after this look, and the motion to make: (m,) rad, all 0 to rest."""
        ...


def completed_servo(given: MinimalServo) -> Servo:
    """A whole `Servo` as it is; of another, one with defaults. Raises TypeError for what lacks `start` or `step`."""
    if isinstance(given, type):
        raise TypeError(f"the servo {given.__name__} is a class; make one, {given.__name__}(…)")
    missing = [said for name, said in NEEDED.items() if not callable(getattr(given, name, None))]
    if missing:
        raise TypeError(f"the servo {given!r} has no {' and no '.join(missing)}: see viewimit.servo.MinimalServo")
    members = (name for name in vars(Servo) if not name.startswith("_"))
    return given if all(hasattr(given, name) for name in members) else _CompletedServo(given)  # type: ignore[return-value]


@dataclass(frozen=True)
class _CompletedServo:
    """law: with `start` and `step`, and whatever else it has."""

    law: Any

    @property
    def title(self) -> str:
        return getattr(self.law, "title", type(self.law).__name__)

    @property
    def assumes(self) -> str:
        return getattr(self.law, "assumes", "")

    @property
    def limitations(self) -> str:
        return getattr(self.law, "limitations", "")

    @property
    def slow(self) -> bool:
        return getattr(self.law, "slow", False)

    @property
    def predicts(self) -> bool:
        return getattr(self.law, "predicts", False)

    @property
    def stored(self) -> tuple[type, ...]:
        return getattr(self.law, "stored", ())

    def start(self, seen: Observation) -> Any:
        return self.law.start(seen)

    def step(self, state: Any, seen: Observation, residuals: ResidualFunction) -> tuple[Any, NDArray]:
        return self.law.step(state, seen, residuals)

    def retarget(self, state: Any, seen: Observation) -> Any:
        """Start afresh by default: what it remembers of E is of another demonstrator."""
        own = getattr(self.law, "retarget", None)
        return self.law.start(seen) if own is None else own(state, seen)

    def equations(self, state: Any | None, moment: Moment) -> tuple[Equation, ...]:
        own = getattr(self.law, "equations", None)
        return () if own is None else own(state, moment)

    def says(self, state: Any, status: ServoStatus) -> str:
        own = getattr(self.law, "says", None)
        return "" if own is None else own(state, status)
