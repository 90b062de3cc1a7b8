"""What the commands share: options made from the fields of `Settings`, and faults named by their option."""

import argparse
import contextlib
import dataclasses
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

import msgspec
import numpy as np

from .estimation.transfers.registry import PROJECTIVE_MIN_POINTS
from .estimation.views import VIEW_NAMES
from .geometry.distortion import RadialDistortion
from .loop.arm_and_eyes import require_in_workspace, workspace
from .loop.settings import FIELDS, OWN, USUAL_POINTS, Setting, Settings, disturbances, option
from .sensing.files import MAX_NAME_CHARS, escape
from .simulation.arms import require_arm
from .simulation.disturbances import ArmDisturbance, Disturbance, SightDisturbance
from .simulation.eyes import require_eyes
from .simulation.robot import robot_names
from .simulation.scene import RobotFileMissing, Scene, load_robot, load_scene, scene_for_urdf, scene_names
from .simulation.urdf.reference import (
    PARTS,
    description_path,
    is_description,
    is_reference,
    parse_reference,
    require_urdf,
)

if TYPE_CHECKING:
    from .simulation.autoscene.scene import AutoScene  # it loads trimesh


class BadInput(Exception):
    """What the user gave cannot be; the message names the option, the file or the line."""


DONE, MISSED = 0, 1
PAPER = Settings.paper()
ALL = "all"
SHOWN_IN = {
    "l": "the demonstrator, by the left camera",
    "r": "the demonstrator, by the right camera",
    "L": "the learner itself, by the left camera",
    "R": "the learner itself, by the right camera",
}
SCENE = ("scene", "robot", "joints", "points")  # fields that select the bodies
SIGHT = (*disturbances(SightDisturbance), "frames", "seed")  # how well it is seen
ARM = ("start_deg", *disturbances(ArmDisturbance))  # where the arm starts, and how well it moves
DEFAULT_TRANSFER = f"projective from {PROJECTIVE_MIN_POINTS} points on, epipolar below"  # `default_transfer` in words


def add_address(parser: argparse.ArgumentParser) -> None:
    """Add the options of where a server listens."""
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen on (%(default)s, this machine alone); 0.0.0.0 admits everybody on its network",
    )
    parser.add_argument("--port", type=between(int, 0, 65535), default=8080, help="0 takes a free one (%(default)s)")


def add_settings(parser: argparse.ArgumentParser, *names: str, defaults: Settings = PAPER, **helps: str | None) -> None:
    """Add options for these fields of `Settings`, from their descriptions; with `robot` those of its URDF.

    helps: another help text for a field, by its name.
    """
    for name in names:
        field, value = FIELDS[name], getattr(defaults, name)
        default = field.default if isinstance(field, Setting) else ""
        default = default or (f"{value:g}" if isinstance(value, float) else str(value))
        says = helps.get(name) or f"{_described(name, field)} ({default})"
        kind = PARSERS.get(name) or TYPES[HINTS[name]]
        choices = field.choices if name == "rectify" and isinstance(field, Setting) else None
        metavar = None if choices else field.unit.upper() or "NAME"
        parser.add_argument(option(name), dest=name, type=kind, choices=choices, metavar=metavar, help=says)
        if name == "robot":
            add_chain_options(parser)


def _described(name: str, field: Setting | Disturbance) -> str:
    """A field's description, with the names that it can have."""
    shipped: dict[str, Callable[[], Sequence[str]]] = {"scene": scene_names, "robot": robot_names}
    names = shipped.get(name)
    listed = list(names()) if names else list(field.choices) if isinstance(field, Setting) else []
    more = {"robot": " (also one of robot_descriptions)", "joints": ", or all"}.get(name, "")
    return field.description + more + (f": {', '.join(listed)}" if listed and name != "rectify" else "")


def add_chain_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that select the arm in a URDF, and where its meshes may be."""
    parser.add_argument("--base", metavar="LINK", help="first link of a .urdf file's arm (its root)")
    parser.add_argument(
        "--tip", metavar="LINK", help="last link of a .urdf file's arm (of the longest chain, without fingers)"
    )
    parser.add_argument(
        "--meshes", type=Path, metavar="DIR", help="a further folder to read a .urdf file's meshes from (its own alone)"
    )


def comma_separated(convert: Callable[[str], Any], needs: str) -> Callable[[str], tuple]:
    """Make a type for argparse: values separated by commas. needs: what they are, with an example."""

    def parse(text: str) -> tuple:
        try:
            return tuple(map(convert, text.split(",")))
        except ValueError:
            raise argparse.ArgumentTypeError(f"needs {needs}, got {text!r}") from None

    return parse


def joints(text: str) -> tuple[int, ...] | str:
    """A type for argparse: numbers separated by commas, or all."""
    return text if text == ALL else comma_separated(int, "joints such as 2,4, or all")(text)


def radial(text: str) -> tuple[float, ...]:
    """A type for argparse: k1 and k2."""
    needs = "2 numbers such as -0.05,0.01"
    found = comma_separated(float, needs)(text)
    if len(found) != 2 or not np.isfinite(found).all():
        raise argparse.ArgumentTypeError(f"needs {needs}, got {text!r}")
    try:
        RadialDistortion(*found)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return found


def range_of(text: str) -> tuple[float, float]:
    """Read low:high. Raises ValueError."""
    low, high = text.split(":")
    return float(low), float(high)


def add_view_options(parser: argparse.ArgumentParser, says: str, **kind: Any) -> None:
    """Add an option for a file of each view. says: the help, with {} for what the view shows."""
    for view, name in VIEW_NAMES.items():
        parser.add_argument(option(name), type=Path, metavar="FILE", help=says.format(SHOWN_IN[view]), **kind)


def require_separate_files(paths: Iterable[Path]) -> None:
    """Raises BadInput for two names that differ in small and capital letters alone, and are one file."""
    known: dict[str, Path] = {}
    for path in paths:
        other = known.setdefault(str(path).lower(), path)
        if str(other) != str(path) and other.exists() and path.exists() and other.samefile(path):
            raise BadInput(
                f"{other} and {path} are one file here: name those of the views by {', '.join(VIEW_NAMES.values())}"
            )


VIEW_OPTIONS = ", ".join(map(option, VIEW_NAMES.values()))


def add_json_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print one JSON object")


def settings_from(args: argparse.Namespace, defaults: Settings = PAPER) -> Settings:
    """Settings from the options that were given, and defaults for the rest. Raises BadInput that names the option."""
    asked = choose_bodies(args)
    del args.base, args.tip, args.meshes  # the robot's name says them now
    settings = defaults
    later = ("scene", "robot", "joints", "points", "demonstrator_deg", "start_deg")  # checked with the scene, below
    for name, value in vars(args).items():
        if name in FIELDS and name not in later and value is not None:
            with naming(option(name)):
                if value == OWN:
                    raise ValueError(f"no {name} {OWN!r}: only a session in Python is given one")
                settings = msgspec.structs.replace(settings, **{name: value})
    chosen = settings.scene if args.scene is None else args.scene
    with naming(asked):
        try:
            scene = load_scene(chosen)
        except RobotFileMissing:
            if args.robot is None:
                raise
    with naming("--robot"):
        scene = load_scene(chosen, args.robot)
    freed = all_joints(scene.robot) if args.joints == ALL else args.joints
    with naming("--joints"):
        scene = load_scene(chosen, args.robot, freed)
    with naming("--undistort"):
        scene = load_scene(chosen, args.robot, freed, settings.undistort)
    with naming("--sensor"):
        require_eyes(settings.sensor, scene)
    with naming("--dynamics"):
        require_arm(settings.dynamics, scene)
    if is_reference(chosen):
        tell_choices(scene_for_urdf(chosen, freed), scene)
    points = layout(args, scene)
    postures = {name: vars(args).get(name) for name in ("demonstrator_deg", "start_deg")}
    for name, posture in postures.items():
        if posture is not None:
            with naming(option(name)):
                scene.require_posture(np.radians(posture), "its")
    with naming("--workspace-deg"):
        low, high = workspace(settings, scene.lower, scene.upper)
    with naming("--start"):
        start_deg = scene.start_deg if postures["start_deg"] is None else postures["start_deg"]
        require_in_workspace(np.radians(start_deg), low, high, "the start")
    return msgspec.structs.replace(settings, scene=chosen, robot=args.robot, joints=freed, points=points, **postures)


def choose_bodies(args: argparse.Namespace) -> str:
    """Take --robot for the scene where it has one of its own: a URDF, a shipped name, or a scene file.

    Returns the option that named the scene.
    """
    with naming("--robot"):
        is_file = args.scene is None and str(args.robot).lower().endswith(".toml")
        if not is_file:
            args.robot = robot_reference(args)
    if args.scene is None and (is_file or args.robot in scene_names() or is_reference(args.robot)):
        args.scene, args.robot = args.robot, None
        return "--robot"
    return "--scene"


def robot_reference(args: argparse.Namespace) -> str | None:
    """--robot, a URDF of robot_descriptions by its path, and with --base, --tip and --meshes in it.

    Raises ValueError.
    """
    name = args.robot
    if name is not None:
        require_urdf(name)
        name = str(description_path(name)) if is_description(name) else name
    given = {part: vars(args)[part] for part in PARTS if vars(args)[part] is not None}
    if not given:
        return name
    if not is_reference(name):
        raise ValueError("--base, --tip and --meshes are of a .urdf file: give its path")
    if args.meshes is not None and not args.meshes.is_dir():
        raise ValueError(f"--meshes: {args.meshes} is no folder")
    found = parse_reference(name)
    if twice := [part for part in given if getattr(found, part) not in (None, given[part])]:
        raise ValueError(f"--{twice[0]}: {name} names another one: leave one out")
    return str(dataclasses.replace(found, **given))


def all_joints(robot: str) -> tuple[int, ...]:
    """Numbers of all joints that can move, from 1."""
    return load_robot(robot).movable_joints


def tell_choices(chosen: "AutoScene", scene: Scene) -> None:
    """Print the choices made for a URDF, which joints move, and which of its parts are not drawn."""
    path, robot = parse_reference(scene.robot).path, load_robot(scene.robot)
    moving = [
        f"{joint} ({escape(robot.joints[joint - 1].name, MAX_NAME_CHARS)}) {low:g}° … {high:g}°"
        for joint, (low, high) in zip(scene.moving_joints, scene.range_deg)
    ]
    said, faults = (map(escape, lines) for lines in (chosen.choices, chosen.faults))
    for line in (*said, f"{escape(str(path))}: moving {', '.join(moving)}", *faults):
        print(line, file=sys.stderr)


def layout(args: argparse.Namespace, scene: Scene) -> int:
    """--n-points, or the scene's own layout. Raises BadInput."""
    points = scene.layout_near(USUAL_POINTS) if args.points is None else args.points
    with naming("--n-points"):
        scene.body_points(points)
    return points


@contextlib.contextmanager
def naming(option: str) -> Iterator[None]:
    """Turn OSError and ValueError into BadInput that names this option."""
    try:
        yield
    except OSError as error:
        what = error if error.filename is None else f"{error.filename}: {error.strerror}"
        raise BadInput(f"{option}: {what}") from None
    except ValueError as error:
        raise BadInput(f"{option}: {error}") from None


def between(convert: Callable, low: float, high: float) -> Callable:
    """A type for argparse: a number in [low, high]."""

    def number(text: str):
        value = convert(text)
        if not low <= value <= high:  # NaN fails too
            raise argparse.ArgumentTypeError(f"must be between {low:g} and {high:g}, got {text}")
        return value

    return number


HINTS = get_type_hints(Settings)
PARSERS: dict[str, Callable[[str], Any]] = {
    "joints": joints,
    "undistort": radial,
    "workspace_deg": comma_separated(range_of, "ranges in degrees such as -30:60,-90:0"),
    **dict.fromkeys(
        ("demonstrator_deg", "start_deg"), comma_separated(float, "degrees separated by commas, such as 45,-90")
    ),
}
TYPES: dict[Any, Callable[[str], Any]] = {str: str, str | None: str, int: int, float: float, float | None: float}
