"""What a servo is: from what the learner saw to its next displacement, and what is said of that."""

from dataclasses import dataclass
from typing import Any, Protocol

from numpy.typing import NDArray

from ..equations import Equation
from .observation import Conflict, Observation


class ServoState(Protocol):
    """What a servo remembers, a frozen dataclass. probe: the motion that it asked for last is to learn from, not to
    arrive. It may have a `certificate` of the posture in which E is least, and what it takes to be `exchanged` of the
    demonstrator's points, pairs of indices: what it is told and asks from then on has them exchanged back.

    status: moving; converged, which only a certificate allows; rests, where the next motion would be too small to be
    worth it, without evidence; untold, as converged but for joints that nothing tells; stalled, for want of a way on.
    """

    @property
    def status(self) -> str: ...

    @property
    def probe(self) -> bool: ...


@dataclass(frozen=True)
class Moment:
    """What the equations of a law are shown for.

    E: px², NaN with too few points; seen: (N, 2) bool, own points in L, in R; displacement: (m,) rad, asked for since
    the start; moved: (m,) rad, the last motion as it was made; status: as of a `ServoState`, ready or stopped.
    """

    E: float
    seen: NDArray
    displacement: NDArray
    moved: NDArray
    status: str


class Servo(Protocol):
    """A law, with all that anybody says about it. Its methods have no side effects.

    title: in dropdowns; assumes, fails: a sentence each; slow: whether it makes hundreds of motions or more;
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
    def fails(self) -> str: ...

    @property
    def slow(self) -> bool: ...

    @property
    def predicts(self) -> bool: ...

    @property
    def stored(self) -> tuple[type, ...]: ...

    def start(self, seen: Observation) -> Any:
        """The state before the first motion."""
        ...

    def step(self, state: Any, seen: Observation, conflict: Conflict) -> tuple[Any, NDArray]:
        """The state after this look, and the motion to make: (m,) rad, all 0 to rest."""
        ...

    def retarget(self, state: Any, seen: Observation) -> Any:
        """The state after E has changed by itself, because the demonstrator moved, say."""
        ...

    def equations(self, state: Any | None, moment: Moment) -> tuple[Equation, ...]:
        """The law with the numbers of a moment. state: None before the first motion."""
        ...

    def says(self, state: Any, status: str) -> str:
        """What it does, or why it rests, in a few words; "" if there is nothing to add to the status."""
        ...
