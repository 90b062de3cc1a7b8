"""A learner with an arm and eyes of one's own: no scene, no world, and nobody who knows where the demonstrator is."""

import reprlib
from dataclasses import dataclass

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..body_image import Body
from ..settings import Settings
from .in_scene import degrees, told
from .interface import Arm, Eyes
from .motion_limits import ROUNDING_DEG, waypoints, within, workspace
from .own_looks import OwnLooks, look_with
from .protocol import Beginning

HAVE = (  # of the settings; all else is of scenes
    "transfer", "servo", "frames", "rectify", "start_deg", "seed", "max_step_deg", "restarts", "workspace_deg",
)  # fmt: skip
FOUND = ("scene", "points")  # set by what there is
MOST_TURNS = 4  # that a joint has to either side


@dataclass(frozen=True)
class Own:
    """See `protocol.Embodiment`. points: how many its eyes show."""

    arm: Arm
    eyes: Eyes
    name: str
    points: int
    lower: NDArray
    upper: NDArray

    def require_posture(self, theta: ArrayLike, whose: str) -> NDArray:
        return _within(theta, self.lower, self.upper, whose)

    def body(self, settings: Settings) -> Body:
        joints = tuple(range(1, len(self.lower) + 1))
        span_deg = tuple(round(float(span), 6) for span in np.degrees(self.upper - self.lower))
        return Body(self.name, joints, span_deg, self.points, "own", (0.0, 0.0))

    def demonstrator(self, settings: Settings) -> NDArray:
        _require(settings)
        return np.full_like(self.lower, np.nan)

    def pose(self, theta_demo: NDArray) -> NDArray:
        if np.isfinite(theta_demo).any():
            raise ValueError("the demonstrator stands where your eyes see it: move it, and session.look()")
        return theta_demo

    def drive(self, settings: Settings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        return self.move(sent, commanded, settings.max_step)

    def revisit(self, settings: Settings, sent: NDArray, commanded: NDArray) -> None:
        self.move(sent, commanded, settings.max_step)

    def looks(self, theta_rest: NDArray) -> OwnLooks:
        return OwnLooks(self.eyes, self.points)

    def move(self, sent: NDArray, theta: NDArray, longest: float) -> NDArray:
        """From where it was sent to theta, (m,) rad each, by motions in which no joint turns by more than `longest` rad
        → where it then stands. Raises ValueError as `_move`."""
        for waypoint in waypoints(sent, theta, longest):
            stands = self._move(waypoint)
        return stands

    def _move(self, theta: NDArray) -> NDArray:
        """theta: (m,) rad → where it then stands. Raises ValueError if the arm says that of no posture, or of one that
        is a turn or more beyond its limits, as degrees would be."""
        told = self.arm.move(theta.copy())
        stands = _numbers(told)
        if stands.shape != theta.shape or not np.isfinite(stands).all():
            raise ValueError(f"move() must return where the arm stands, {len(theta)} finite angles in rad, got {told}")
        if (np.maximum(self.lower - stands, stands - self.upper) >= 2 * np.pi).any():
            raise ValueError(f"move() must return where the arm stands, in rad: {told} is beyond its limits by a turn")
        return stands


class OwnOpener:
    """See `protocol.Opener`. name: of the arm, by which a rehearsal knows its own."""

    def __init__(self, arm: Arm, eyes: Eyes, name: str):
        _require_members("the arm", arm, Arm)
        _require_members("the eyes", eyes, Eyes)
        self._arm, self._eyes, self._name = arm, eyes, name
        self._lower, self._upper = _limits(arm)
        self._own: Own | None = None

    def __call__(self, settings: Settings, sent: NDArray | None) -> Beginning:
        _require(settings)
        low, high = workspace(settings, self._lower, self._upper)
        wanted = self._arm.start if settings.start_deg is None else np.radians(settings.start_deg)
        start = _within(wanted, self._lower, self._upper, "the start")
        start = told(within(start, low, high, "the start"), low, high)
        points = len(look_with(self._eyes).demo) if self._own is None else self._own.points
        _require_found(settings, {"scene": self._name, "points": points})
        own = Own(self._arm, self._eyes, self._name, points, self._lower, self._upper)
        standing, self._own = own.move(start if sent is None else sent, start, settings.max_step), own
        settings = msgspec.structs.replace(settings, scene=self._name, points=points, start_deg=degrees(start))
        return Beginning(settings, own, start, standing, own.demonstrator(settings), (low, high))


def _require_members(what: str, given: object, protocol: type) -> None:
    """Raises TypeError for what is none of its kind, with the members that are missing."""
    if isinstance(given, type):
        raise TypeError(f"{what}: {given.__name__} is a class; make one, {given.__name__}(…)")
    wanted = [name for name in vars(protocol) if not name.startswith("_")]
    if missing := [name for name in wanted if not hasattr(given, name)]:
        raise TypeError(
            f"{what}, {reprlib.repr(given)}, has no {' and no '.join(missing)}: viewimit.{protocol.__name__} says what "
            f"to write, {', '.join(wanted)}"
        )


def _numbers(values: ArrayLike) -> NDArray:
    """A copy, as floats; NaN of no shape for what is not numbers."""
    try:
        return np.array(values, float)
    except (TypeError, ValueError):
        return np.array(np.nan)


def _limits(arm: Arm) -> tuple[NDArray, NDArray]:
    lower, upper = _numbers(arm.lower), _numbers(arm.upper)
    if lower.ndim != 1 or lower.shape != upper.shape or len(lower) == 0 or not np.isfinite([lower, upper]).all():
        raise ValueError(f"the arm's limits must be finite angles in rad, one a joint, got {arm.lower} and {arm.upper}")
    if np.abs([lower, upper]).max() > MOST_TURNS * 2 * np.pi:
        raise ValueError(f"the arm's limits must be in rad: {arm.lower} and {arm.upper} are beyond {MOST_TURNS} turns")
    for k, (low, high) in enumerate(zip(np.degrees(lower), np.degrees(upper)), 1):
        if not low < high:
            raise ValueError(f"joint {k}: limits {low:g}° … {high:g}° are empty")
    return lower, upper


def _within(theta: ArrayLike, lower: NDArray, upper: NDArray, whose: str) -> NDArray:
    angles = _numbers(theta)
    if angles.shape != lower.shape:
        got = angles.size if angles.ndim == 1 else theta
        raise ValueError(f"{whose} posture needs {len(lower)} angles, got {got}")
    for k, (angle, low, high) in enumerate(zip(*map(np.degrees, (angles, lower, upper))), 1):
        if not low - ROUNDING_DEG <= angle <= high + ROUNDING_DEG:  # NaN fails too
            raise ValueError(f"{whose} joint {k} at {angle:g}° is outside its limits {low:g}° … {high:g}°")
    return np.clip(angles, lower, upper)


def _require(settings: Settings) -> None:
    """Raises ValueError for what only a simulated scene has."""
    for name in Settings.__struct_fields__:
        if name not in (*HAVE, *FOUND) and getattr(settings, name) != getattr(Settings(), name):
            raise ValueError(f"{name} is of a simulated scene; an arm and eyes of your own have {', '.join(HAVE)}")


def _require_found(settings: Settings, found: dict[str, object]) -> None:
    """Raises ValueError for what is asked to be other than it is."""
    for name, there in found.items():
        if getattr(settings, name) not in (there, getattr(Settings(), name)):
            raise ValueError(f"{name} is what there is, {there!r}: leave it out")
