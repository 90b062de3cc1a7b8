"""Scenes: which robots stand where, what the head looks at, which body points are marked. TOML files."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assets import ROOT
from ..geometry.affine import MIN_POINTS
from ..geometry.distortion import Radial
from ..sensing.files import is_text, parse_toml, read_toml
from .camera import Lens, StereoHead
from .robot import BodyPoint, BodyPoints, load_robot, require_joints, robot_names
from .urdf.reference import is_reference, parse_reference, require_urdf

if TYPE_CHECKING:
    from .autoscene.scene import AutoScene

Vector = tuple[float, float, float]
Limits = tuple[tuple[float, float], ...]
ROUNDING_DEG = 0.01  # URDFs round π
MOST_TOE_IN_DEG = 45.0
MAX_CHOSEN_JOINTS = 2  # for as many, a scene is made about those that move
LEAST_LENGTH = 1e-6  # m, px: what is less is nothing
MOST_IMAGE_PX = 10_000  # an edge


class RobotFileMissing(ValueError):
    """A scene file names a URDF that is not there."""


class Eye(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What one camera of the head has for itself: focal lengths (x, y) and centre px, in place of the head's, and
    radial distortion (k1, k2) by OpenCV's model."""

    focal: tuple[float, float] | None = None
    centre: tuple[float, float] | None = None
    distortion: tuple[float, float] = (0.0, 0.0)


class Head(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The stereo head: position m, baseline m, image and focal length px, gaze points m.

    toe_in_deg: how far each camera is turned inwards from parallel, if they are not `verged` on the gaze point;
    undistort: (k1, k2) of the distortion that images are rid of before anybody sees them.
    """

    position: Vector
    baseline: float
    image: tuple[int, int]
    focal: float
    centre: tuple[float, float]
    gaze_demonstrator: Vector
    gaze_learner: Vector
    verged: bool = False
    toe_in_deg: float = 0.0
    undistort: tuple[float, float] = (0.0, 0.0)
    left: Eye = Eye()
    right: Eye = Eye()

    def lens(self, eye: Eye) -> Lens:
        focal, centre = eye.focal or (self.focal, self.focal), eye.centre or self.centre
        return Lens(focal, centre, Radial(*eye.distortion), Radial(*self.undistort))


class Base(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where an arm stands: position m, yaw about the vertical in degrees."""

    position: Vector
    yaw_deg: float = 0.0


class Scene(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A scene file. Joints are numbered from 1, angles are in degrees, lengths in metres.

    robot: a robot of assets/robots or the path of a URDF, from the scene file, after which #base=LINK&tip=LINK may
    say where the arm begins and ends; moving_joints: those that imitate;
    range_deg: their limits here; posture_deg: all joints at rest, the moving ones as the
    demonstrator starts; start_deg: the learner's moving joints at the start;
    points: layouts by their number of points, each [link, x, y, z] on the body;
    size: how large the page draws what stands around the arms, in a scene of a robot of a metre 1.
    """

    title: str
    robot: str
    moving_joints: tuple[int, ...]
    range_deg: tuple[tuple[float, float], ...]
    posture_deg: tuple[float, ...]
    start_deg: tuple[float, ...]
    head: Head
    demonstrator: Base
    learner: Base
    points: dict[str, tuple[BodyPoint, ...]]
    size: float = 1.0

    @property
    def moving(self) -> NDArray:
        """(m,) indices of the moving joints, from 0"""
        return np.array(self.moving_joints) - 1

    @property
    def lower(self) -> NDArray:
        """(m,) rad"""
        return np.radians([low for low, _ in self.range_deg])

    @property
    def upper(self) -> NDArray:
        """(m,) rad"""
        return np.radians([high for _, high in self.range_deg])

    def stereo_head(self) -> StereoHead:
        head = self.head
        width, height = head.image
        lenses = head.lens(head.left), head.lens(head.right)
        toe_in = float(np.radians(head.toe_in_deg))
        return StereoHead(head.position, head.baseline, width, height, *lenses, head.verged, toe_in)

    def body_points(self, count: int) -> BodyPoints:
        """The layout with `count` points. Raises ValueError naming the layouts there are."""
        if str(count) not in self.points:
            there = ", ".join(self.points) or "none"
            raise ValueError(f"no layout of {count} points in this scene; it has {there}")
        rows = np.array(self.points[str(count)])
        return BodyPoints(rows[:, 0].astype(int), rows[:, 1:])

    def layout_near(self, count: int) -> int:
        """The number of points of the layout whose number is nearest to `count`; `count` itself if there is none."""
        return min(map(int, self.points), key=lambda points: abs(points - count), default=count)

    def require_posture(self, theta: ArrayLike, whose: str) -> NDArray:
        """theta: (m,) rad, checked → a copy. Raises ValueError for a wrong count, NaN or beyond the limits."""
        theta = np.array(theta, float)
        if theta.shape != (len(self.moving_joints),):
            raise ValueError(
                f"{whose} posture needs {len(self.moving_joints)} angles, of joints "
                f"{', '.join(map(str, self.moving_joints))}, got {theta.size}"
            )
        for joint, angle, (low, high) in zip(self.moving_joints, np.degrees(theta), self.range_deg):
            if not low - 1e-6 <= angle <= high + 1e-6:  # NaN fails too
                raise ValueError(f"{whose} joint {joint} at {angle:g}° is outside its limits {low:g}° … {high:g}°")
        return np.clip(theta, self.lower, self.upper)


def load_scene(
    name: str | Path = "panda",
    robot: str | Path | None = None,
    joints: tuple[int, ...] | None = None,
    undistort: tuple[float, float] | None = None,
    body_points: Sequence[BodyPoint] | None = None,
) -> Scene:
    """A shipped scene by name, or a TOML file by path; `extends = "panda"` takes over what is not repeated from the
    scene of that name beside the file, or else from the shipped one. Or a URDF by path, for which a scene is made. Or
    all that a scene file says, as text that ends with a line: of shipped scenes and robots alone.

    robot: another one, by name or URDF, in place of the scene's: same bases, limits and points in its links' frames. A
    URDF of the same file name as the scene's is taken to be that one, elsewhere.
    joints: numbers from 1 of the joints that move, in place of the scene's; those that it holds at rest have the
    robot's limits and start at rest. undistort: (k1, k2) in place of the head's. body_points: the only layout, in place
    of the scene's.
    Raises ValueError that names the file and the field, or the joints that were asked for; RobotFileMissing where the
    scene's URDF is missing.
    """
    place, read = _source(name, joints)
    if robot is not None:
        load_robot(robot)  # its own faults are not the scene's
    try:
        scene = _converted(read())
        path = None if is_text(name) or is_reference(name) else Path(place)
        scene = msgspec.structs.replace(scene, robot=_robot_of(scene, path, robot))
        if undistort is not None:
            scene = msgspec.structs.replace(scene, head=msgspec.structs.replace(scene.head, undistort=undistort))
        if body_points is not None:
            scene = msgspec.structs.replace(scene, points={str(len(body_points)): tuple(body_points)})
        _require_possible(scene)
    except RobotFileMissing as error:
        raise RobotFileMissing(f"{place}: {error}") from None
    except (msgspec.DecodeError, msgspec.ValidationError, ValueError) as error:
        raise ValueError(f"{place}: {error}") from None
    return scene if joints is None else _freed(scene, joints)


def _source(name: str | Path, joints: tuple[int, ...] | None) -> tuple[str | Path, Callable[[], dict]]:
    """What a scene is called in what is said of its faults, and what reads its fields. Raises ValueError for none."""
    if is_text(name):
        return "the scene", lambda: read_text(str(name))
    require_urdf(name)
    if is_reference(name):
        made = scene_for_urdf(name, joints)
        return parse_reference(name).path, lambda: made.fields
    path = Path(name) if str(name).lower().endswith(".toml") else ROOT / "scenes" / f"{name}.toml"
    if not path.is_file():
        raise ValueError(
            f"no scene {str(name)!r}; there are {', '.join(scene_names())}, or the path of a .toml or .urdf file"
        )
    return path, lambda: read_fields(path)


def extended(scene: Scene, fields: Mapping[str, Any]) -> Scene:
    """As a scene file that extends this one has it, with these fields. Raises ValueError that names the field."""
    scene = msgspec.convert(merged(msgspec.to_builtins(scene), dict(fields)), Scene)
    _require_possible(scene)
    return scene


def scene_for_urdf(name: str | Path, joints: tuple[int, ...] | None = None) -> "AutoScene":
    """What is chosen for the URDF of a reference. joints: that move, if they are few enough to choose all else by them.

    Raises ValueError as `load_scene`.
    """
    from .autoscene.scene import make_scene  # loads trimesh

    if joints is not None:
        require_joints(load_robot(name), joints)
    return make_scene(parse_reference(name), joints if joints and len(joints) <= MAX_CHOSEN_JOINTS else None)


def _converted(fields: dict) -> Scene:
    try:
        return msgspec.convert(fields, Scene)
    except RecursionError:
        raise ValueError("it nests too deeply") from None


def _robot_of(scene: Scene, path: Path | None, robot: str | Path | None) -> str:
    """The scene's own, a URDF from the scene's file, or `robot` in its place: a URDF of the same name is taken from the
    same base to the same tip. path: of the file, None for a scene without one. Raises RobotFileMissing."""
    own = parse_reference(scene.robot) if is_reference(scene.robot) else None
    if robot is not None:
        found = parse_reference(robot) if is_reference(robot) else None
        if found is None or own is None or found.path.name != own.path.name or (found.base, found.tip) != (None, None):
            return str(robot)
        return str(replace(own, path=found.path))
    if own is None or path is None:
        return scene.robot
    beside = path.parent / own.path
    if not beside.is_file():
        raise RobotFileMissing(f"its robot, {beside}, is not there: put it there, or name it by --robot")
    return str(replace(own, path=beside))


def _freed(scene: Scene, joints: tuple[int, ...]) -> Scene:
    """The scene with other joints moving."""
    robot = load_robot(scene.robot)
    require_joints(robot, joints)
    known = dict(zip(scene.moving_joints, zip(scene.range_deg, scene.start_deg)))
    rest = {}
    for joint, posture in zip(joints, np.array(scene.posture_deg)[np.array(joints) - 1].tolist()):
        limits = np.degrees((robot.joints[joint - 1].lower, robot.joints[joint - 1].upper))
        rest[joint] = (tuple(limits.round(6).tolist()), posture)
    ranges, starts = zip(*(known.get(joint, rest[joint]) for joint in joints))
    return msgspec.structs.replace(scene, moving_joints=tuple(joints), range_deg=ranges, start_deg=starts)


def _require_possible(scene: Scene) -> None:
    """What types cannot say. Raises ValueError that names the field."""
    robot = load_robot(scene.robot)
    limits = tuple((joint.lower, joint.upper) for joint in robot.joints)
    _require_possible_of(msgspec.msgpack.encode(scene), robot.name, limits)


@lru_cache(16)  # every run of a study begins with it
def _require_possible_of(told: bytes, robot: str, limits: Limits) -> None:
    """told: all that a scene says; robot: the name of its robot; limits: of all of that one's joints, rad."""
    scene = msgspec.msgpack.decode(told, type=Scene)
    _require_joints(scene, robot, limits)
    _require_head(scene.head)
    _require_gaze(scene)
    if scene.size <= 0:
        raise ValueError(f"size must be more than 0, got {scene.size:g}")
    _require_layouts(scene, len(limits))
    scene.require_posture(np.radians(scene.posture_deg)[scene.moving], "demonstrator's")
    scene.require_posture(np.radians(scene.start_deg), "learner's start")


def _require_joints(scene: Scene, robot: str, limits: Limits) -> None:
    """Those that move are named once each, with a range, and none is held or may go where it cannot turn."""
    n, m = len(limits), len(scene.moving_joints)
    if len(scene.posture_deg) != n:
        raise ValueError(f"posture_deg has {len(scene.posture_deg)} angles, but {robot} has {n} joints")
    if list(scene.moving_joints) != sorted(scene.moving_joints):
        raise ValueError(f"moving_joints {list(scene.moving_joints)} must ascend, base to tip")
    if not 0 < m == len(set(scene.moving_joints)) == len(scene.range_deg) == len(scene.start_deg):
        raise ValueError("moving_joints, range_deg and start_deg must name the same joints once each")
    turns = np.degrees(limits)
    for joint, (low, high) in zip(scene.moving_joints, scene.range_deg):
        if not 1 <= joint <= n:
            raise ValueError(f"{robot} has no joint {joint}; its joints are 1 … {n}")
        if not low < high:
            raise ValueError(f"joint {joint}: range_deg {low:g} … {high:g} is empty")
        least, most = turns[joint - 1]
        if low < least - ROUNDING_DEG or high > most + ROUNDING_DEG:
            raise ValueError(
                f"joint {joint}: range_deg {low:g} … {high:g} is more than {robot} turns, {least:.4g} … {most:.4g}"
            )
    for joint, (angle, (least, most)) in enumerate(zip(scene.posture_deg, turns), 1):
        if not least - ROUNDING_DEG <= angle <= most + ROUNDING_DEG:
            raise ValueError(
                f"posture_deg: joint {joint} at {angle:g}° is outside its limits {least:.4g}° … {most:.4g}°"
            )


def _require_head(head: Head) -> None:
    """Lenses show all of their images, and cameras are turned in one way."""
    if not 0 <= head.toe_in_deg <= MOST_TOE_IN_DEG:
        raise ValueError(f"head.toe_in_deg must be between 0 and {MOST_TOE_IN_DEG:g}, got {head.toe_in_deg:g}")
    if head.verged and head.toe_in_deg:
        raise ValueError("head: cameras that are verged look at the gaze point: leave toe_in_deg out")
    for what, length in (("baseline", head.baseline), ("focal", head.focal)):
        if not length >= LEAST_LENGTH:
            raise ValueError(f"head.{what} must be more than 0, got {length:g}")
    if not all(1 <= edge <= MOST_IMAGE_PX for edge in head.image):
        raise ValueError(f"head.image must be 1 to {MOST_IMAGE_PX} px wide and high, got {list(head.image)}")
    corners = np.array([[x, y] for x in (0, head.image[0]) for y in (0, head.image[1])], float)
    for name, eye in (("left", head.left), ("right", head.right)):
        try:
            lens = head.lens(eye)
        except ValueError as error:
            raise ValueError(f"head.{name}: {error}") from None
        if not min(lens.focal) >= LEAST_LENGTH:
            raise ValueError(f"head.{name}: focal lengths must be more than 0, got {lens.focal}")
        if not lens.shows(corners):
            told = f"{eye.distortion}, undistorted by {head.undistort}," if lens.undone.bends else f"{eye.distortion}"
            raise ValueError(f"head.{name}: distortion {told} folds its image before the corners")


def _require_gaze(scene: Scene) -> None:
    """The head is turned towards two places, neither of them right above or below it."""
    head = scene.stereo_head()
    for name in ("gaze_demonstrator", "gaze_learner"):
        target = getattr(scene.head, name)
        try:
            head.gaze(target)
        except ValueError:
            raise ValueError(
                f"head.{name} {list(target)} must not be at, right above or right below head.position "
                f"{list(scene.head.position)}, where no side of an image is up"
            ) from None


def _require_layouts(scene: Scene, links: int) -> None:
    """Each has as many points as it is called by, on links of the robot, in enough places for a transfer."""
    for count, layout in scene.points.items():
        if count != str(len(layout)) or not layout:
            raise ValueError(f"points.{count} has {len(layout) or 'no'} points")
        if any(not 0 <= link <= links for link, *_ in layout):
            raise ValueError(f"points.{count}: links are 0 … {links}")
        if not np.isfinite(np.array(layout, float)).all():
            raise ValueError(f"points.{count}: not all numbers are finite")
        if len(set(layout)) < min(len(layout), MIN_POINTS):
            raise ValueError(f"points.{count}: only {len(set(layout))} points differ, at least {MIN_POINTS} must")


# What a scene file says, with all that it takes over from the scenes it extends.

MOST_EXTENDED = 16  # scenes that one builds on
MOST_TEXT = 20_000  # characters of a scene that is told in full
MOST_NUMBER = 1e6  # of anything in a scene: m, px or degrees


def scene_names() -> list[str]:
    """Names of the shipped scenes."""
    return sorted(path.stem for path in (ROOT / "scenes").glob("*.toml"))


def read_fields(path: Path, above: tuple[Path, ...] = ()) -> dict:
    """Before their types are checked. above: scenes that build on this one."""
    fields = dict(_decoded(read_toml(path)))
    if "extends" not in fields:
        return fields
    above = (*above, path.resolve())
    parent = fields.pop("extends")
    beside, shipped = (folder / f"{parent}.toml" for folder in (path.parent, ROOT / "scenes"))
    if not (beside.is_file() or shipped.is_file()):
        raise ValueError(f"extends {parent!r}, but there is no {beside}, nor a shipped scene of that name")
    below = beside if beside.is_file() else shipped
    if below.resolve() in above:
        raise ValueError(f"extends {parent!r}, which builds on it: a scene cannot build on itself")
    if len(above) > MOST_EXTENDED:
        raise ValueError(f"extends {parent!r}: more than {MOST_EXTENDED} scenes build on each other")
    return merged(read_fields(below, above), fields)


def read_text(text: str) -> dict:
    """Wherever it comes from, it opens no file but those that are shipped."""
    if len(text) > MOST_TEXT:
        raise ValueError(f"it has {len(text)} characters, more than {MOST_TEXT}")
    fields = dict(_decoded(text.encode()))
    parent = fields.pop("extends", None)
    if parent is not None:
        if parent not in scene_names():
            raise ValueError(f"extends {str(parent)[:40]!r}, which is no shipped scene")
        fields = merged(read_fields(ROOT / "scenes" / f"{parent}.toml"), fields)
    if fields.get("robot") not in robot_names():
        raise ValueError(f"its robot, {str(fields.get('robot'))[:40]!r}, is none of {', '.join(robot_names())}")
    return fields


@lru_cache(16)  # every run of a study begins with it
def _decoded(content: bytes) -> dict:
    fields = parse_toml(content)
    try:
        _require_finite(fields)
    except RecursionError:
        raise ValueError("it nests too deeply") from None
    return fields


def merged(below: dict, above: dict) -> dict:
    """above: wins, table by table."""
    fields = dict(below)
    for key, value in above.items():
        both = isinstance(value, dict) and isinstance(below.get(key), dict)
        fields[key] = merged(below[key], value) if both else value
    return fields


def _require_finite(value, name: str = "") -> None:
    """TOML can say nan, inf, and more than anybody can compute with."""
    if isinstance(value, (int, float)) and not abs(value) <= MOST_NUMBER:
        finite = isinstance(value, int) or np.isfinite(value)
        wanted = f"within ±{MOST_NUMBER:g}" if finite else "a finite number"
        raise ValueError(f"{name} is {str(value)[:20]}, not {wanted}")
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        _require_finite(item, f"{name}.{key}".lstrip("."))
