"""Checks of what a browser sent: anything may come."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from viewimit.drawing import svg
from viewimit.estimation.transfers import TRANSFERS
from viewimit.loop.settings import FIELDS, Setting, Settings, disturbances, given
from viewimit.servo import SERVOS
from viewimit.simulation.disturbances import ArmDisturbance, Disturbance, SightDisturbance
from viewimit.simulation.scene import Scene, load_robot, load_scene


class Titled(Protocol):
    @property
    def title(self) -> str: ...


def number(value) -> float:
    """A finite number. Raises ValueError."""
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        found = np.nan
    if not np.isfinite(found):
        raise ValueError(f"{str(value)[:40]!r} is not a number")
    return found


def choice(value, options: Mapping, what: str):
    """What an option stands for. Raises ValueError."""
    if not isinstance(value, str) or value not in options:
        raise ValueError(f"no {what} {str(value)[:40]!r}")
    return options[value]


def named(value, entries: Mapping[str, Titled], what: str) -> str:
    """The name of an entry of a registry, by its title. Raises ValueError."""
    return choice(value, {entry.title: name for name, entry in entries.items()}, what)


def switch(value) -> bool:
    """Raises ValueError."""
    if not isinstance(value, bool):
        raise ValueError(f"{str(value)[:40]!r} is neither on nor off")
    return value


def text(what: str) -> Callable[[object], str]:
    """Return a parser that takes any text."""

    def parse(value: object) -> str:
        if not isinstance(value, str):
            raise ValueError(f"no {what} {str(value)[:40]!r}")
        return value

    return parse


def one_of(options: Mapping[str, Any] | Callable[[], Mapping[str, Any]], what: str) -> Callable[[object], Any]:
    """Return a parser that takes a name of `options`, and returns the option."""
    return lambda value: choice(value, options() if callable(options) else options, what)


FLAGS = {"0": False, "1": True}  # as links have them

SPEEDS = {
    "1 in 2 s": 0.5,
    "1 a second": 1.0,
    "2 a second": 2.0,
    "4 a second": 4.0,
    "10 a second": 10.0,
    "all it can": 0.0,
}  # motions a second; 0 is as fast as it computes
NO_POINT = "none"


def transfer_names() -> dict[str, str]:
    """Titles by name, of those that there are now."""
    return {name: method.title for name, method in TRANSFERS.items()}


def servo_names() -> dict[str, str]:
    return {name: servo.title for name, servo in SERVOS.items()}


def modified(preset: str) -> str:
    """A preset whose settings have been changed; first of all that, as a narrow list cuts off what is last."""
    return f"(modified) {preset}"


# The sliders of the folder Disturbances: what each stands for in the settings, in the units of the page.


@dataclass(frozen=True)
class Amount:
    """name: in `Settings`; label, low, high, step, hint: of its slider; per: so many on the page are one there."""

    name: str
    label: str
    low: float
    high: float
    step: float
    per: float
    hint: str

    def shown(self, settings: Settings) -> float:
        """The slider's value."""
        value = getattr(settings, self.name) * self.per
        return round(value) if isinstance(self.step, int) else round(value, 6)

    def asked(self, value: object) -> float:
        """What the slider's value, sent by a browser, is in the settings. Raises ValueError for what is no number."""
        return number(value) / self.per


@dataclass(frozen=True)
class Count(Amount):
    """An amount of whole things. Each takes time, so no more may be asked for than the slider has."""

    def asked(self, value: object) -> int:
        found = round(number(value))
        if not self.low <= found <= self.high:
            raise ValueError(f"{self.label.lower()} must be between {self.low} and {self.high}, got {found}")
        return found


def _amounts(kind: type[Disturbance]) -> list[Amount]:
    return [
        Amount(name, it.label, *it.slider_range, it.slider_scale, it.description)
        for name, it in disturbances(kind).items()
    ]


_FRAMES = FIELDS["frames"]
assert isinstance(_FRAMES, Setting)
FRAMES = Count("frames", _FRAMES.label, *_FRAMES.slider_range, 1, _FRAMES.description)
OF_IMAGES: tuple[Amount, ...] = (*_amounts(SightDisturbance), FRAMES)
OF_ARMS: tuple[Amount, ...] = (*_amounts(ArmDisturbance),)
AMOUNTS = {amount.name: amount for amount in (*OF_IMAGES, *OF_ARMS)}


# Which joints imitate: those of the scene, as the paper's two, or all of the robot's.

MANY_POINTS = 16  # that more joints than the scene's need at least
WORDS = ("none", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")


def joint_choices(settings: Settings) -> dict[str, tuple[int, ...] | None]:
    """What `Settings.joints` may become, by name; the present ones too, whatever they are."""
    scene = load_scene(settings.scene, settings.robot)
    every = load_robot(scene.robot).movable_joints
    choices = {_name(scene.moving_joints): None, f"all {_number(len(every))}": every}
    if settings.joints is not None and settings.joints not in (every, scene.moving_joints):
        choices[_name(settings.joints)] = settings.joints
    return choices


def chosen_joints(settings: Settings, choices: dict[str, tuple[int, ...] | None]) -> str:
    """The name of the joints that move now."""
    return next((name for name, joints in choices.items() if joints == settings.joints), next(iter(choices)))


class Freedom:
    """Frees joints and holds them: what that asks of the settings. Both arms keep what angles they have."""

    def __init__(self):
        self._layout: int | None = None  # of the scene's own joints, to come back to

    def fields(self, settings: Settings, scene: Scene, joints: tuple[int, ...] | None) -> dict:
        """Settings to change. scene: with the joints that move now."""
        after = load_scene(settings.scene, settings.robot, joints, body_points=settings.body_points)
        layouts = sorted(map(int, scene.points))
        points = settings.points
        if joints is None:
            points = self._layout if self._layout in layouts else min(layouts, key=lambda n: abs(n - Settings().points))
        elif settings.joints is None:
            self._layout = points
        if len(after.moving_joints) > 2:
            points = max(points, next((n for n in layouts if n >= MANY_POINTS), layouts[-1]))
        return {
            "joints": joints,
            "points": points,
            "demonstrator_deg": _carried(given(settings.demonstrator_deg), scene, after),
            "start_deg": _carried(given(settings.start_deg), scene, after),
        }


def _carried(angles_deg: tuple[float, ...], scene: Scene, after: Scene) -> tuple[float, ...]:
    """Angles of the joints that moved, as angles of those that will; the others are at rest."""
    known = dict(zip(scene.moving_joints, angles_deg))
    return tuple(known.get(joint, after.posture_deg[joint - 1]) for joint in after.moving_joints)


def _name(joints: tuple[int, ...]) -> str:
    return f"{_number(len(joints))}: {', '.join(map(svg.joint_symbol, joints))}"


def _number(count: int) -> str:
    return WORDS[count] if count < len(WORDS) else str(count)
