"""What a person writes to put the loop on a robot and cameras of their own: an arm with four members, eyes with two."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.views import FourViews
from .self_calibration import Body
from .settings import Settings
from .snapshot import Snapshot


class Arm(Protocol):
    """An arm of m joints. Postures are (m,) rad, their joints always in the same order; that is all that is known."""

    @property
    def lower(self) -> NDArray:
        """(m,) rad: it is never sent below."""
        ...

    @property
    def upper(self) -> NDArray:
        """(m,) rad: it is never sent above."""
        ...

    @property
    def start(self) -> NDArray:
        """(m,) rad: where a session first sends it."""
        ...

    def move(self, theta: NDArray) -> NDArray:
        """Go to theta, (m,) rad, and return when at rest: (m,) rad, where it stands by its encoders, or theta if it has
        none. That is for viewers: the learner goes by where it sent the arm. A turn or more beyond the limits is
        refused, as what degrees would be."""
        ...


class Eyes(Protocol):
    """Two cameras, or one pair of pictures for each body, in which N points are found."""

    @property
    def noise_px(self) -> float:
        """Standard deviation of a coordinate beyond what can be measured with an arm at rest, px, from 0; mostly 0.
        Rounding to whole pixels, or to steps of any other grid, is found by itself."""
        ...

    def look(self) -> FourViews:
        """One picture of each view, taken now: N points matched by index, always the same N, px.
        `FourViews.from_images` makes it of four arrays (N, 2), NaN where a point is not seen. A point at (0, 0) or
        (-1, -1) px, or a hundred times as far from the others as those are from each other, and a body all of whose
        points are in one place or on one line, count as not seen."""
        ...


class Observer(Protocol):
    """How both bodies are looked at. m joints; N points, matched by index. anywhere: at any posture, not only where the
    arm stands."""

    anywhere: ClassVar[bool]

    def four_views(self, settings: Settings, theta: NDArray, theta_demo: NDArray, look: int) -> FourViews:
        """theta, theta_demo: (m,) rad, where the arms stand; look: which one it is, of the own body."""
        ...

    def image_noise_std(self, settings: Settings) -> float:
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
        """Where the demonstrator comes to rest that is round_to_degrees to stand there; NaN where nobody knows it."""
        ...

    def drive(self, settings: Settings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        """Where the arm at theta, last sent to `sent`, comes to rest once it is sent to `commanded`."""
        ...

    def revisit(self, settings: Settings, sent: NDArray, commanded: NDArray) -> None:
        """A moment of the past is the present again: the arm, last sent to `sent`, goes to where it was sent then."""
        ...

    def looks(self, theta_rest: NDArray) -> Observer:
        """theta_rest: the learner's start, where it measures the noise of its images."""
        ...


@dataclass(frozen=True)
class SessionStart:
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

    def __call__(self, settings: Settings, sent: NDArray | None) -> SessionStart:
        """sent: (m,) rad, where the learner was sent last, None if it never was. Raises ValueError, with all as it was,
        if the settings cannot be."""
        ...


ROUNDING_DEG = 1e-6
ROUNDING = 1e-9  # of a motion's length: what sums of motions are off by


def workspace(settings: Settings, lower: NDArray, upper: NDArray) -> tuple[NDArray, NDArray]:
    """The lowest and the highest angle to which each joint may be sent, (m,) rad each.

    lower, upper: (m,) rad, the arm's own limits, which are the workspace where the settings give none. Raises
    ValueError for a workspace of another number of joints, or one that is not inside these limits.
    """
    if settings.workspace_deg is None:
        return lower, upper
    if len(settings.workspace_deg) != len(lower):
        raise ValueError(
            f"workspace_deg needs a range for each of the {len(lower)} moving joints, got {len(settings.workspace_deg)}"
        )
    limits_deg = np.degrees([lower, upper]).T
    for k, ((low, high), (least, most)) in enumerate(zip(settings.workspace_deg, limits_deg), 1):
        if low < least - ROUNDING_DEG or high > most + ROUNDING_DEG:
            raise ValueError(
                f"workspace_deg: range {k}, {low:g}° … {high:g}°, is not inside its joint's limits "
                f"{least:g}° … {most:g}°"
            )
    low, high = np.radians(settings.workspace_deg).T
    return np.maximum(low, lower), np.minimum(high, upper)


def within(theta: NDArray, low: NDArray, high: NDArray, whose: str) -> NDArray:
    """A posture in the workspace [low, high], (m,) rad each. Raises ValueError for one that is outside."""
    for k, (angle, least, most) in enumerate(zip(*map(np.degrees, (theta, low, high))), 1):
        if not least - ROUNDING_DEG <= angle <= most + ROUNDING_DEG:
            raise ValueError(
                f"{whose} posture is outside the workspace: angle {k} is {angle:g}°, the range {least:g}° … {most:g}°"
            )
    return np.clip(theta, low, high)


def waypoints(sent: NDArray, target: NDArray, longest: float) -> list[NDArray]:
    """Postures on the straight way from `sent` to the target, (m,) rad each, which is the last of them.

    longest: rad, which no joint turns by more from one of them to the next; inf for the target alone.
    """
    way = target - sent
    motions = max(int(np.ceil(np.abs(way).max() / longest - ROUNDING)), 1)
    return [*(sent + way * (k / motions) for k in range(1, motions)), target]


def round_to_degrees(theta: NDArray, lower: NDArray, upper: NDArray) -> NDArray:
    """A posture within its limits, (m,) rad each, as settings that tell of it in degrees have it, to the last bit: with
    them a run is to repeat itself."""
    return np.clip(np.radians(degrees(theta)), lower, upper)


def degrees(theta: NDArray) -> tuple[float, ...]:
    """rad → degrees, without what conversion adds."""
    return tuple(float(angle) for angle in np.round(np.degrees(theta), 9))
