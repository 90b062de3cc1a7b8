"""The settings of a run: plain data, made to be kept and shared."""

import reprlib
import sys
import warnings
from collections.abc import Callable, Collection, Mapping
from dataclasses import KW_ONLY, dataclass
from functools import cache
from pathlib import PurePath
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_type_hints

import msgspec
import numpy as np
from numpy.typing import NDArray

from ..estimation.transfers import TRANSFERS
from ..geometry.distortion import RadialDistortion
from ..sensing.files import file_name, is_text, parse_toml
from ..sensing.frames import MAX_LATENCY_LOOKS
from ..servo import SERVOS
from ..simulation.arms import DYNAMICS
from ..simulation.disturbances import GAIN_ERROR, MISSING, NOISE, OUTLIERS, QUANTUM, SWAPPED, Disturbance
from ..simulation.robot import BodyPoint

RECTIFY = ("auto", "off")
SENSORS = ("projected", "rendered")
USUAL_POINTS = 10
USUAL_LAYOUT = f"{USUAL_POINTS}, or the scene's nearest to that"
MAX_SEED = 2**32 - 1
SAFETY = ("max_step_deg", "workspace_deg")  # fields that say how far the learner's arm may go
OWN = "own"  # names the transfer or the servo that was given to a session as a function or an object
MAX_TURNS, TOLERANCE_DEG = 2, 1e-7  # of angles that may be radians: their size, and their distance to whole degrees

Range = tuple[float, float]  # degrees
PAPER_FIELDS: Mapping[str, Any] = {"transfer": "epipolar", "servo": "broyden", "frames": 1}  # beside `Settings()`
D = TypeVar("D", bound=Disturbance)


class UnknownMethod(ValueError):
    """No servo or transfer of this name is in this process."""


@dataclass(frozen=True)
class Setting:
    """What a field of `Settings` means: for help on the command line, the documentation's table and the page."""

    description: str  # a phrase without a full stop
    _: KW_ONLY
    option: str = ""  # on the command line, without dashes, if it is not the field's name
    default: str = ""  # the default in words, where the default value does not say it
    unit: str = ""  # of the value, such as deg: the placeholder on the command line
    bounds: tuple[float, float] | None = None  # lowest and highest value
    choices: Collection[str] = ()  # the names that are allowed
    label: str = ""  # on the page, where a panel has a widget for it
    slider_range: tuple[float, float, float] = (0, 1, 1)  # lowest, highest, step


class _KnownFields(msgspec.StructMeta):
    """Lets `Settings(…)` say which fields there are, if it is given another."""

    if not TYPE_CHECKING:

        def __call__(cls, *args, **fields):
            for name in fields:
                if name not in cls.__struct_fields__:
                    raise TypeError(f"no setting {name!r}; the settings are {', '.join(cls.__struct_fields__)}")
            return super().__call__(*args, **fields)


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, metaclass=_KnownFields):
    """What a run depends on. With equal settings a run repeats itself to the last bit.

    `Settings()` is the best method, exact for pinhole cameras. `Settings.paper()` is the paper's transfer, with
    Broyden's law and one image at each posture; it assumes cameras that are far away.

    Raises
    ------
    ValueError
        For a value that is out of bounds or of another type. The message names the field.

    Notes
    -----
    The learner does not know the disturbances (`noise_px` to `encoder_step_deg`) or the `delay`. A session that begins
    with angles that would be whole degrees if they were radians gives a UserWarning.
    """

    scene: Annotated[str, Setting("path of a .toml or .urdf file, a scene file's text, or a name")] = "panda"
    robot: Annotated[str | None, Setting("path of a .urdf file, or a name", default="the scene's")] = None
    joints: Annotated[
        tuple[int, ...] | None, Setting("joints that move, numbered from 1", unit="N,N", default="the scene's")
    ] = None
    points: Annotated[
        int,
        Setting(
            "layout of the scene's body points, by their number; rendered pictures show markers instead",
            unit="N",
            option="n-points",
            default=USUAL_LAYOUT,
        ),
    ] = USUAL_POINTS
    body_points: Annotated[
        tuple[BodyPoint, ...] | None,
        Setting("body points [link, x, y, z] m, which replace the scene's layouts", default="the scene's"),
    ] = None
    demonstrator_deg: Annotated[
        tuple[float, ...] | None,
        Setting(
            "posture of the demonstrator's moving joints", unit="deg,deg", option="demonstrator", default="the scene's"
        ),
    ] = None
    start_deg: Annotated[
        tuple[float, ...] | None,
        Setting("first posture of the learner's moving joints", unit="deg,deg", option="start", default="the scene's"),
    ] = None
    transfer: Annotated[
        str, Setting("estimator of the demonstrator's points in the learner's images", choices=TRANSFERS)
    ] = "projective"
    servo: Annotated[str, Setting("control law that moves the learner's arm", choices=SERVOS)] = "likelihood"
    noise_px: Annotated[float, NOISE] = 0.0
    missing: Annotated[float, MISSING] = 0.0
    outliers: Annotated[float, OUTLIERS] = 0.0
    swapped: Annotated[float, SWAPPED] = 0.0
    matched: Annotated[
        bool,
        Setting(
            "whether the demonstrator's points come with the names of the learner's own; without, the "
            "learner finds them",
            option="unmatched",
        ),
    ] = True
    frames: Annotated[
        int,
        Setting(
            "images averaged at each posture; outliers among them are dropped",
            unit="N",
            bounds=(1, 1_000),
            label="Pictures averaged",
            slider_range=(1, 50, 1),
        ),
    ] = 25
    gain_error: Annotated[float, GAIN_ERROR] = 0.0
    encoder_step_deg: Annotated[float, QUANTUM] = 0.0
    delay: Annotated[
        int, Setting("looks after a motion that still show the posture before it", bounds=(0, MAX_LATENCY_LOOKS))
    ] = 0
    seed: Annotated[int, Setting("seed of the disturbances", unit="N", bounds=(0, MAX_SEED), label="Seed")] = 7
    undistort: Annotated[
        tuple[float, float] | None,
        Setting(
            "radial distortion k1, k2 (OpenCV's model) to remove from the images first",
            unit="k1,k2",
            default="the scene's",
        ),
    ] = None
    rectify: Annotated[
        str,
        Setting(
            "rectify the images where their matches show that the cameras are not parallel, or never", choices=RECTIFY
        ),
    ] = "auto"
    sensor: Annotated[
        str,
        Setting("image points projected, or detected in rendered pictures of arms that wear markers", choices=SENSORS),
    ] = "projected"
    dynamics: Annotated[
        str,
        Setting(
            "arms without mass, or with weight and motors of limited torque and speed, by PyBullet", choices=DYNAMICS
        ),
    ] = "none"
    max_step_deg: Annotated[
        float | None,
        Setting(
            "longest motion of a joint; a longer one is made in several, with a look after each",
            unit="deg",
            bounds=(0.01, 360.0),
            default="any angle",
        ),
    ] = None
    workspace_deg: Annotated[
        tuple[Range, ...] | None,
        Setting(
            "lowest and highest angle of each moving joint that the learner's arm may be sent to",
            unit="low:high,low:high",
            default="the arm's limits",
        ),
    ] = None

    @classmethod
    def paper(cls, **changes: Any) -> "Settings":
        """Make settings of the paper's method: transfer "epipolar", servo "broyden", 1 frame.

        Parameters
        ----------
        **changes
            Fields with other values.

        Returns
        -------
        Settings
            They raise as `Settings` does.
        """
        return cls(**{**PAPER_FIELDS, **changes})

    @property
    def scene_title(self) -> str:
        """In a line, for people."""
        if not is_text(self.scene):
            return file_name(self.scene)
        fields = parse_toml(self.scene.encode())
        return " ".join(str(fields.get("title", fields.get("extends"))).split())

    @property
    def start_rad(self) -> NDArray[np.float64]:
        """(m,) rad. Raises ValueError for the scene's own start: the settings of a session say which that is."""
        return np.radians(given(self.start_deg))

    @property
    def max_step(self) -> float:
        """rad, a joint and motion; inf if a motion may be of any length."""
        return float("inf") if self.max_step_deg is None else float(np.radians(self.max_step_deg))

    def amounts(self, kind: type[D]) -> tuple[tuple[D, float], ...]:
        """List the disturbances of a kind.

        Parameters
        ----------
        kind : type
            Subclass of `Disturbance`.

        Returns
        -------
        tuple of (Disturbance, float)
            Each with its amount, which may be 0.
        """
        return tuple([(found, getattr(self, name)) for name, found in disturbances(kind).items()])

    def __post_init__(self) -> None:
        for name, hint in _HINTS.items():
            given = getattr(self, name)
            if (value := _plain(given)) is not given:
                msgspec.structs.force_setattr(self, name, value)
            if not _is_of(hint, value) or (name == "undistort" and not np.isfinite(value or 0).all()):
                advice = f"; give your own to Session(settings, {name}=…)" if name in ("transfer", "servo") else ""
                raise ValueError(f"{name} must be {_EXPECTED[name]}, got {reprlib.repr(value)}{advice}")
        if self.undistort is not None:
            try:
                RadialDistortion(*self.undistort)
            except ValueError as error:
                raise ValueError(f"undistort: {error}") from None
        for low, high in self.workspace_deg or ():
            if not (np.isfinite([low, high]).all() and low < high):
                raise ValueError(f"workspace_deg: {low:g}° … {high:g}° is no range: give the lower angle first")
        for name, field in FIELDS.items():
            value = getattr(self, name)
            choices = field.choices if isinstance(field, Setting) else ()
            is_method = name in ("transfer", "servo")
            if choices and value not in choices and not (value == OWN and is_method):
                kind = UnknownMethod if is_method else ValueError
                raise kind(f"no {name} {value!r}; there are {', '.join(choices)}")
            if field.bounds is not None and value is not None:
                low, high = field.bounds
                if not low <= value <= high:  # NaN fails too
                    raise ValueError(f"{name} must be between {low:g} and {high:.10g}, got {value:.10g}")


def _is_of(kind, value) -> bool:
    try:
        msgspec.convert(value, kind)
    except msgspec.ValidationError:
        return False
    return True


def _plain(value):
    """Tuples, texts and Python's numbers, which can be kept, compared and written."""
    if type(value) in (float, int, str):  # nearly all, and links hold thousands
        return value
    if isinstance(value, (np.ndarray, np.generic)):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return tuple(map(_plain, value))
    return str(value) if isinstance(value, PurePath) else value


_HINTS = get_type_hints(Settings)
_OF_TYPE: dict[Any, str] = {bool: "True or False", int: "a whole number", float: "a number", float | None: "a number"}
_OF_TYPE |= {str: "text", str | None: "text"}
_EXPECTED = {name: _OF_TYPE.get(hint, "angles in degrees") for name, hint in _HINTS.items()} | {
    "joints": "whole numbers",
    "body_points": "[link, x, y, z] each",
    "workspace_deg": "[lowest, highest] each, angles in degrees",
    "undistort": "two finite numbers k1, k2",
}
_DEGREES = [name for name in _HINTS if name.endswith("_deg")]
FIELDS: Mapping[str, Setting | Disturbance] = {  # in the order of `Settings`
    name: hint.__metadata__[0] for name, hint in get_type_hints(Settings, include_extras=True).items()
}
DISTURBANCES: Mapping[str, Disturbance] = {  # by the field that says how much of it
    name: field for name, field in FIELDS.items() if isinstance(field, Disturbance)
}


def warn_of_radians(settings: Settings) -> None:
    """Warn of fields in degrees whose values are whole degrees only if they are read as rad.

    The warning names the line outside this package that led here.
    """
    for name in _DEGREES:
        given = np.array(getattr(settings, name) or 0.0, float).ravel()
        converted = np.degrees(given[np.abs(given) > np.radians(0.5)])  # smaller ones may be rounding errors of 0
        whole = converted.round()
        if len(whole) and np.abs(whole).max() <= MAX_TURNS * 360 and np.abs(converted - whole).max() < TOLERANCE_DEG:
            meant = ", ".join(f"{angle:g}" for angle in np.degrees(given).round())
            warnings.warn(
                f"{name} = {getattr(settings, name)} looks like radians; angles in settings are in degrees. "
                f"Did you mean {meant}?",
                stacklevel=level_outside(),
            )


def level_outside() -> int:
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


def option(name: str) -> str:
    """The option of the command line that sets a field of `Settings`, or that has this destination."""
    field = FIELDS.get(name)
    return "--" + (isinstance(field, Setting) and field.option or name.replace("_", "-"))


def convert_fields(fields: Mapping[str, Any]) -> dict[str, Any]:
    """Convert values as JSON has them to the types of these fields. Raises ValueError for another name or value."""
    try:
        whole = msgspec.convert(fields, Settings)
    except msgspec.ValidationError as error:
        raise ValueError(str(error)) from None
    return {name: getattr(whole, name) for name in fields}
