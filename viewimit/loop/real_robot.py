"""How eyes of one's own are used: so many pictures at each posture, and a demonstrator that may move by itself."""

import reprlib
from dataclasses import dataclass
from numbers import Real
from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..estimation.noise import rounding_std
from ..estimation.views import FourViews, dimensions
from ..geometry.affine import MIN_POINTS, image_unit
from ..sensing.frames import (
    MAX_LATENCY_LOOKS,
    average_frames,
    estimate_latency,
    is_far_outlier,
    is_missing_value,
    noise_std,
)
from .embodiment import ROUNDING_DEG, Arm, Eyes, SessionStart, degrees, round_to_degrees, waypoints, within, workspace
from .self_calibration import Body
from .settings import Settings
from .snapshot import Snapshot

REST_LOOKS = 8  # pictures of the own body at rest, from which the learner knows their noise
LEAST_PX, SURELY = 0.01, 5.0  # a coordinate of typical images; standard deviations: a demonstrator has moved by more
WRONG = 0.1  # of the points: those that have moved the most may be found at wrong places
KINDS = {"demo": "iuf", "own": "iuf", "visible": "b"}  # of NumPy's; a share is no bool, and would be taken for seen

Images = tuple[NDArray, NDArray]  # of one body in a pair of views: points (N, 4) px, visible (N, 2) bool


class RealObserver:
    """See `protocol.Observer`. The demonstrator's images stay the same ones until it moves, or more of it is seen."""

    anywhere: ClassVar[bool] = False

    def __init__(self, eyes: Eyes, points: int):
        self._eyes, self._points = eyes, points
        self._demo: Images | None = None
        self._noise: tuple[float, float] | None = None  # see _noises

    def four_views(self, settings: Settings, theta: NDArray, theta_demo: NDArray, look: int) -> FourViews:
        """Whatever is to be seen now."""
        merged, visible = average_frames(*self._pictures(settings.frames))
        demo, demo_visible = self._demonstrator((merged[:, :4], visible[:, :2]), self.image_noise_std(settings))
        return FourViews(demo, merged[:, 4:], np.concatenate([demo_visible, visible[:, 2:]], -1))

    def image_noise_std(self, settings: Settings) -> float:
        single, rounded = self._noises()
        return float(np.hypot(single / np.sqrt(settings.frames), rounded))

    def wait(self, now: Snapshot, theta: NDArray) -> tuple[int, int | None]:
        """Observer are pictures here."""
        if now.lag is not None:
            for _ in range(now.lag):
                self._eyes.look()
            return now.lag, now.lag
        lag = estimate_latency((now.views.own, now.views.visible[:, 2:]), lambda k: self._own(), self._noises()[0])
        return MAX_LATENCY_LOOKS if lag is None else lag, lag

    def _demonstrator(self, now: Images, noise_px: float) -> Images:
        before = self._demo
        if before is None or _seen(now) > _seen(before) or _elsewhere(before, now, noise_px):
            self._demo = before = now
        return before

    def _own(self) -> Images:
        views = look_with(self._eyes, self._points)
        return views.own, views.visible[:, 2:]

    def _pictures(self, count: int) -> Images:
        """(count, N, 8) px and (count, N, 4) bool, in l, r, L, R."""
        seen = [look_with(self._eyes, self._points) for _ in range(count)]
        points = np.array([np.concatenate([views.demo, views.own], -1) for views in seen])
        return points, np.array([views.visible for views in seen])

    def _noises(self) -> tuple[float, float]:
        """Of a single picture, px, and what rounding adds however many are averaged: none if noise mixes the steps."""
        if self._noise is None:
            points, visible = self._pictures(REST_LOOKS)
            measured, rounded = noise_std(points[..., 4:], visible[..., 2:]), rounding_std(points, visible)
            single = float(np.hypot(measured, _unmeasured(self._eyes)))
            self._noise = single, 0.0 if measured > rounded else rounded
        return self._noise


def look_with(eyes: Eyes, points: int | None = None) -> FourViews:
    """One look. Raises ValueError if it is no look, or not at so many points."""
    views = eyes.look()
    _require_images(views)
    if points is not None and len(views.demo) != points:
        raise ValueError(
            f"look() gave {len(views.demo)} points, at first {points}: they are matched by index, so give "
            "all of them always, NaN where one is not seen"
        )
    shown = np.concatenate([views.demo, views.own], -1)[np.repeat(views.visible, 2, -1)]
    if not np.isfinite(shown).all():
        raise ValueError("look() gave a point as visible whose coordinates are not finite")
    return _without_lost(views)


def _unmeasured(eyes: Eyes) -> float:
    """Noise that their pictures do not show, px. Raises ValueError for what is no amount."""
    amount = eyes.noise_px
    if not isinstance(amount, Real) or not 0 <= amount < np.inf:
        raise ValueError(f"noise_px must be a finite number of pixels from 0, got {amount!r}")
    return float(amount)


def _require_images(views: FourViews) -> None:
    """Raises ValueError for what is no FourViews, or holds arrays of another shape or kind than it should."""
    wanted = "look() must return FourViews of N points, such as FourViews.from_images makes of (N, 2) each"
    if not isinstance(views, FourViews):
        raise ValueError(wanted)
    for name, kinds in KINDS.items():
        array = getattr(views, name)
        if not isinstance(array, np.ndarray):
            raise ValueError(f"{wanted}: its {name} is a {type(array).__name__}")
        if array.shape != (*views.demo.shape[:1], 4) or array.dtype.kind not in kinds:
            raise ValueError(f"{wanted}: its {name} is of shape {array.shape}, {array.dtype}")


def _without_lost(views: FourViews) -> FourViews:
    """Without what a tracker has lost and says so, as with zeros, and without a body all of whose points are in one
    place or on one line. E of such points is nearly 0 wherever the arm is."""
    both, visible = np.concatenate([views.demo, views.own], -1).reshape(-1, 4, 2), views.visible
    visible = visible & ~is_missing_value(both)
    for image, seen in zip(both.swapaxes(0, 1), visible.T):
        if seen.any():
            seen[seen] = ~is_far_outlier(image[seen])
    for k, images in ((slice(0, 2), views.demo), (slice(2, 4), views.own)):
        seen = images[visible[:, k].all(-1)]
        if len(seen) >= MIN_POINTS and dimensions(seen) < 2:
            visible[:, k] = False
    return FourViews(views.demo, views.own, visible)


def _elsewhere(before: Images, after: Images, noise_px: float) -> bool:
    """Whether the points seen in both have moved by more than noise moves them, as a whole (χ² test)."""
    both = (before[1] & after[1]).all(-1)
    square = np.sort(((after[0] - before[0])[both] ** 2).sum(-1))[: int((1 - WRONG) * both.sum())]
    coordinates = 4 * len(square)
    variance = max((LEAST_PX * image_unit(after[0][both])) ** 2, 2 * noise_px**2)
    return bool(square.sum() > variance * (coordinates + SURELY * np.sqrt(2 * coordinates)))


def _seen(images: Images) -> int:
    return int(images[1].all(-1).sum())


HAVE = (  # of the settings; all else is of scenes
    "transfer", "servo", "frames", "rectify", "start_deg", "seed", "max_step_deg", "restarts", "workspace_deg",
)  # fmt: skip
FOUND = ("scene", "points")  # set by what there is
MOST_TURNS = 4  # that a joint has to either side


@dataclass(frozen=True)
class RealRobot:
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

    def looks(self, theta_rest: NDArray) -> RealObserver:
        return RealObserver(self.eyes, self.points)

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


class RealRobotOpener:
    """See `protocol.Opener`. name: of the arm, by which a rehearsal knows its own."""

    def __init__(self, arm: Arm, eyes: Eyes, name: str):
        _require_members("the arm", arm, Arm)
        _require_members("the eyes", eyes, Eyes)
        self._arm, self._eyes, self._name = arm, eyes, name
        self._lower, self._upper = _limits(arm)
        self._own: RealRobot | None = None

    def __call__(self, settings: Settings, sent: NDArray | None) -> SessionStart:
        _require(settings)
        low, high = workspace(settings, self._lower, self._upper)
        wanted = self._arm.start if settings.start_deg is None else np.radians(settings.start_deg)
        start = _within(wanted, self._lower, self._upper, "the start")
        start = round_to_degrees(within(start, low, high, "the start"), low, high)
        points = len(look_with(self._eyes).demo) if self._own is None else self._own.points
        _require_found(settings, {"scene": self._name, "points": points})
        own = RealRobot(self._arm, self._eyes, self._name, points, self._lower, self._upper)
        standing, self._own = own.move(start if sent is None else sent, start, settings.max_step), own
        settings = msgspec.structs.replace(settings, scene=self._name, points=points, start_deg=degrees(start))
        return SessionStart(settings, own, start, standing, own.demonstrator(settings), (low, high))


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
