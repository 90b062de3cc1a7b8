"""What a visitor can choose from: presets, disturbances, joints, layouts of points, and how a page shows them."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from viewimit.drawing import svg
from viewimit.loop.settings import FIELDS, Setting, Settings, disturbances, given
from viewimit.loop.simulated_robot import complete
from viewimit.sensing.files import file_name
from viewimit.simulation.disturbances import ArmDisturbance, Disturbance, SightDisturbance
from viewimit.simulation.robot import robot_names
from viewimit.simulation.scene import Scene, load_robot, load_scene
from viewimit.simulation.scene_writing import scene_text

from ..presets import PRESETS, Preset

FLAGS = {"0": False, "1": True}  # as links have them

SPEEDS = {  # motions a second; 0 is as fast as it computes
    "1 in 2 s": 0.5, "1 a second": 1.0, "2 a second": 2.0, "4 a second": 4.0, "10 a second": 10.0, "all it can": 0.0,
}  # fmt: skip
NO_POINT = "none"
MESSAGE_S, WARNING_S = 6.0, 30.0  # s that a message stays


def modified(preset: str) -> str:
    """A preset whose settings have been changed. This word comes first, as a narrow list cuts off the end."""
    return f"(modified) {preset}"


@dataclass(frozen=True)
class Amount:
    """name: in `Settings`; label, low, high, step, hint: of its slider; per: units on the page for one there;
    is_whole: of whole things, each of which takes time, so that no more may be asked for than the slider has."""

    name: str
    label: str
    low: float
    high: float
    step: float
    per: float
    hint: str
    is_whole: bool = False

    def shown(self, settings: Settings) -> float:
        """The slider's value."""
        value = getattr(settings, self.name) * self.per
        return round(value) if isinstance(self.step, int) else round(value, 6)

    def asked(self, value: float) -> float:
        """What the slider's value is in the settings. Raises ValueError."""
        if not self.is_whole:
            return value / self.per
        if not self.low <= round(value) <= self.high:
            raise ValueError(f"{self.label} must be between {self.low} and {self.high}, got {round(value)}")
        return round(value)


def _amounts(kind: type[Disturbance]) -> list[Amount]:
    named = disturbances(kind).items()
    return [Amount(name, it.label, *it.slider_range, it.slider_scale, it.description) for name, it in named]


_FRAMES = FIELDS["frames"]
assert isinstance(_FRAMES, Setting)
FRAMES = Amount("frames", _FRAMES.label, *_FRAMES.slider_range, 1, _FRAMES.description, is_whole=True)
OF_IMAGES: tuple[Amount, ...] = (*_amounts(SightDisturbance), FRAMES)
OF_ARMS: tuple[Amount, ...] = (*_amounts(ArmDisturbance),)
AMOUNTS = {amount.name: amount for amount in (*OF_IMAGES, *OF_ARMS)}


# Which joints imitate: those of the scene, as the paper's two, or all of the robot's.

MANY_POINTS = 16  # that more joints than the scene's need at least
WORDS = "none one two three four five six seven eight nine".split()
JOINT_NAMES = ("Base", "Shoulder", "Upper arm", "Elbow", "Forearm", "Wrist", "Hand")  # of a human arm


def joint_name(scene: Scene, joint: int) -> str:
    """What a joint is called, with its symbol: the shipped robots' are those of a human arm, others have their own."""
    if scene.robot not in robot_names():
        name = load_robot(scene.robot).joints[joint - 1].name
    else:
        name = JOINT_NAMES[joint - 1] if joint <= len(JOINT_NAMES) else "Joint"
    return f"{name} {svg.joint_symbol(joint)}"


def joint_choices(settings: Settings) -> dict[str, tuple[int, ...] | None]:
    """What `Settings.joints` may become, by name; the present ones included."""
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
            "demonstrator_deg": _converted(given(settings.demonstrator_deg), scene, after),
            "start_deg": _converted(given(settings.start_deg), scene, after),
        }


def _converted(angles_deg: tuple[float, ...], scene: Scene, after: Scene) -> tuple[float, ...]:
    """Angles of the joints that moved, as angles of those that will; the others are at rest."""
    known = dict(zip(scene.moving_joints, angles_deg))
    return tuple(known.get(joint, after.posture_deg[joint - 1]) for joint in after.moving_joints)


def _name(joints: tuple[int, ...]) -> str:
    return f"{_number(len(joints))}: {', '.join(map(svg.joint_symbol, joints))}"


def _number(count: int) -> str:
    return WORDS[count] if count < len(WORDS) else str(count)


def layout_choices(settings: Settings) -> dict[str, dict[str, Any]]:
    """Settings to change, by name; none for the points by hand, if there are some."""
    own = load_scene(settings.scene, settings.robot).points
    choices: dict[str, dict[str, Any]] = {
        svg.count_points(int(count)): {"points": int(count), "body_points": None} for count in own
    }
    return choices if settings.body_points is None else {**choices, chosen_layout(settings): {}}


def chosen_layout(settings: Settings) -> str:
    """The name of the layout that there is now."""
    if settings.body_points is None:
        return svg.count_points(settings.points)
    return f"{len(settings.body_points)} by hand"


# Presets: those of the list, and what the command line asked for.

AS_STARTED = "As started"


def presets_from(asked: Settings) -> dict[str, Preset]:
    """By name, the one to begin with first: what the command line asked for, if no preset is that."""
    begun = next((preset for preset in PRESETS if preset.settings == asked), Preset(AS_STARTED, asked))
    return {preset.name: preset for preset in (begun, *PRESETS)}


@lru_cache(64)
def usual(preset: Preset) -> Settings:
    """Return the settings of a preset as a session has them, with the postures of its scene."""
    return complete(preset.settings)


class Presets:
    """Which a page offers, by name, and which it has begun with last. asked: by the command line."""

    def __init__(self, asked: Settings):
        self.offered = presets_from(asked)
        self.chosen = next(iter(self.offered.values()))
        self.pictured = {name for name, preset in self.offered.items() if preset.settings.sensor == "rendered"}


# Scenes that are described in full, in links: at most what a page can draw.

MAX_POINTS = 64  # placed by hand, or of a layout
MAX_LAYOUTS = 16
MAX_TITLE = 200  # characters


def place_in_link(place: str) -> str:
    """Return how a link names a scene or a robot: a scene file by its content, any other file by its name."""
    return scene_text_of(place) if place.lower().endswith(".toml") else file_name(place)


def scene_text_of(place: str) -> str:
    """Return the content of a scene file, where possible; otherwise its name."""
    try:
        text = scene_text(load_scene(place))
        require_scene(text)
        return text
    except (OSError, ValueError):
        return file_name(place)


def require_scene(text: str) -> None:
    """Raise ValueError for a description of no scene, or of one that is too large for a page."""
    try:
        scene = load_scene(text)
    except ValueError as error:
        raise ValueError(f"the link's scene cannot be shown: {' '.join(str(error).split())[:150]}") from None
    points = max(map(len, scene.points.values()), default=0)
    for what, count, most in (
        ("points", points, MAX_POINTS),
        ("layouts", len(scene.points), MAX_LAYOUTS),
        ("letters in its title", len(scene.title), MAX_TITLE),
    ):
        if count > most:
            raise ValueError(f"the link's scene has {count} {what}; {most} are the most")
    if not scene.title.isprintable():
        raise ValueError("the link's scene has a title that cannot be printed")


LARGE = ("images", "figures", "l", "r", "L", "R")  # the panels, one of the images
WINDOW = "window"  # instead of all tabs' names
SWITCHES = "goal", "rays", "residuals", "gizmo", "whole_frames", "rectified", "shadows", "details"  # kept by name
SWITCHED = *SWITCHES, "flat", "dark", "look_only"  # that the visitor sets


@dataclass(frozen=True)
class View:
    """Choices of one page. `on` tells the switches that follow the browser until the visitor chooses."""

    chosen: int | None = None  # body point that is explained
    goal: bool = True  # from here to `dark`: the switches of the folder Display
    rays: bool = False
    residuals: bool = True
    gizmo: bool = True
    whole_frames: bool = False
    rectified: bool = False
    shadows: bool = False
    details: bool = False  # all numbers, what noise costs, the enlarged landscape, and poses to preview
    flat: bool = False  # a still picture instead of the 3-D view, as a browser without WebGL or speed asks for it
    dark: bool | None = None  # None: as the browser prefers
    prefers_dark: bool = False  # the browser's preference
    help: bool = False  # whether the help is open
    fits: int = 0  # how often the visitor has asked for the default camera
    look_only: bool = False  # a posture that is clicked is previewed, and nothing moves
    share: bool = False  # whether the card with link and code is open
    large: str | None = None  # of LARGE: what fills the window beside the controls
    picture: str = "Images"  # panel that is saved as a picture
    picture_as: str = "SVG"
    truth: bool = True  # whether what only the viewer knows is shown; hidden before a class until it is asked for
    unseen: frozenset[str] = frozenset()  # tabs that are not open, or WINDOW where nobody sees any of the page

    def on(self, switch: str) -> bool:
        """Return whether a switch is on, by its name."""
        chosen = getattr(self, switch)
        return self.prefers_dark if chosen is None else chosen


@dataclass(frozen=True)
class Message:
    """A sentence for the visitor, until a time of the scheduler's clock, s."""

    text: str
    until: float
