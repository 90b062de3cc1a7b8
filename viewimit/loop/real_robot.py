"""A learner with an arm and eyes of your own. Its demonstrator may move by itself, and its posture is unknown."""

import reprlib
from numbers import Real
from typing import ClassVar

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from ..estimation.noise import rounding_std
from ..estimation.views import FourViews, dimensions
from ..geometry.affine import MIN_POINTS, image_unit
from ..geometry.arrays import Floats
from ..sensing.frames import (
    MAX_LATENCY_LOOKS,
    average_frames,
    estimate_latency,
    is_far_outlier,
    is_missing_value,
    noise_std,
)
from .arm_and_eyes import (
    TOLERANCE_DEG,
    Arm,
    Eyes,
    SessionStart,
    require_in_workspace,
    round_to_degrees,
    to_degrees,
    waypoints,
    workspace,
)
from .self_calibration import Body
from .settings import Settings
from .snapshot import Images, Snapshot

REST_LOOKS = 8  # pictures of the own body at rest that measure the noise
MIN_MOVE_PX = 0.01  # of a coordinate in images of typical size: a demonstrator that moves by less stands still
N_SIGMA_MOVED = 5.0  # standard deviations of the χ² test that says whether a demonstrator has moved
OUTLIER_FRACTION = 0.1  # of the points: those that moved most may be misplaced, and are left out of that test
KINDS = {"demo": "iuf", "own": "iuf", "visible": "b"}  # numpy's kinds of these arrays
SETTINGS_OF_ROBOT = (  # fields of Settings that a real robot has; all others are of scenes
    "transfer", "servo", "frames", "rectify", "start_deg", "seed", "max_step_deg", "workspace_deg",
    "matched",
)  # fmt: skip
SETTINGS_FOUND = ("scene", "points")  # fields that the arm's name and the eyes' points set
MAX_TURNS = 4  # of a joint, to either side


class RealObserver:
    """How both bodies are seen. Its images of the demonstrator stay until that moves, or shows more points."""

    sees_any_posture: ClassVar[bool] = False

    def __init__(self, eyes: Eyes, points: int):
        self._eyes, self._points = eyes, points
        self._demo: Images | None = None
        self._demo_look: Images | None = None  # the last one
        self._noise: tuple[float, float] | None = None  # see _noises_px

    def four_views(self, settings: Settings, theta: Floats, theta_demo: Floats, look: int) -> FourViews:
        """Take `Settings.frames` pictures of both bodies now, and average them."""
        merged, visible = average_frames(*self._pictures(settings.frames))
        self._demo_look = merged[:, :4], visible[:, :2]
        demo, demo_visible = self._demonstrator(self._demo_look, self.image_noise_std(settings))
        return FourViews(demo, merged[:, 4:], np.concatenate([demo_visible, visible[:, 2:]], -1))

    def demo(self, settings: Settings, theta_demo: Floats, look: int | None = None) -> Images:
        """What the last of `four_views` showed of the demonstrator, which stands still."""
        assert self._demo_look is not None
        return self._demo_look

    def fixed_noise_px(self) -> float:
        """Return the part of the noise that no averaging reduces: standard deviation [px]."""
        return float(np.hypot(self._noises_px()[1], _extra_noise_px(self._eyes)))

    def image_noise_std(self, settings: Settings) -> float:
        """Standard deviation of an averaged coordinate [px], measured in pictures of the own body at rest."""
        single, rounded = self._noises_px()
        return float(np.hypot(single / np.sqrt(settings.frames), rounded))

    def wait_for_motion(self, now: Snapshot, theta: Floats) -> tuple[int, int | None]:
        """Take pictures until one shows the motion from `now`. Later motions wait as long."""
        if now.lag is not None:
            for _ in range(now.lag):
                self._eyes.look()
            return now.lag, now.lag
        lag = estimate_latency((now.views.own, now.views.visible[:, 2:]), lambda k: self._own(), self._noises_px()[0])
        return MAX_LATENCY_LOOKS if lag is None else lag, lag

    def _demonstrator(self, now: Images, noise_px: float) -> Images:
        before = self._demo
        if before is None or _n_visible(now) > _n_visible(before) or _has_moved(before, now, noise_px):
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

    def _noises_px(self) -> tuple[float, float]:
        """Noise of a coordinate in one picture, and the rounding error that no averaging reduces (0 if noise does)."""
        if self._noise is None:
            points, visible = self._pictures(REST_LOOKS)
            measured, rounded = noise_std(points[..., 4:], visible[..., 2:]), rounding_std(points, visible)
            single = float(np.hypot(measured, _extra_noise_px(self._eyes)))
            self._noise = single, 0.0 if measured > rounded else rounded
        return self._noise


def look_with(eyes: Eyes, points: int | None = None) -> FourViews:
    """Look once, and check the answer. Raises ValueError for another type, or another number of points."""
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


def _extra_noise_px(eyes: Eyes) -> float:
    """Noise that the pictures do not show [px]. Raises ValueError for anything but a finite number from 0."""
    amount = eyes.noise_px
    if not isinstance(amount, Real) or not 0 <= amount < np.inf:
        raise ValueError(f"noise_px must be a finite number of pixels from 0, got {amount!r}")
    return float(amount)


def _require_images(views: FourViews) -> None:
    """Raise ValueError for another type than FourViews, and for arrays of another shape or kind."""
    expected = "look() must return FourViews of N points, such as FourViews.from_images makes of (N, 2) each"
    if not isinstance(views, FourViews):
        raise ValueError(expected)
    for name, kinds in KINDS.items():
        array = getattr(views, name)
        if not isinstance(array, np.ndarray):
            raise ValueError(f"{expected}: its {name} is a {type(array).__name__}")
        if array.shape != (*views.demo.shape[:1], 4) or array.dtype.kind not in kinds:
            raise ValueError(f"{expected}: its {name} is of shape {array.shape}, {array.dtype}")


def _without_lost(views: FourViews) -> FourViews:
    """Mark points as invisible that a tracker has lost, such as (0, 0), and bodies with all points on one line.

    E of such points would be nearly 0 wherever the arm is.
    """
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


def _has_moved(before: Images, after: Images, noise_px: float) -> bool:
    """Whether the points visible in both have moved more than noise explains (χ² test of the sum of squares)."""
    both = (before[1] & after[1]).all(-1)
    square = np.sort(((after[0] - before[0])[both] ** 2).sum(-1))[: int((1 - OUTLIER_FRACTION) * both.sum())]
    coordinates = 4 * len(square)
    variance = max((MIN_MOVE_PX * image_unit(after[0][both])) ** 2, 2 * noise_px**2)
    return bool(square.sum() > variance * (coordinates + N_SIGMA_MOVED * np.sqrt(2 * coordinates)))


def _n_visible(images: Images) -> int:
    return int(images[1].all(-1).sum())


class RealRobot:
    """The learner's arm, of m joints, and its view of the demonstrator. Postures are (m,) rad.

    name: of the arm, for calibrations. It opens itself: called, it brings the arm to the first posture of a session.
    """

    def __init__(self, arm: Arm, eyes: Eyes, name: str):
        _require_members("the arm", arm, Arm)
        _require_members("the eyes", eyes, Eyes)
        self.arm, self.eyes, self.name = arm, eyes, name
        self.points: int | None = None  # that the eyes find, once they have looked
        self.lower, self.upper = _limits(arm)

    def __call__(self, settings: Settings, sent: Floats | None) -> tuple["RealRobot", SessionStart]:
        """sent: (m,) rad, where the arm was last sent; None if it never was.

        Raises ValueError, with everything as it was, for impossible settings.
        """
        _require(settings)
        low, high = workspace(settings, self.lower, self.upper)
        asked = self.arm.start if settings.start_deg is None else np.radians(settings.start_deg)
        start = _within(asked, self.lower, self.upper, "the start")
        start = round_to_degrees(require_in_workspace(start, low, high, "the start"), low, high)
        points = len(look_with(self.eyes).demo) if self.points is None else self.points
        for name, there in {"scene": self.name, "points": points}.items():
            if getattr(settings, name) not in (there, getattr(Settings(), name)):
                raise ValueError(f"{name} is what there is, {there!r}: leave it out")
        theta, self.points = self.move(start if sent is None else sent, start, settings.max_step), points
        settings = msgspec.structs.replace(settings, scene=self.name, points=points, start_deg=to_degrees(start))
        return self, SessionStart(settings, start, theta, self.demonstrator(settings), (low, high))

    def require_posture(self, theta: ArrayLike, whose: str) -> Floats:
        """Return a copy of theta, (m,) rad. Raises ValueError for a wrong count, NaN or limits exceeded."""
        return _within(theta, self.lower, self.upper, whose)

    def body(self, settings: Settings) -> Body:
        """What a calibration would hold for. The eyes have looked before."""
        assert self.points is not None
        joints = tuple(range(1, len(self.lower) + 1))
        span_deg = tuple(round(float(span), 6) for span in np.degrees(self.upper - self.lower))
        return Body(self.name, joints, span_deg, self.points, "own", (0.0, 0.0))

    def demonstrator(self, settings: Settings) -> Floats:
        """(m,) NaN: its posture is unknown. Raises ValueError for settings that only a simulated scene has."""
        _require(settings)
        return np.full_like(self.lower, np.nan)

    def settle_demonstrator(self, theta_demo: Floats) -> Floats:
        """Return theta_demo, (m,) NaN. Raises ValueError for a posture: it moves by itself."""
        if np.isfinite(theta_demo).any():
            raise ValueError("the demonstrator stands where your eyes see it: move it, and session.look()")
        return theta_demo

    def drive(self, settings: Settings, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        """Move the arm. Return where it comes to rest, (m,) rad. Raises ValueError as `move`.

        settings: give the longest step; sent, commanded: (m,) rad, where it was last sent, and is sent now.
        """
        return self.move(sent, commanded, settings.max_step)

    def revisit(self, settings: Settings, sent: Floats, commanded: Floats) -> None:
        """Bring the arm back to where a past snapshot had sent it, `commanded`; arguments and errors as of `drive`."""
        self.move(sent, commanded, settings.max_step)

    def observer(self, theta_rest: Floats) -> RealObserver:
        """An observer of both bodies; theta_rest: (m,) rad, where the arm is at rest. The eyes have looked before."""
        assert self.points is not None
        return RealObserver(self.eyes, self.points)

    def move(self, sent: Floats, theta: Floats, max_step: float) -> Floats:
        """Move from where the arm was sent to theta, (m,) rad each, in steps of at most max_step rad a joint.

        Returns where the arm is then, (m,) rad. Raises ValueError if the arm answers with anything but such a posture,
        or with one a turn or more beyond its limits, which may be degrees.
        """
        for waypoint in waypoints(sent, theta, max_step):
            answer = self.arm.move(waypoint.copy())
            reached = _numbers(answer)
            if reached.shape != theta.shape or not np.isfinite(reached).all():
                expected = f"{len(theta)} finite angles in rad"
                raise ValueError(f"move() must return where the arm stands, {expected}, got {answer}")
            if (np.maximum(self.lower - reached, reached - self.upper) >= 2 * np.pi).any():
                raise ValueError(
                    f"move() must return where the arm stands, in rad: {answer} is beyond its limits by a turn"
                )
        return reached


def _require_members(what: str, given: object, protocol: type) -> None:
    """Raise TypeError for an object that lacks members of the protocol, and for a class that is no object yet."""
    if isinstance(given, type):
        raise TypeError(f"{what}: {given.__name__} is a class; make one, {given.__name__}(…)")
    members = [name for name in vars(protocol) if not name.startswith("_")]
    if missing := [name for name in members if not hasattr(given, name)]:
        raise TypeError(
            f"{what}, {reprlib.repr(given)}, has no {' and no '.join(missing)}: viewimit.{protocol.__name__} says what "
            f"to write, {', '.join(members)}"
        )


def _numbers(values: ArrayLike) -> Floats:
    """A copy as floats; a NaN without axes for anything but numbers."""
    try:
        return np.array(values, float)
    except (TypeError, ValueError):
        return np.array(np.nan)


def _limits(arm: Arm) -> tuple[Floats, Floats]:
    lower, upper = _numbers(arm.lower), _numbers(arm.upper)
    if lower.ndim != 1 or lower.shape != upper.shape or len(lower) == 0 or not np.isfinite([lower, upper]).all():
        raise ValueError(f"the arm's limits must be finite angles in rad, one a joint, got {arm.lower} and {arm.upper}")
    if np.abs([lower, upper]).max() > MAX_TURNS * 2 * np.pi:
        raise ValueError(f"the arm's limits must be in rad: {arm.lower} and {arm.upper} are beyond {MAX_TURNS} turns")
    for k, (low, high) in enumerate(zip(np.degrees(lower), np.degrees(upper)), 1):
        if not low < high:
            raise ValueError(f"joint {k}: limits {low:g}° … {high:g}° are empty")
    return lower, upper


def _within(theta: ArrayLike, lower: Floats, upper: Floats, whose: str) -> Floats:
    angles = _numbers(theta)
    if angles.shape != lower.shape:
        got = angles.size if angles.ndim == 1 else theta
        raise ValueError(f"{whose} posture needs {len(lower)} angles, got {got}")
    for k, (angle, low, high) in enumerate(zip(*map(np.degrees, (angles, lower, upper))), 1):
        if not low - TOLERANCE_DEG <= angle <= high + TOLERANCE_DEG:  # NaN fails too
            raise ValueError(f"{whose} joint {k} at {angle:g}° is outside its limits {low:g}° … {high:g}°")
    return np.clip(angles, lower, upper)


def _require(settings: Settings) -> None:
    """Raise ValueError for settings that only a simulated scene has."""
    for name in Settings.__struct_fields__:
        if name not in (*SETTINGS_OF_ROBOT, *SETTINGS_FOUND) and getattr(settings, name) != getattr(Settings(), name):
            raise ValueError(
                f"{name} is of a simulated scene; an arm and eyes of your own have {', '.join(SETTINGS_OF_ROBOT)}"
            )
