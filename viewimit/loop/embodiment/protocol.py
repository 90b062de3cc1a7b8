"""What a session needs of a learner and its demonstrator, whatever is behind them: no scene, no world, no truth."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

from numpy.typing import ArrayLike, NDArray

from ...estimation.views import FourViews
from ..body_image import Body
from ..settings import Settings
from ..snapshot import Snapshot


class Looks(Protocol):
    """How both bodies are looked at. m joints; N points, matched by index. anywhere: at any posture, not only where the
    arm stands."""

    anywhere: ClassVar[bool]

    def four_views(self, settings: Settings, theta: NDArray, theta_demo: NDArray, look: int) -> FourViews:
        """theta, theta_demo: (m,) rad, where the arms stand; look: which one it is, of the own body."""
        ...

    def noise_at_rest(self, settings: Settings) -> float:
        """Standard deviation of a coordinate as four_views has it, px."""
        ...

    def wait(self, now: Snapshot, theta: NDArray) -> tuple[int, int | None]:
        """After a motion from `now` to theta, (m,) rad → how many looks were let pass until an image shows it, and
        what is known of the lag, in looks: None if the motion does not show."""
        ...


class Embodiment(Protocol):
    """The learner's arm, of m joints, and what shows it and the demonstrator. Postures are (m,) rad."""

    @property
    def lower(self) -> NDArray: ...

    @property
    def upper(self) -> NDArray: ...

    def require_posture(self, theta: ArrayLike, whose: str) -> NDArray:
        """theta, checked → a copy. Raises ValueError for a wrong count, NaN or beyond the limits."""
        ...

    def body(self, settings: Settings) -> Body:
        """What a rehearsal with these is a rehearsal of."""
        ...

    def demonstrator(self, settings: Settings) -> NDArray:
        """Its posture as set, checked; NaN where nobody knows it. Raises ValueError if it is out of limits."""
        ...

    def pose(self, theta_demo: NDArray) -> NDArray:
        """Where the demonstrator comes to rest that is told to stand there; NaN where nobody knows it."""
        ...

    def drive(self, settings: Settings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        """Where the arm at theta, last sent to `sent`, comes to rest once it is sent to `commanded`."""
        ...

    def revisit(self, settings: Settings, sent: NDArray, commanded: NDArray) -> None:
        """A moment of the past is the present again: the arm, last sent to `sent`, goes to where it was sent then."""
        ...

    def looks(self, theta_rest: NDArray) -> Looks:
        """theta_rest: the learner's start, where it measures the noise of its images."""
        ...


@dataclass(frozen=True)
class Beginning:
    """settings: with what they leave open; start: (m,) rad, where the learner was sent; theta, theta_demo: (m,) rad,
    where it and the demonstrator then stand, NaN where nobody knows; workspace: the lowest and the highest angles that
    the learner may be sent to, (m,) rad each."""

    settings: Settings
    embodiment: Embodiment
    start: NDArray
    theta: NDArray
    theta_demo: NDArray
    workspace: tuple[NDArray, NDArray]


class Opener(Protocol):
    """Makes what settings ask for, and brings both arms to where these have them."""

    def __call__(self, settings: Settings, sent: NDArray | None) -> Beginning:
        """sent: (m,) rad, where the learner was sent last, None if it never was. Raises ValueError, with all as it was,
        if the settings cannot be."""
        ...
