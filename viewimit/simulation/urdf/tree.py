"""Read a URDF file into plain data: all of its joints and the shapes of its links."""

import re
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from ...geometry.arrays import Floats
from ...geometry.rigid import rigid_transform, rotation_about_axis, rotation_from_rpy
from ...sensing.files import read_bytes
from .reference import MAX_BYTES, require_urdf_content

TURNING, SLIDING, FREE = ("revolute", "continuous"), ("prismatic",), ("planar", "floating")
KINDS = (*TURNING, *SLIDING, *FREE, "fixed")
SHAPES = {  # attributes of their size, with defaults
    "mesh": {"scale": "1 1 1"},
    "box": {"size": "0 0 0"},
    "cylinder": {"radius": "0", "length": "0"},
    "capsule": {"radius": "0", "length": "0"},  # length between the centres of its ends
    "sphere": {"radius": "0"},
}
ATTRIBUTES = {  # of joints and what is in them: those that are read, or that change nothing here
    "joint": {"name", "type"},
    "origin": {"xyz", "rpy", "quat_xyzw"},
    "axis": {"xyz"},
    "parent": {"link"},
    "child": {"link"},
    "limit": {"lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"},
    "mimic": {"joint", "multiplier", "offset"},
}
VERSIONS = (None, "1", "1.0", "1.1", "1.2")
MAX_PLAUSIBLE_LIMIT = 8 * np.pi  # rad: four turns; more are degrees, or no limit at all
NO_LIMIT = 1e4  # rad, from which on exporters mean that there is none
MIN_QUATERNION = 1e-6  # its length
MAX_JOINTS, MAX_SHAPES = 500, 5_000
MAX_LENGTH = 1e6  # m or rad, of all numbers but limits
MAX_LIMIT = 1e18  # some exporters write such limits for joints that have none
MIN_AXIS_LENGTH = 1e-9
MAX_QUOTED_CHARS = 80
REST_MARGIN = 0.2  # fraction of its range by which a joint of the arm at rest stays inside its limits


@dataclass(frozen=True)
class Mimic:
    """A joint's value is multiplier times that of its leader, plus offset."""

    of: str  # name of the leader
    multiplier: float
    offset: float  # rad or m


@dataclass(frozen=True)
class TreeJoint:
    """A joint of any type."""

    name: str
    kind: str  # the type that the file names
    parent: str  # link
    child: str  # link
    T_parent_joint: Floats  # (4, 4) at value 0, m
    axis: Floats  # (3,) in the joint's frame
    lower: float  # rad or m
    upper: float  # rad or m
    limited: bool  # the file gives limits
    mimic: Mimic | None

    @property
    def turns(self) -> bool:
        """Whether it is revolute or continuous."""
        return self.kind in TURNING

    @property
    def moves(self) -> bool:
        """Whether it can move, and follows no other joint."""
        return self.kind in TURNING + SLIDING and self.mimic is None and self.lower < self.upper

    @property
    def is_loose(self) -> bool:
        """Whether what hangs on it moves where nothing holds it: all but fixed joints, and those without a range."""
        return self.kind != "fixed" and not (
            self.kind in TURNING + SLIDING and self.limited and self.lower == self.upper
        )

    def touches(self, link: str) -> bool:
        """Whether this link is its parent or its child."""
        return link in (self.parent, self.child)

    def at(self, value: float) -> Floats:
        """Return T_parent_child, (4, 4), for a value [rad or m]."""
        if self.turns:
            return self.T_parent_joint @ rigid_transform(rotation_about_axis(self.axis, value))
        if self.kind in SLIDING:
            return self.T_parent_joint @ rigid_transform(np.eye(3), value * self.axis / np.linalg.norm(self.axis))
        return self.T_parent_joint


@dataclass(frozen=True)
class Shape:
    """A visible shape of a link."""

    kind: str  # of SHAPES
    T_link_shape: Floats  # (4, 4), m
    size: tuple[float, ...]  # edges, radius and length, or radius [m]; of a mesh, the scale of its axes
    file: str = ""  # of a mesh, as the URDF names it


@dataclass(frozen=True, eq=False)
class Tree:
    """The content of a URDF file."""

    path: Path
    joints: tuple[TreeJoint, ...]
    shapes: Mapping[str, tuple[Shape, ...]]  # visual shapes by link; collision shapes if no link has visual ones
    faults: tuple[str, ...]  # messages about what is not understood, left out, or looks wrong

    @property
    def links(self) -> list[str]:
        """Names of the links, in the order of the file, roots first."""
        children = [joint.child for joint in self.joints]
        return list(dict.fromkeys([*self.shapes, *(joint.parent for joint in self.joints), *children]))

    def rest(self, joint: TreeJoint, margin: float = 0.0) -> float:
        """Return the value nearest to 0 that is inside the limits by a fraction of their range [rad or m].

        A mimic joint's value follows from its leader's.
        """
        if joint.mimic is not None:
            found = next((other for other in self.joints if other.name == joint.mimic.of), None)
            known = 0.0 if found is None or found.mimic is not None else self.rest(found, margin)
            return joint.mimic.multiplier * known + joint.mimic.offset
        if joint.kind not in TURNING + SLIDING:
            return 0.0
        inside = margin * (joint.upper - joint.lower)
        return float(np.clip(0.0, joint.lower + inside, joint.upper - inside))


def read_tree(path: Path) -> Tree:
    """Read a URDF file. Raises ValueError that names the file and the joint if it cannot be read or parsed."""
    try:
        return _parsed(path, read_bytes(path, MAX_BYTES))
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}") from None


@lru_cache(8)  # every run of a study starts with it
def _parsed(path: Path, content: bytes) -> Tree:
    if not content.strip():
        raise ValueError(f"{path}: the file is empty")
    faults: list[str] = []
    try:
        root = _parsed_xml(path, content, faults)
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # LookupError: an unknown encoding
        raise ValueError(f"{path}: not a URDF that parses: {error}") from None
    require_urdf_content(path, root)
    if root.get("version") not in VERSIONS:
        faults.append(f"{path}: it is of version {_short(root.get('version', ''))!r}: what is new in it is not read")
    count = len(root.findall("joint"))
    if count > MAX_JOINTS:
        raise ValueError(f"{path}: it has {count} joints, more than {MAX_JOINTS}: keep those of the robot only")
    joints = _with_leaders(tuple(_read_joint(path, element, faults) for element in root.findall("joint")))
    links = root.findall("link")
    _require_tree(path, joints, [link.get("name", "?") for link in links])
    shapes: dict[str, tuple[Shape, ...]] = {}
    for tag in ("visual", "collision"):
        count = sum(len(link.findall(tag)) for link in links)
        if count > MAX_SHAPES:
            raise ValueError(f"{path}: its links have {count} shapes, more than {MAX_SHAPES}: simplify it")
        shapes = {link.get("name", "?"): tuple(_read_shapes(path, link, tag, faults)) for link in links}
        if any(shapes.values()):
            break
    return Tree(path, joints, shapes, tuple(faults))


def _parsed_xml(path: Path, content: bytes, faults: list[str]) -> ElementTree.Element:
    """The root element. Prefixes that are not declared, as of old Gazebo tags, are read as if they were."""
    try:
        return ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        if "unbound prefix" not in str(error):
            raise
    known = set(re.findall(rb"xmlns:([\w.-]+)\s*=", content)) | {b"xml", b"xmlns"}
    used = re.findall(rb"<\s*/?\s*([A-Za-z_][\w.-]*):[A-Za-z_]|\s([A-Za-z_][\w.-]*):[A-Za-z_][\w.-]*\s*=", content)
    unbound = sorted({name for names in used for name in names if name} - known)
    declared = b"".join(b' xmlns:%s="%s"' % (name, name) for name in unbound)
    root = ElementTree.fromstring(re.sub(rb"<robot\b", lambda found: found[0] + declared, content, count=1))
    faults.append(
        f"{path}: the prefixes {', '.join(name.decode() for name in unbound)} are not declared; read all the same"
    )
    return root


def _with_leaders(joints: tuple[TreeJoint, ...]) -> tuple[TreeJoint, ...]:
    """Let each mimic joint follow the leader of its leader."""
    mimics = {joint.name: joint.mimic for joint in joints}

    def leader(mimic: Mimic, *passed: str) -> Mimic:
        there = mimics.get(mimic.of)
        if there is None or mimic.of in passed:  # a circle has no leader
            return mimic
        gain, offset = mimic.multiplier * there.multiplier, mimic.multiplier * there.offset + mimic.offset
        return leader(Mimic(there.of, gain, offset), *passed, mimic.of)

    return tuple(joint if joint.mimic is None else replace(joint, mimic=leader(joint.mimic)) for joint in joints)


def _require_tree(path: Path, joints: tuple[TreeJoint, ...], links: list[str]) -> None:
    """Names are unique, no link is the child of two joints, and joints name links that exist, if the file has any."""
    for kind, names in (("joints", [joint.name for joint in joints]), ("links", links)):
        for name, count in Counter(names).items():
            if count > 1:
                raise ValueError(f"{path}: {count} {kind} are named {_short(name)!r}: give each a name of its own")
    above: dict[str, str] = {}
    for joint in joints:
        if joint.child in above:
            both = f"{above[joint.child]!r} and {joint.name!r}"
            raise ValueError(
                f"{path}: link {joint.child!r} hangs on two joints, {both}: the links of a URDF are a tree"
            )
        above[joint.child] = joint.name
    for joint in joints if links else ():
        for link in (joint.parent, joint.child):
            if link not in links:
                where = f"joint {_short(joint.name)!r} names the link {_short(link)!r}, which is not there"
                raise ValueError(f"{path}: {where}: name one that is, or add it")


def _read_joint(path: Path, element: ElementTree.Element, faults: list[str]) -> TreeJoint:
    name, kind = element.get("name", "?"), element.get("type", "")
    where = f"joint {name!r}"
    for part in (element, *element):
        unknown = sorted(set(part.attrib) - ATTRIBUTES[part.tag]) if part.tag in ATTRIBUTES else ()
        faults += [f"{path}: {where}: <{part.tag} {_short(one)}=…> is not understood, and left out" for one in unknown]

    def numbers(tag: str, attribute: str, default: str) -> Floats:
        return _numbers(path, where, element.find(tag), attribute, default)

    def link(tag: str) -> str:
        child = element.find(tag)
        named = None if child is None else child.get("link")
        if not named:
            raise ValueError(f"{path}: {where} has no <{tag} link=…>")
        return named

    axis = numbers("axis", "xyz", "1 0 0")
    if kind in TURNING + SLIDING and not np.linalg.norm(axis) >= MIN_AXIS_LENGTH:
        raise ValueError(f"{path}: {where}: its axis is zero")
    limits, mimic = (-np.pi, np.pi), None
    if kind != "continuous":
        limits = numbers("limit", "lower", "0")[0], numbers("limit", "upper", "0")[0]
    if kind == "revolute" and MAX_PLAUSIBLE_LIMIT < (widest := max(map(abs, limits))) < NO_LIMIT:
        faults.append(f"{path}: {where}: a limit of {widest:g} rad: if these are degrees, write radians")
    if (follows := element.find("mimic")) is not None:
        gain, offset = numbers("mimic", "multiplier", "1")[0], numbers("mimic", "offset", "0")[0]
        mimic = Mimic(follows.get("joint", "?"), gain, offset)
    ends, T_parent_joint = (link("parent"), link("child")), _origin(path, where, element)
    return TreeJoint(name, kind, *ends, T_parent_joint, axis, *limits, element.find("limit") is not None, mimic)


def _read_shapes(path: Path, link: ElementTree.Element, tag: str, faults: list[str]) -> Iterator[Shape]:
    where = f"link {link.get('name', '?')!r}"
    for drawn in link.findall(tag):
        geometry = drawn.find("geometry")
        element = None if geometry is None else next((child for child in geometry if child.tag in SHAPES), None)
        if element is None:
            kinds = [] if geometry is None else [str(child.tag) for child in geometry if isinstance(child.tag, str)]
            what = f"<{_short(kinds[0])}> is none of {', '.join(SHAPES)}" if kinds else f"a <{tag}> without a shape"
            faults.append(f"{path}: {where}: {what}: not drawn")
            continue
        defaults = SHAPES[element.tag]
        try:
            size = [_numbers(path, where, element, name, default) for name, default in defaults.items()]
            T_link_shape = _origin(path, where, drawn)
        except ValueError as error:
            faults.append(f"{error}: not drawn")
            continue
        yield Shape(element.tag, T_link_shape, tuple(np.concatenate(size).tolist()), element.get("filename", ""))


def _origin(path: Path, where: str, element: ElementTree.Element) -> Floats:
    origin = element.find("origin")
    rpy, xyz = (_numbers(path, where, origin, name, "0 0 0") for name in ("rpy", "xyz"))
    if origin is None or origin.get("quat_xyzw") is None:
        return rigid_transform(rotation_from_rpy(rpy), xyz)
    if origin.get("rpy") is not None:
        raise ValueError(f"{path}: {where}: <origin> has rpy and quat_xyzw: leave one of them out")
    quaternion = _numbers(path, where, origin, "quat_xyzw", "0 0 0 1")
    length = float(np.linalg.norm(quaternion))
    if length < MIN_QUATERNION:
        raise ValueError(f"{path}: {where}: <origin quat_xyzw={_short(origin.get('quat_xyzw', ''))!r}> is no rotation")
    axis, angle = quaternion[:3], 2 * np.arctan2(np.linalg.norm(quaternion[:3]), quaternion[3])
    turns = np.linalg.norm(axis) > MIN_QUATERNION * length
    return rigid_transform(rotation_about_axis(axis, angle) if turns else np.eye(3), xyz)


def _numbers(path: Path, where: str, element: ElementTree.Element | None, attribute: str, default: str) -> Floats:
    text = default if element is None else element.get(attribute, default)
    try:
        values = np.array([float(word) for word in text.split()]).reshape(len(default.split()))
    except ValueError:
        values = np.array([np.nan])
    if not np.isfinite(values).all():
        tag = "?" if element is None else element.tag
        if "$" in text:
            raise ValueError(f"{path}: {where}: <{tag} {attribute}={text!r}> is xacro: run it through xacro first")
        raise ValueError(f"{path}: {where}: <{tag} {attribute}={_short(text)!r}> is not numbers")
    bound = MAX_LIMIT if element is not None and element.tag == "limit" else MAX_LENGTH
    if element is not None and np.abs(values).max() > bound:
        raise ValueError(f"{path}: {where}: <{element.tag} {attribute}={_short(text)!r}> is beyond {bound:g}")
    return values


def _short(text: str) -> str:
    return text if len(text) <= MAX_QUOTED_CHARS else f"{text[:MAX_QUOTED_CHARS]}…"
