"""Scenes: which robots stand where, what the head looks at, and which body points are marked. TOML files."""

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
from ..geometry.arrays import Floats
from ..geometry.distortion import RadialDistortion
from ..sensing.files import is_text, parse_toml, read_toml
from .camera import Lens, StereoHead
from .robot import BodyPoint, BodyPoints, load_robot, require_joints, robot_names
from .urdf.reference import is_reference, parse_reference, require_urdf

if TYPE_CHECKING:
    from .autoscene.scene import AutoScene


Vector = tuple[float, float, float]
Limits = tuple[tuple[float, float], ...]
ROUNDING_DEG = 0.01  # URDFs round π
MAX_TOE_IN_DEG = 45.0
MAX_CHOSEN_JOINTS = 2  # a scene made for a URDF is fitted to as many moving joints
MIN_LENGTH = 1e-6  # m, px: shorter lengths count as 0
MAX_IMAGE_PX = 10_000  # width or height
MAX_EXTENDED = 16  # scenes that build on each other
MAX_TEXT = 20_000  # characters of a scene that is given as text
MAX_NUMBER = 1e6  # m, px or degrees


class RobotFileMissing(ValueError):
    """A scene file names a URDF that is not there."""


class Eye(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One camera of the head, where it differs from the head's values."""

    focal: tuple[float, float] | None = None  # focal lengths fx, fy [px]
    centre: tuple[float, float] | None = None  # principal point [px]
    distortion: tuple[float, float] = (0.0, 0.0)  # radial, k1, k2 of OpenCV's model


class Head(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The stereo head."""

    position: Vector  # midpoint between the cameras [m]
    baseline: float  # distance of the cameras [m]
    image: tuple[int, int]  # width and height [px]
    focal: float  # focal length [px]
    centre: tuple[float, float]  # principal point [px]
    gaze_demonstrator: Vector  # points that the head looks at [m]
    gaze_learner: Vector  # another such point [m]
    verged: bool = False  # each camera looks at the gaze point itself
    toe_in_deg: float = 0.0  # otherwise, rotation of each camera inwards from parallel [deg]
    undistort: tuple[float, float] = (0.0, 0.0)  # radial distortion, k1, k2, that is removed from the images
    left: Eye = Eye()  # values of one camera, instead of the head's
    right: Eye = Eye()

    def lens(self, eye: Eye) -> Lens:
        """Return the lens of one camera."""
        focal, centre = eye.focal or (self.focal, self.focal), eye.centre or self.centre
        return Lens(focal, centre, RadialDistortion(*eye.distortion), RadialDistortion(*self.undistort))


class Base(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where an arm stands."""

    position: Vector  # in the world [m]
    yaw_deg: float = 0.0  # rotation about the vertical [deg]


class Scene(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A scene file. Joints are numbered from 1, angles are in degrees, lengths in metres."""

    title: str
    robot: str  # shipped, or path of a URDF from the scene file; #base=LINK&tip=LINK&meshes=FOLDER may follow
    moving_joints: tuple[int, ...]  # those that imitate
    range_deg: Limits  # lowest and highest angle of each moving joint [deg]
    posture_deg: tuple[float, ...]  # of all joints [deg]: at rest, and the moving ones at the demonstrator's start
    start_deg: tuple[float, ...]  # of the moving joints, at the learner's start [deg]
    head: Head
    demonstrator: Base
    learner: Base
    points: dict[str, tuple[BodyPoint, ...]]  # (link, x, y, z) [m] of each, by their number
    size: float = 1.0  # scale of the page's drawings around the arms; 1 suits a robot of one metre

    @property
    def moving(self) -> NDArray[np.int_]:
        """(m,) indices of the moving joints, from 0."""
        return np.array(self.moving_joints) - 1

    @property
    def lower(self) -> Floats:
        """(m,) lower limits of the moving joints [rad]."""
        return np.radians([low for low, _ in self.range_deg])

    @property
    def upper(self) -> Floats:
        """(m,) upper limits of the moving joints [rad]."""
        return np.radians([high for _, high in self.range_deg])

    def stereo_head(self) -> StereoHead:
        """Return the head's cameras."""
        head = self.head
        width, height = head.image
        lenses = head.lens(head.left), head.lens(head.right)
        toe_in = float(np.radians(head.toe_in_deg))
        return StereoHead(head.position, head.baseline, width, height, *lenses, head.verged, toe_in)

    def body_points(self, count: int) -> BodyPoints:
        """Return the layout with `count` points. Raises ValueError that lists the layouts."""
        if str(count) not in self.points:
            there = ", ".join(self.points) or "none"
            raise ValueError(f"no layout of {count} points in this scene; it has {there}")
        rows = np.array(self.points[str(count)])
        return BodyPoints(rows[:, 0].astype(int), rows[:, 1:])

    def layout_near(self, count: int) -> int:
        """Return the number of points of the layout nearest to `count`; `count` itself if there is no layout."""
        return min(map(int, self.points), key=lambda points: abs(points - count), default=count)

    def require_posture(self, theta: ArrayLike, whose: str) -> Floats:
        """Return a copy of a posture, (m,) rad. Raises ValueError for a wrong count, NaN or limits exceeded."""
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


def scene_names() -> list[str]:
    """Return the names of the shipped scenes."""
    return sorted(path.stem for path in (ROOT / "scenes").glob("*.toml"))


def load_scene(
    name: str | Path = "panda",
    robot: str | Path | None = None,
    joints: tuple[int, ...] | None = None,
    undistort: tuple[float, float] | None = None,
    body_points: Sequence[BodyPoint] | None = None,
) -> Scene:
    """Load a scene, and change parts of it.

    Parameters
    ----------
    name : str or Path
        One of: a shipped scene by name; the path of a TOML file, where `extends = "panda"` takes the other fields
        from the scene of that name beside the file, or else from the shipped one; the path of a URDF, for which a
        scene is made; or the text of a scene file, which ends with a newline and may name shipped scenes and robots
        only.
    robot : str or Path, optional
        Another robot, by name or URDF, with the same bases, limits and points in its links' frames. A URDF of the same
        file name as the scene's is the same robot in another place.
    joints : tuple of int, optional
        Numbers from 1 of the joints that move. Joints that the scene holds at rest get the robot's limits and start at
        rest.
    undistort : (k1, k2), optional
        Instead of the head's.
    body_points : sequence of (link, x, y, z), optional
        The only layout, instead of the scene's.

    Returns
    -------
    Scene
        Robots, bases, cameras and joint limits.

    Raises
    ------
    ValueError
        Names the file and the field, or the joints.
    RobotFileMissing
        The scene's URDF is not there.
    """
    place, read = _source(name, joints)
    if robot is not None:
        load_robot(robot)  # its faults are not the scene's
    try:
        scene = _converted(read())
        path = None if is_text(name) or is_reference(name) else Path(place)
        scene = msgspec.structs.replace(scene, robot=_robot_of(scene, path, robot))
        if undistort is not None:
            scene = msgspec.structs.replace(scene, head=msgspec.structs.replace(scene.head, undistort=undistort))
        if body_points is not None:
            scene = msgspec.structs.replace(scene, points={str(len(body_points)): tuple(body_points)})
        _require_valid(scene)
    except RobotFileMissing as error:
        raise RobotFileMissing(f"{place}: {error}") from None
    except RecursionError:
        raise ValueError(f"{place}: it nests too deeply") from None
    except ValueError as error:
        raise ValueError(f"{place}: {error}") from None
    return scene if joints is None else _with_moving_joints(scene, joints)


def extended(scene: Scene, fields: Mapping[str, Any]) -> Scene:
    """Return the scene of a file that extends this one with these fields. Raises ValueError that names the field."""
    scene = _converted(merged(msgspec.to_builtins(scene), dict(fields)))
    _require_valid(scene)
    return scene


def _converted(fields: Mapping[str, Any]) -> Scene:
    """The scene of these fields. Raises ValueError that names the field of another type."""
    try:
        return msgspec.convert(fields, Scene)
    except msgspec.MsgspecError as error:  # no ValueError before msgspec 0.21
        raise ValueError(str(error)) from None


def scene_for_urdf(name: str | Path, joints: tuple[int, ...] | None = None) -> "AutoScene":
    """Make a scene for a URDF, fitted to the joints that move if they are at most MAX_CHOSEN_JOINTS.

    Raises ValueError as `load_scene`.
    """
    from .autoscene.scene import make_scene  # loads trimesh

    if joints is not None:
        require_joints(load_robot(name), joints)
    return make_scene(parse_reference(name), joints if joints and len(joints) <= MAX_CHOSEN_JOINTS else None)


def _source(name: str | Path, joints: tuple[int, ...] | None) -> tuple[str | Path, Callable[[], dict[str, Any]]]:
    """What error messages call a scene, and a function that reads its fields. Raises ValueError for no scene."""
    if is_text(name):
        return "the scene", lambda: _read_text(str(name))
    require_urdf(name)
    if is_reference(name):
        made = scene_for_urdf(name, joints)
        return parse_reference(name).path, lambda: made.fields
    path = Path(name) if str(name).lower().endswith(".toml") else ROOT / "scenes" / f"{name}.toml"
    if not path.is_file():
        raise ValueError(
            f"no scene {str(name)!r}; there are {', '.join(scene_names())}, or the path of a .toml or .urdf file"
        )
    return path, lambda: _read_file(path)


def _read_file(path: Path, above: tuple[Path, ...] = ()) -> dict[str, Any]:
    """Fields of a scene file and the scenes that it extends, unchecked. above: the files that build on this one."""
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
    if len(above) > MAX_EXTENDED:
        raise ValueError(f"extends {parent!r}: more than {MAX_EXTENDED} scenes build on each other")
    return merged(_read_file(below, above), fields)


def _read_text(text: str) -> dict[str, Any]:
    """Fields of a scene given as text, unchecked. It may come from anywhere, so it opens shipped files only."""
    if len(text) > MAX_TEXT:
        raise ValueError(f"it has {len(text)} characters, more than {MAX_TEXT}")
    fields = dict(_decoded(text.encode()))
    parent = fields.pop("extends", None)
    if parent is not None:
        if parent not in scene_names():
            raise ValueError(f"extends {str(parent)[:40]!r}, which is no shipped scene")
        fields = merged(_read_file(ROOT / "scenes" / f"{parent}.toml"), fields)
    if fields.get("robot") not in robot_names():
        raise ValueError(f"its robot, {str(fields.get('robot'))[:40]!r}, is none of {', '.join(robot_names())}")
    return fields


@lru_cache(16)  # every run of a study starts with it
def _decoded(content: bytes) -> dict[str, Any]:
    fields = parse_toml(content)
    _require_finite(fields)
    return fields


def merged(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    """Return both, table by table. `above` wins."""
    fields = dict(below)
    for key, value in above.items():
        both = isinstance(value, dict) and isinstance(below.get(key), dict)
        fields[key] = merged(below[key], value) if both else value
    return fields


def _require_finite(value: Any, name: str = "") -> None:
    """TOML has nan, inf, and numbers too large to compute with."""
    if isinstance(value, (int, float)) and not abs(value) <= MAX_NUMBER:
        finite = isinstance(value, int) or np.isfinite(value)
        expected = f"within ±{MAX_NUMBER:g}" if finite else "a finite number"
        raise ValueError(f"{name} is {str(value)[:20]}, not {expected}")
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        _require_finite(item, f"{name}.{key}".lstrip("."))


def _robot_of(scene: Scene, path: Path | None, robot: str | Path | None) -> str:
    """The scene's robot, a URDF from the scene's file, or `robot` instead. Raises RobotFileMissing.

    A URDF of the same file name keeps the scene's base and tip. path: of the file, None for a scene without one.
    """
    own = parse_reference(scene.robot) if is_reference(scene.robot) else None
    if robot is not None:
        found = parse_reference(robot) if is_reference(robot) else None
        if found is None or own is None or found.path.name != own.path.name or (found.base, found.tip) != (None, None):
            return str(robot)
        return str(replace(own, path=found.path, meshes=found.meshes or own.meshes))
    if own is None or path is None:
        return scene.robot
    beside = path.parent / own.path
    if not beside.is_file():
        raise RobotFileMissing(f"its robot, {beside}, is not there: put it there, or name it by --robot")
    return str(replace(own, path=beside, meshes=None if own.meshes is None else path.parent / own.meshes))


def _with_moving_joints(scene: Scene, joints: tuple[int, ...]) -> Scene:
    robot = load_robot(scene.robot)
    require_joints(robot, joints)
    known = dict(zip(scene.moving_joints, zip(scene.range_deg, scene.start_deg)))
    rest = {}
    for joint, posture in zip(joints, np.array(scene.posture_deg)[np.array(joints) - 1].tolist()):
        limits = np.degrees((robot.joints[joint - 1].lower, robot.joints[joint - 1].upper))
        rest[joint] = (tuple(limits.round(6).tolist()), posture)
    ranges, starts = zip(*(known.get(joint, rest[joint]) for joint in joints))
    return msgspec.structs.replace(scene, moving_joints=tuple(joints), range_deg=ranges, start_deg=starts)


def _require_valid(scene: Scene) -> None:
    """Check what types cannot express. Raises ValueError that names the field."""
    robot = load_robot(scene.robot)
    limits = tuple((joint.lower, joint.upper) for joint in robot.joints)
    _require_valid_for(msgspec.msgpack.encode(scene), robot.name, limits)


@lru_cache(16)  # every run of a study starts with it
def _require_valid_for(encoded: bytes, robot: str, limits: Limits) -> None:
    """As `_require_valid`, for an encoded scene, the name of its robot, and the limits of all joints [rad]."""
    scene = msgspec.msgpack.decode(encoded, type=Scene)
    _require_joints(scene, robot, limits)
    _require_head(scene.head)
    _require_gaze(scene)
    if scene.size <= 0:
        raise ValueError(f"size must be more than 0, got {scene.size:g}")
    _require_layouts(scene, len(limits))
    scene.require_posture(np.radians(scene.posture_deg)[scene.moving], "demonstrator's")
    scene.require_posture(np.radians(scene.start_deg), "learner's start")


def _require_joints(scene: Scene, robot: str, limits: Limits) -> None:
    """Moving joints are listed once, each with a range, and all angles are within the robot's limits."""
    n, m = len(limits), len(scene.moving_joints)
    if len(scene.posture_deg) != n:
        raise ValueError(f"posture_deg has {len(scene.posture_deg)} angles, but {robot} has {n} joints")
    if list(scene.moving_joints) != sorted(scene.moving_joints):
        raise ValueError(f"moving_joints {list(scene.moving_joints)} must ascend, base to tip")
    if not 0 < m == len(set(scene.moving_joints)) == len(scene.range_deg) == len(scene.start_deg):
        raise ValueError("moving_joints, range_deg and start_deg must name the same joints once each")
    limits_deg = np.degrees(limits)
    for joint, (low, high) in zip(scene.moving_joints, scene.range_deg):
        if not 1 <= joint <= n:
            raise ValueError(f"{robot} has no joint {joint}; its joints are 1 … {n}")
        if not low < high:
            raise ValueError(f"joint {joint}: range_deg {low:g} … {high:g} is empty")
        lower, upper = limits_deg[joint - 1]
        if low < lower - ROUNDING_DEG or high > upper + ROUNDING_DEG:
            raise ValueError(
                f"joint {joint}: range_deg {low:g} … {high:g} is more than {robot} turns, {lower:.4g} … {upper:.4g}"
            )
    for joint, (angle, (lower, upper)) in enumerate(zip(scene.posture_deg, limits_deg), 1):
        if not lower - ROUNDING_DEG <= angle <= upper + ROUNDING_DEG:
            raise ValueError(
                f"posture_deg: joint {joint} at {angle:g}° is outside its limits {lower:.4g}° … {upper:.4g}°"
            )


def _require_head(head: Head) -> None:
    """Lenses cover their whole images, and cameras are turned in one way only."""
    if not 0 <= head.toe_in_deg <= MAX_TOE_IN_DEG:
        raise ValueError(f"head.toe_in_deg must be between 0 and {MAX_TOE_IN_DEG:g}, got {head.toe_in_deg:g}")
    if head.verged and head.toe_in_deg:
        raise ValueError("head: cameras that are verged look at the gaze point: leave toe_in_deg out")
    for name, length in (("baseline", head.baseline), ("focal", head.focal)):
        if not length >= MIN_LENGTH:
            raise ValueError(f"head.{name} must be more than 0, got {length:g}")
    if not all(1 <= edge <= MAX_IMAGE_PX for edge in head.image):
        raise ValueError(f"head.image must be 1 to {MAX_IMAGE_PX} px wide and high, got {list(head.image)}")
    corners = np.array([[x, y] for x in (0, head.image[0]) for y in (0, head.image[1])], float)
    for name, eye in (("left", head.left), ("right", head.right)):
        try:
            lens = head.lens(eye)
        except ValueError as error:
            raise ValueError(f"head.{name}: {error}") from None
        if not min(lens.focal) >= MIN_LENGTH:
            raise ValueError(f"head.{name}: focal lengths must be more than 0, got {lens.focal}")
        if not lens.covers(corners):
            corrected = f", undistorted by {head.undistort}," if lens.correction.bends else ""
            raise ValueError(f"head.{name}: distortion {eye.distortion}{corrected} folds its image before the corners")


def _require_gaze(scene: Scene) -> None:
    """The head looks at two points, neither directly above nor below it."""
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
    """Each layout has the number of points in its name, on links of the robot, enough of them different."""
    for count, layout in scene.points.items():
        if count != str(len(layout)) or not layout:
            raise ValueError(f"points.{count} has {len(layout) or 'no'} points")
        if any(not 0 <= link <= links for link, *_ in layout):
            raise ValueError(f"points.{count}: links are 0 … {links}")
        if not np.isfinite(np.array(layout, float)).all():
            raise ValueError(f"points.{count}: not all numbers are finite")
        if len(set(layout)) < min(len(layout), MIN_POINTS):
            raise ValueError(f"points.{count}: only {len(set(layout))} points differ, at least {MIN_POINTS} must")
