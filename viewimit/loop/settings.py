"""All that a run depends on: plain data, made to be kept and shared."""

import reprlib
import sys
import warnings
from collections.abc import Callable, Collection, Mapping
from functools import cache
from numbers import Integral, Real
from pathlib import PurePath
from typing import Annotated, Any, TypeVar, get_type_hints

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..estimation.transfers import TRANSFERS
from ..geometry.distortion import RadialDistortion
from ..sensing.files import file_name, is_text, parse_toml
from ..sensing.frames import MAX_LATENCY_LOOKS
from ..servo import SERVOS
from ..servo.observation import DEFAULT_MAX_RESTARTS
from ..simulation.disturbances import GAIN_ERROR, MISSING, NOISE, OUTLIERS, QUANTUM, SWAPPED, Disturbance
from ..simulation.robot import BodyPoint

RECTIFY = ("auto", "off")
CAMERAS = ("points", "rendered")  # projected points, or detected in rendered pictures of arms that have weight
USUAL_POINTS = 10
MOST_SEED = 2**32 - 1
MOST_FRAMES = 1_000
LEAST_STEP_DEG, MOST_STEP_DEG = 0.01, 360.0  # of a motion that is the longest
MOST_RESTARTS = 100
SAFETY = ("max_step_deg", "restarts", "workspace_deg")  # fields that say how far the learner's arm may go
OWN = "own"  # names the transfer or the servo that was given to a session as a function or an object
MOST_TURNS, ROUNDED = 2, 1e-7  # of angles that may be radians; how near whole degrees come to themselves as radians

Range = tuple[float, float]  # degrees
PAPER_FIELDS: Mapping[str, Any] = {"transfer": "epipolar", "servo": "broyden", "frames": 1}  # beside `Settings()`
D = TypeVar("D", bound=Disturbance)


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """With equal settings a run repeats itself to the last bit. Raises ValueError that names the field and its bounds.

    `Settings()` is the best method, exact for pinhole cameras; `Settings.paper()` is the paper's transfer, with
    Broyden's law and one image at each posture, which assumes cameras that are far away.

    demonstrator_deg, start_deg: of the scene's moving joints; None takes the scene's own. A session that begins with
    angles that are whole degrees only if they are read as radians gives a UserWarning.
    noise_px to quantum_deg: amounts of `DISTURBANCES`; delay: looks after a motion that still show the posture before
    it. The learner is told of none of them.
    transfer, servo: of TRANSFERS and SERVOS; OWN for the one that a session was given itself.
    frames: how many images are averaged at each posture, of both bodies.
    scene: a name, or the path of a scene file, or of a URDF, for which a scene is made, or all that a scene file says,
    as text that ends with a line; robot: a name or the path of a URDF, in place of the scene's; joints: which move, in
    place of the scene's.
    body_points: [link, x, y, z] each, as in a scene, in place of all of its layouts.
    undistort: (k1, k2) of the radial distortion that images are rid of, in place of the scene's.
    rectify: of RECTIFY; auto rectifies the images by what all matches of both pairs of views tell of their cameras, if
    that is needed.
    max_step_deg: no joint is sent farther in one motion: a longer one is made in several, with a look after each; None
    for motions of any length. workspace_deg: the lowest and the highest angle to which each moving joint may be sent,
    inside the arm's limits, which None takes. restarts: how often a servo may look for something lower far from where
    it has been; 0 keeps it from that.
    camera: of CAMERAS; points: layout of the scene, in place of which rendered pictures show the robot's markers; ten,
    if a scene has no such layout, stands for the one whose number of points is nearest.
    """

    scene: str = "panda"
    robot: str | None = None
    joints: tuple[int, ...] | None = None
    points: int = USUAL_POINTS
    body_points: tuple[BodyPoint, ...] | None = None
    demonstrator_deg: tuple[float, ...] | None = None
    start_deg: tuple[float, ...] | None = None
    transfer: str = "projective"
    servo: str = "trust-region"
    noise_px: Annotated[float, NOISE] = 0.0
    missing: Annotated[float, MISSING] = 0.0
    outliers: Annotated[float, OUTLIERS] = 0.0
    swapped: Annotated[float, SWAPPED] = 0.0
    frames: int = 25
    gain_error: Annotated[float, GAIN_ERROR] = 0.0
    quantum_deg: Annotated[float, QUANTUM] = 0.0
    delay: int = 0
    seed: int = 7
    undistort: tuple[float, float] | None = None
    rectify: str = "auto"
    camera: str = "points"
    max_step_deg: float | None = None
    restarts: int = DEFAULT_MAX_RESTARTS
    workspace_deg: tuple[Range, ...] | None = None

    @classmethod
    def best(cls, **changes: Any) -> "Settings":
        """The method that arrives, with these fields changed: what `Settings(**changes)` gives, by name.

        Transfer "projective", servo "trust-region", 25 frames (a second of video). Raises as `Settings`.
        """
        return cls(**changes)

    @classmethod
    def paper(cls, **changes: Any) -> "Settings":
        """The paper's method, with these fields changed: transfer "epipolar", servo "broyden", 1 frame.

        Raises as `Settings`.
        """
        return cls(**{**PAPER_FIELDS, **changes})

    @property
    def scene_called(self) -> str:
        """In a line, for people."""
        if not is_text(self.scene):
            return file_name(self.scene)
        fields = parse_toml(self.scene.encode())
        return " ".join(str(fields.get("title", fields.get("extends"))).split())

    @property
    def start_rad(self) -> NDArray:
        """(m,) rad. Raises ValueError for the scene's own start: the settings of a session say which that is."""
        return np.radians(given(self.start_deg))

    @property
    def max_step(self) -> float:
        """rad, a joint and motion; inf if a motion may be of any length."""
        return float("inf") if self.max_step_deg is None else float(np.radians(self.max_step_deg))

    def amounts(self, kind: type[D]) -> tuple[tuple[D, float], ...]:
        """Of every disturbance of a kind, those that are 0 too."""
        return tuple([(found, getattr(self, name)) for name, found in disturbances(kind).items()])

    def __post_init__(self) -> None:
        for name in (*_SEQUENCES, *_NUMBERS):
            value = getattr(self, name)
            if isinstance(value, (list, tuple, np.ndarray, np.generic)):
                msgspec.structs.force_setattr(self, name, _plain(value))
        for name in _TEXTS:
            value = getattr(self, name)
            if isinstance(value, PurePath):
                msgspec.structs.force_setattr(self, name, value := str(value))
            if not isinstance(value, _HINTS[name]):
                given = f"; give your own to Session(settings, {name}=…)" if name in ("transfer", "servo") else ""
                raise ValueError(f"{name} must be text, got {reprlib.repr(value)}{given}")
        for name, numbers in _NUMBERS.items():
            value = getattr(self, name)
            if value is None and name in _OPTIONAL:
                continue
            if not isinstance(value, numbers) or isinstance(value, bool):
                wanted = "a whole number" if numbers is Integral else "a number"
                raise ValueError(f"{name} must be {wanted}, got {value!r}")
        for name, wanted in _SEQUENCES.items():
            value = getattr(self, name)
            if not _is_of(_HINTS[name], value) or (name == "undistort" and not np.isfinite(value or 0).all()):
                raise ValueError(f"{name} must be {wanted}, got {reprlib.repr(value)}")
        if self.undistort is not None:
            try:
                RadialDistortion(*self.undistort)
            except ValueError as error:
                raise ValueError(f"undistort: {error}") from None
        for low, high in self.workspace_deg or ():
            if not (np.isfinite([low, high]).all() and low < high):
                raise ValueError(f"workspace_deg: {low:g}° … {high:g}° is no range: give the lower angle first")
        _require_choice("transfer", self.transfer, TRANSFERS)
        _require_choice("servo", self.servo, SERVOS)
        _require_choice("rectify", self.rectify, RECTIFY)
        _require_choice("camera", self.camera, CAMERAS)
        for name, disturbance in DISTURBANCES.items():
            _require_range(name, getattr(self, name), *disturbance.bounds)
        _require_range("delay", self.delay, 0, MAX_LATENCY_LOOKS)
        _require_range("frames", self.frames, 1, MOST_FRAMES)
        _require_range("seed", self.seed, 0, MOST_SEED)
        _require_range("restarts", self.restarts, 0, MOST_RESTARTS)
        if self.max_step_deg is not None:
            _require_range("max_step_deg", self.max_step_deg, LEAST_STEP_DEG, MOST_STEP_DEG)


def _is_of(kind, value) -> bool:
    try:
        msgspec.convert(value, kind)
    except msgspec.ValidationError:
        return False
    return True


def _plain(value):
    """Tuples and Python's numbers, which can be kept, compared and written."""
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    return tuple(map(_plain, value)) if isinstance(value, (list, tuple)) else value


_SEQUENCES = {
    "joints": "whole numbers",
    "body_points": "[link, x, y, z] each",
    "demonstrator_deg": "angles in degrees",
    "start_deg": "angles in degrees",
    "workspace_deg": "[lowest, highest] each, angles in degrees",
    "undistort": "two finite numbers k1, k2",
}
_HINTS = get_type_hints(Settings)
_OPTIONAL = [name for name, hint in _HINTS.items() if hint == float | None]
_NUMBERS = {name: {int: Integral, float: Real}[hint] for name, hint in _HINTS.items() if hint in (int, float)}
_NUMBERS |= dict.fromkeys(_OPTIONAL, Real)
_DEGREES = [name for name in _HINTS if name.endswith("_deg")]
_TEXTS = [name for name, hint in _HINTS.items() if hint in (str, str | None)]
DISTURBANCES: Mapping[str, Disturbance] = {  # by the field that says how much of it
    name: mark
    for name, hint in get_type_hints(Settings, include_extras=True).items()
    for mark in getattr(hint, "__metadata__", ())
    if isinstance(mark, Disturbance)
}


def warn_of_radians(settings: Settings) -> None:
    """Warn of fields in degrees whose values are whole degrees only if they are read as rad.

    The warning names the line outside this package that led here.
    """
    for name in _DEGREES:
        given = np.array(getattr(settings, name) or 0.0, float).ravel()
        converted = np.degrees(given[np.abs(given) > np.radians(0.5)])  # smaller ones may be 0, but for rounding errors
        whole = converted.round()
        if len(whole) and np.abs(whole).max() <= MOST_TURNS * 360 and np.abs(converted - whole).max() < ROUNDED:
            meant = ", ".join(f"{angle:g}" for angle in np.degrees(given).round())
            warnings.warn(
                f"{name} = {getattr(settings, name)} looks like radians; angles in settings are in degrees. "
                f"Did you mean {meant}?",
                stacklevel=_level_outside(),
            )


def _level_outside() -> int:
    """How far up the stack, for `warnings.warn` in the caller, the first line outside this package is."""
    frame, level, package = sys._getframe(1), 1, __name__.partition(".")[0]
    while frame.f_back is not None and frame.f_globals.get("__name__", "").partition(".")[0] == package:
        frame, level = frame.f_back, level + 1
    return level


def disturbances(kind: type[D]) -> dict[str, D]:
    """Those of one kind, by their field."""
    return _of_kind(kind)


@cache  # asked for several times a motion
def _found(kind: Any) -> dict[str, Any]:
    return {name: found for name, found in DISTURBANCES.items() if isinstance(found, kind)}


_of_kind: Callable[[Any], dict[str, Any]] = _found


def given(angles_deg: tuple[float, ...] | None) -> tuple[float, ...]:
    """A posture of settings. Raises ValueError for the scene's own: the settings of a session say which that is."""
    if angles_deg is None:
        raise ValueError("the posture is not given: the scene has one of its own")
    return angles_deg


def convert_fields(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Convert values as JSON has them to the types of these fields. Raises ValueError for another name or value."""
    try:
        whole = msgspec.convert(dict(fields), Settings)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from None
    return {name: getattr(whole, name) for name in fields}


def _require_choice(name: str, value: str, choices: Collection[str]) -> None:
    if value not in choices and not (value == OWN and name in ("transfer", "servo")):
        raise ValueError(f"no {name} {value!r}; there are {', '.join(choices)}")


def _require_range(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name} must be between {low:g} and {high:.10g}, got {value:.10g}")
