"""What you write for a real robot, `Arm` and `Eyes`, and the limits that hold for every arm."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ..estimation.views import FourViews
from ..geometry.arrays import Floats
from .settings import Settings
from .snapshot import Limits

TOLERANCE_DEG = 1e-6  # beyond a limit
TOLERANCE_WAYPOINTS = 1e-9  # in numbers of motions: the rounding error of their sum


class Arm(Protocol):
    """An arm of m joints, for `Session.of`. Postures are (m,) rad, with the joints always in the same order."""

    @property
    def lower(self) -> Floats:
        """(m,) rad: no joint is sent below."""
        ...

    @property
    def upper(self) -> Floats:
        """(m,) rad: no joint is sent above."""
        ...

    @property
    def start(self) -> Floats:
        """(m,) rad: where a session first sends the arm."""
        ...

    def move(self, theta: Floats) -> Floats:
        """Move the arm, and return when it is at rest.

        Parameters
        ----------
        theta : (m,) array
            Posture to go to [rad].

        Returns
        -------
        (m,) array
            Where the arm is by its encoders [rad], or theta if it has none. Only viewers use it: the learner relies on
            where it sent the arm. Angles a turn or more beyond the limits are refused, as they may be degrees.
        """
        ...


class Eyes(Protocol):
    """A stereo head of two cameras, in whose images N points are found. For `Session.of`.

    The head is rigid: the cameras keep their positions and directions to each other in all looks, and towards both
    bodies. As a whole it may turn from one body to the other. The loop relies on this: points whose left and right
    images contradict the one epipolar geometry of the head are rejected as outliers. So cameras that turn towards
    each body separately lose most points, and the run ends with too few (`RunResult.message` says so).
    """

    @property
    def noise_px(self) -> float:
        """Noise of an image coordinate that does not show with an arm at rest: standard deviation [px], mostly 0.

        Rounding to whole pixels, or to any other grid, is detected without it.
        """
        ...

    def look(self) -> FourViews:
        """Take one picture of each view now, and find N points in them.

        Called `Settings.frames` times for each look, by default 25, and at the start a few times more to measure the
        noise. The demonstrator's points of a look are kept until it moves, or until more of them are visible: also
        while it is hidden.

        Returns
        -------
        FourViews
            Always the same N points, matched by index [px]. With `Settings(matched=False)` the demonstrator's are in
            any order, the same in [l] and [r] and at every look; NaN fills up the body that shows fewer points.
            `FourViews.from_images` makes it of four arrays (N, 2), with NaN where a point is not visible. The following
            count as not visible: a point at (0, 0), (-1, -1) px or the like, one a hundred times as far from the others
            as those are from each other, and all points of a body if they are in one place or on one line.
        """
        ...


@dataclass(frozen=True)
class SessionStart:
    """A session at its beginning."""

    settings: Settings  # complete
    start: Floats  # (m,) rad, where the learner was sent
    theta: Floats  # (m,) rad, where it is
    theta_demo: Floats  # (m,) rad, where the demonstrator is; NaN where it is unknown
    workspace: Limits  # of the learner


def workspace(settings: Settings, lower: Floats, upper: Floats) -> Limits:
    """The lowest and highest angle to which each joint may be sent: those of the settings, or else the arm's limits.

    lower, upper: (m,) rad, the arm's own limits. Raises ValueError for a workspace of another number of joints, or one
    that is not inside these limits.
    """
    if settings.workspace_deg is None:
        return lower, upper
    if len(settings.workspace_deg) != len(lower):
        raise ValueError(
            f"workspace_deg needs a range for each of the {len(lower)} moving joints, got {len(settings.workspace_deg)}"
        )
    limits_deg = np.degrees([lower, upper]).T
    for k, ((low, high), (lowest, highest)) in enumerate(zip(settings.workspace_deg, limits_deg), 1):
        if low < lowest - TOLERANCE_DEG or high > highest + TOLERANCE_DEG:
            raise ValueError(
                f"workspace_deg: range {k}, {low:g}° … {high:g}°, is not inside its joint's limits "
                f"{lowest:g}° … {highest:g}°"
            )
    low, high = np.radians(settings.workspace_deg).T
    return np.maximum(low, lower), np.minimum(high, upper)


def require_in_workspace(theta: Floats, low: Floats, high: Floats, whose: str) -> Floats:
    """Return a posture, (m,) rad. Raise ValueError if it is outside the workspace [low, high], (m,) rad each."""
    for k, (angle, lowest, highest) in enumerate(zip(*map(np.degrees, (theta, low, high))), 1):
        if not lowest - TOLERANCE_DEG <= angle <= highest + TOLERANCE_DEG:
            raise ValueError(
                f"{whose} posture is outside the workspace: angle {k} is {angle:g}°, "
                f"the range {lowest:g}° … {highest:g}°"
            )
    return np.clip(theta, low, high)


def waypoints(sent: Floats, target: Floats, max_step: float) -> list[Floats]:
    """Postures on the straight line from `sent` to the target, (m,) rad each. The last one is the target.

    max_step: rad, the longest motion of a joint between two of them; inf for the target alone.
    """
    way = target - sent
    motions = max(int(np.ceil(np.abs(way).max() / max_step - TOLERANCE_WAYPOINTS)), 1)
    return [*(sent + way * (k / motions) for k in range(1, motions)), target]


def round_to_degrees(theta: Floats, lower: Floats, upper: Floats) -> Floats:
    """A posture, (m,) rad, exactly as settings reproduce it that hold it in degrees, clipped to its limits."""
    return np.clip(np.radians(to_degrees(theta)), lower, upper)


def to_degrees(theta: Floats) -> tuple[float, ...]:
    """Convert rad to degrees, without the rounding error of the conversion."""
    return tuple(float(angle) for angle in np.round(np.degrees(theta), 9))
