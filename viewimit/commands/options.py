"""What the commands share: options of the scene and of a run, and faults named by their option."""

import argparse
import contextlib
import dataclasses
import sys
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from ..estimation.transfers.registry import PROJECTIVE_MIN_POINTS, TRANSFERS
from ..estimation.views import VIEW_NAMES
from ..geometry.distortion import RadialDistortion
from ..loop.embodiment import within, workspace
from ..loop.settings import CAMERAS, DISTURBANCES, OWN, RECTIFY, SAFETY, USUAL_POINTS, Settings, disturbances
from ..sensing.files import MAX_NAME_CHARS, escape
from ..servo import SERVOS
from ..simulation.disturbances import ArmDisturbance, Disturbance, SightDisturbance
from ..simulation.eyes import require_eyes
from ..simulation.robot import robot_names
from ..simulation.scene import RobotFileMissing, Scene, load_robot, load_scene, scene_for_urdf, scene_names
from ..simulation.urdf.reference import (
    PARTS,
    description_path,
    is_description,
    is_reference,
    parse_reference,
    require_urdf,
)
from . import BadInput

if TYPE_CHECKING:
    from ..simulation.autoscene.scene import AutoScene  # it loads trimesh

DONE, MISSED = 0, 1
PAPER = Settings.paper()
ALL = "all"
SHOWN_IN = {
    "l": "the demonstrator, by the left camera",
    "r": "the demonstrator, by the right camera",
    "L": "the learner itself, by the left camera",
    "R": "the learner itself, by the right camera",
}
DEFAULT_TRANSFER = f"projective from {PROJECTIVE_MIN_POINTS} points on, epipolar below"  # `default_transfer` in words
USUAL_LAYOUT = f"{USUAL_POINTS}, or the scene's nearest to that"


def add_setting_options(
    parser: argparse.ArgumentParser, defaults: Settings = PAPER, transfer: str | None = None
) -> None:
    """What is seen, and how it is transferred. transfer: its default in words, where that is not the settings' own."""
    add_scene_options(parser, defaults)
    parser.add_argument("--demonstrator", type=angles, metavar="DEG,DEG", help="its moving joints (the scene's)")
    parser.add_argument("--transfer", metavar="NAME", help=f"{', '.join(TRANSFERS)} ({transfer or defaults.transfer})")
    add_rectify_option(parser)
    add_image_options(parser, SightDisturbance, defaults)


def add_scene_options(parser: argparse.ArgumentParser, defaults: Settings = PAPER) -> None:
    """Which body is seen, and where."""
    scenes = ", ".join(scene_names())
    parser.add_argument("--scene", help=f"{scenes}, or the path of a .toml or .urdf file ({defaults.scene})")
    parser.add_argument(
        "--robot",
        help=f"{', '.join(robot_names())}, the path of a .urdf file, or a name of robot_descriptions (the scene's). "
        "For a .urdf a scene is made, or, with --scene, it takes the place of that scene's robot, with the same bases, "
        "limits and points in its links' frames",
    )
    add_chain_options(parser)
    parser.add_argument("--joints", type=joints, metavar="N,N", help="that move, from 1, or all (the scene's)")
    parser.add_argument("--points", type=int, metavar="N", help=f"layout of the scene ({USUAL_LAYOUT})")


def add_chain_options(parser: argparse.ArgumentParser) -> None:
    """Which part of a URDF is the arm."""
    parser.add_argument("--base", metavar="LINK", help="of a .urdf: where the arm begins (its root)")
    parser.add_argument(
        "--tip", metavar="LINK", help="of a .urdf: where the arm ends (of the longest chain, without fingers)"
    )


def add_image_options(parser: argparse.ArgumentParser, spoilt_by: type[Disturbance], defaults: Settings) -> None:
    """How well it is seen."""
    _add_disturbances(parser, spoilt_by)
    parser.add_argument("--frames", type=int, metavar="N", help=f"images averaged at each posture ({defaults.frames})")
    parser.add_argument("--seed", type=int, metavar="N", help=f"of the disturbances ({defaults.seed})")


def add_undistort_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--undistort",
        type=radial,
        metavar="K1,K2",
        help="rid images of this radial distortion, by OpenCV's model, first (none)",
    )


def radial(text: str) -> tuple[float, float]:
    """A type for argparse: k1 and k2."""
    k1, k2 = _numbers(text, 2, "-0.05,0.01")
    try:
        RadialDistortion(k1, k2)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return k1, k2


def lens(text: str) -> tuple[float, ...]:
    """A type for argparse: focal lengths and centre of a lens, px."""
    found = _numbers(text, 4, "600,600,320,240")
    if min(found[:2]) <= 0:
        raise argparse.ArgumentTypeError(f"focal lengths must be more than 0, got {text!r}")
    return found


def _numbers(text: str, count: int, such_as: str) -> tuple[float, ...]:
    """Finite ones, separated by commas."""
    try:
        found = tuple(float(word) for word in text.split(","))
    except ValueError:
        found = ()
    if len(found) != count or not np.isfinite(found).all():
        raise argparse.ArgumentTypeError(f"needs {count} numbers such as {such_as}, got {text!r}")
    return found


def add_rectify_option(parser: argparse.ArgumentParser, when: str = "where those are not parallel") -> None:
    """when: what auto means."""
    parser.add_argument(
        "--rectify", choices=RECTIFY, help=f"images by what their matches tell of the cameras: {when}, or never (auto)"
    )


def add_camera_option(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--camera",
        metavar="NAME",
        help=f"{', '.join(CAMERAS)}: points projected, or detected in rendered pictures of arms that have weight, "
        "which wear markers in place of --points (points)",
    )


def add_run_options(parser: argparse.ArgumentParser, defaults: Settings = PAPER) -> None:
    """Where the learner starts, and how it moves."""
    add_arm_options(parser)
    parser.add_argument("--servo", metavar="NAME", help=f"{', '.join(SERVOS)} ({defaults.servo})")


def add_arm_options(parser: argparse.ArgumentParser) -> None:
    """Where the learner starts, and how well it obeys."""
    parser.add_argument("--start", type=angles, metavar="DEG,DEG", help="the learner's moving joints (the scene's)")
    _add_disturbances(parser, ArmDisturbance)


def add_safety_options(parser: argparse.ArgumentParser) -> None:
    """How far the learner's arm may go."""
    parser.add_argument(
        "--max-step-deg", type=float, metavar="DEG", help="no joint turns by more in one motion (any angle)"
    )
    parser.add_argument(
        "--workspace-deg",
        type=ranges,
        metavar="LOW:HIGH,LOW:HIGH",
        help="angles that the learner's moving joints are sent to, and none beyond (the arm's limits)",
    )
    parser.add_argument(
        "--restarts",
        type=int,
        metavar="N",
        help="searches far from where it has been, for something lower, before it stalls; 0 for none "
        f"({PAPER.restarts})",
    )


def _add_disturbances(parser: argparse.ArgumentParser, kind: type[Disturbance]) -> None:
    for name, found in disturbances(kind).items():
        parser.add_argument(option(name), type=float, metavar=found.unit.upper(), help=f"{found.description} (0)")


def option(name: str) -> str:
    """The option that sets a field of `Settings`."""
    return "--" + name.replace("_", "-")


def add_view_options(parser: argparse.ArgumentParser, says: str, **kind: Any) -> None:
    """A file of each view; its name in the paper is an option, too, for one more version. says: with {} for what it
    shows."""
    for view, name in VIEW_NAMES.items():
        parser.add_argument(option(name), type=Path, metavar="FILE", help=says.format(SHOWN_IN[view]), **kind)
        old = kind | {"default": argparse.SUPPRESS, "help": argparse.SUPPRESS}
        parser.add_argument(f"--{view}", dest=name, action=Renamed, type=Path, **old)


class Renamed(argparse.Action):
    """Of an option that has a new name, that of its destination: it still works, and says so."""

    def __call__(self, parser, namespace, values, option_string=None):
        new = option(self.dest)
        print(f"{parser.prog}: {option_string} is now called {new}; the old name will be gone", file=sys.stderr)
        setattr(namespace, self.dest, values)


def require_files_apart(paths: Iterable[Path]) -> None:
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
    """Settings of the options given, the rest by default, each checked under its own name. Raises BadInput."""
    with naming("--robot"):
        args.robot = robot_reference(args)
    asked = "--scene"
    if args.scene is None and (args.robot in scene_names() or is_reference(args.robot)):
        args.scene, args.robot = args.robot, None  # every robot has a scene of its own
        asked = "--robot"
    del args.base, args.tip  # the robot's name says them now
    settings = defaults
    names = ("transfer", "servo", *DISTURBANCES, "frames", "seed", "undistort", "rectify", "camera", *SAFETY)
    given = {name: vars(args).get(name) for name in names}
    for name, value in given.items():
        if value is not None:
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
    with naming("--camera"):
        require_eyes(settings.camera, scene)
    if is_reference(chosen):
        tell_choices(scene_for_urdf(chosen, freed), scene)
    points = layout(args, scene)
    postures = {name: vars(args).get(name) for name in ("demonstrator", "start")}
    for name, posture in postures.items():
        if posture is not None:
            with naming("--" + name):
                scene.require_posture(np.radians(posture), "its")
    with naming("--workspace-deg"):
        low, high = workspace(settings, scene.lower, scene.upper)
    with naming("--start"):
        within(np.radians(scene.start_deg if postures["start"] is None else postures["start"]), low, high, "the start")
    return msgspec.structs.replace(
        settings,
        scene=chosen,
        robot=args.robot,
        joints=freed,
        points=points,
        demonstrator_deg=postures["demonstrator"],
        start_deg=postures["start"],
    )


def robot_reference(args: argparse.Namespace) -> str | None:
    """--robot, a URDF of robot_descriptions by its path, and with --base and --tip in it. Raises ValueError."""
    name = args.robot
    if name is not None:
        require_urdf(name)
        name = str(description_path(name)) if is_description(name) else name
    if args.base is None and args.tip is None:
        return name
    if not is_reference(name):
        raise ValueError("--base and --tip are of a .urdf file: give its path")
    found = parse_reference(name)
    given = {part: vars(args)[part] for part in PARTS if vars(args)[part] is not None}
    return str(dataclasses.replace(found, **given))


def all_joints(robot: str) -> tuple[int, ...]:
    """Numbers of those that move by themselves."""
    return load_robot(robot).movable_joints


def tell_choices(chosen: "AutoScene", scene: Scene) -> None:
    """What was chosen for a URDF, which joints of the scene then move, and what of it is not drawn."""
    path, robot = parse_reference(scene.robot).path, load_robot(scene.robot)
    moving = [
        f"{joint} ({escape(robot.joints[joint - 1].name, MAX_NAME_CHARS)}) {low:g}° … {high:g}°"
        for joint, (low, high) in zip(scene.moving_joints, scene.range_deg)
    ]
    said, faults = (map(escape, lines) for lines in (chosen.choices, chosen.faults))
    for line in (*said, f"{escape(str(path))}: moving {', '.join(moving)}", *faults):
        print(line, file=sys.stderr)


def layout(args: argparse.Namespace, scene: Scene) -> int:
    """--points, or the scene's own layout. Raises BadInput."""
    points = scene.layout_near(USUAL_POINTS) if args.points is None else args.points
    with naming("--points"):
        scene.body_points(points)
    return points


@contextlib.contextmanager
def naming(option: str) -> Iterator[None]:
    """Faults found inside are the user's, in that option."""
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


def joints(text: str) -> tuple[int, ...] | str:
    """A type for argparse: numbers separated by commas, or all."""
    if text == ALL:
        return text
    try:
        return tuple(int(word) for word in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"needs joints such as 2,4, or all, got {text!r}") from None


def angles(text: str) -> tuple[float, ...]:
    """A type for argparse: degrees, separated by commas."""
    try:
        return tuple(float(word) for word in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"needs degrees separated by commas, such as 45,-90, got {text!r}") from None


def ranges(text: str) -> tuple[tuple[float, float], ...]:
    """A type for argparse: pairs of degrees, each low:high, separated by commas."""
    try:
        found = tuple((float(low), float(high)) for low, high in (word.split(":") for word in text.split(",")))
    except ValueError:
        raise argparse.ArgumentTypeError(f"needs ranges in degrees such as -30:60,-90:0, got {text!r}") from None
    return found


def posture(theta_deg: Iterable[float]) -> str:
    """To a thousandth of a degree: digits of less are the machine's."""
    return f"({', '.join(figure(round(angle, 3) + 0.0, '.4g', '°') for angle in theta_deg)})"


def figure(value: float, form: str, unit: str = "") -> str:
    """A dash for what is not known."""
    return "–" if np.isnan(value) else f"{value:{form}}{unit}"
