"""A URDF file as plain data: all of its joints, and what its links look like. Nothing is chosen here."""

import hashlib
import xml.etree.ElementTree as ElementTree
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...geometry.rigid import rigid_transform, rotation_about_axis, rotation_from_rpy
from ...sensing.files import read_bytes
from .reference import MOST_BYTES, require_urdf_content

TURNING, SLIDING, FREE = ("revolute", "continuous"), ("prismatic",), ("planar", "floating")
KINDS = (*TURNING, *SLIDING, *FREE, "fixed")
SHAPES = {  # attributes that say their size, and what they are where they are not said
    "mesh": {"scale": "1 1 1"},
    "box": {"size": "0 0 0"},
    "cylinder": {"radius": "0", "length": "0"},
    "sphere": {"radius": "0"},
}
MOST_JOINTS, MOST_SHAPES = 500, 5_000
MOST_LENGTH = 1e6  # m or rad, and all other numbers but limits
MOST_LIMIT = 1e18  # where some exporters put the limits of joints that have none
LEAST_AXIS = 1e-9  # its length
MOST_QUOTED = 80  # characters of what is wrong
REST_MARGIN = 0.2  # of its range, that a joint of the arm at rest stays away from its limits


@dataclass(frozen=True)
class Mimic:
    """A joint's value is multiplier times that of the joint `of`, plus offset (rad or m)."""

    of: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class TreeJoint:
    """T_parent_joint: (4, 4) at 0; axis: (3,) in the joint's frame; limits in rad or m; limited: it says some."""

    name: str
    kind: str
    parent: str
    child: str
    T_parent_joint: NDArray
    axis: NDArray
    lower: float
    upper: float
    limited: bool
    mimic: Mimic | None

    @property
    def turns(self) -> bool:
        return self.kind in TURNING

    @property
    def moves(self) -> bool:
        """By itself, and at all."""
        return self.kind in TURNING + SLIDING and self.mimic is None and self.lower < self.upper

    def at(self, value: float) -> NDArray:
        """T_parent_child (4, 4). value: rad or m."""
        if self.turns:
            return self.T_parent_joint @ rigid_transform(rotation_about_axis(self.axis, value))
        if self.kind in SLIDING:
            return self.T_parent_joint @ rigid_transform(np.eye(3), value * self.axis / np.linalg.norm(self.axis))
        return self.T_parent_joint


@dataclass(frozen=True)
class Shape:
    """What of a link is seen. kind: of SHAPES; T_link_shape: (4, 4); size: m, a box's edges, radius and length, or
    radius, and of a mesh the scale of its axes; file: of a mesh, as the URDF names it."""

    kind: str
    T_link_shape: NDArray
    size: tuple[float, ...]
    file: str = ""


@dataclass(frozen=True, eq=False)
class Tree:
    """shapes: by link, of what is seen of it, or, if nothing is of any, of what it collides with; faults: lines about
    shapes that are left out; digest: of the file's content."""

    path: Path
    joints: tuple[TreeJoint, ...]
    shapes: Mapping[str, tuple[Shape, ...]]
    faults: tuple[str, ...]
    digest: str

    @property
    def links(self) -> list[str]:
        """Their names, in the order of the file, roots first."""
        children = [joint.child for joint in self.joints]
        return list(dict.fromkeys([*self.shapes, *(joint.parent for joint in self.joints), *children]))

    def rest(self, joint: TreeJoint, margin: float = 0.0) -> float:
        """The value nearest to 0 within the limits, less a margin, a share of their range; of a joint that follows
        another one, what follows from that."""
        if joint.mimic is not None:
            found = next((other for other in self.joints if other.name == joint.mimic.of), None)
            known = 0.0 if found is None or found.mimic is not None else self.rest(found, margin)
            return joint.mimic.multiplier * known + joint.mimic.offset
        if joint.kind not in TURNING + SLIDING:
            return 0.0
        inside = margin * (joint.upper - joint.lower)
        return float(np.clip(0.0, joint.lower + inside, joint.upper - inside))


def read_tree(path: Path) -> Tree:
    """Raises ValueError that names the file, and the joint, for what cannot be read or does not parse."""
    try:
        return _parsed(path, read_bytes(path, MOST_BYTES))
    except OSError as error:
        raise ValueError(f"{path}: cannot be read: {error.strerror}") from None


@lru_cache(8)  # every run of a study begins with it
def _parsed(path: Path, content: bytes) -> Tree:
    if not content.strip():
        raise ValueError(f"{path}: the file is empty")
    try:
        root = ElementTree.fromstring(content)
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # LookupError: an unknown encoding
        raise ValueError(f"{path}: not a URDF that parses: {error}") from None
    require_urdf_content(path, root)
    count = len(root.findall("joint"))
    if count > MOST_JOINTS:
        raise ValueError(f"{path}: it has {count} joints, more than {MOST_JOINTS}: leave out what is no robot")
    joints = _with_leaders(tuple(_read_joint(path, element) for element in root.findall("joint")))
    links = root.findall("link")
    _require_one_each(path, "joints", [joint.name for joint in joints])
    _require_one_each(path, "links", [link.get("name", "?") for link in links])
    _require_tree(path, joints)
    _require_links(path, joints, {link.get("name", "?") for link in links})
    shapes: dict[str, tuple[Shape, ...]] = {}
    faults: list[str] = []
    for tag in ("visual", "collision"):
        count = sum(len(link.findall(tag)) for link in links)
        if count > MOST_SHAPES:
            raise ValueError(f"{path}: its links have {count} shapes, more than {MOST_SHAPES}: simplify it")
        shapes = {link.get("name", "?"): tuple(_read_shapes(path, link, tag, faults)) for link in links}
        if any(shapes.values()):
            break
    return Tree(path, joints, shapes, tuple(faults), hashlib.sha256(content).hexdigest())


def _with_leaders(joints: tuple[TreeJoint, ...]) -> tuple[TreeJoint, ...]:
    """Who follows a joint that follows another one, follows that one itself."""
    mimics = {joint.name: joint.mimic for joint in joints}

    def leader(mimic: Mimic, *passed: str) -> Mimic:
        there = mimics.get(mimic.of)
        if there is None or mimic.of in passed:  # one in a circle follows nobody
            return mimic
        gain, offset = mimic.multiplier * there.multiplier, mimic.multiplier * there.offset + mimic.offset
        return leader(Mimic(there.of, gain, offset), *passed, mimic.of)

    return tuple(joint if joint.mimic is None else replace(joint, mimic=leader(joint.mimic)) for joint in joints)


def _require_one_each(path: Path, kind: str, names: list[str]) -> None:
    """A name that two have would mean the one here and the other there."""
    doubled = next((name for name, count in Counter(names).items() if count > 1), None)
    if doubled is not None:
        count = names.count(doubled)
        raise ValueError(f"{path}: {count} {kind} are named {_short(doubled)!r}: give each a name of its own")


def _require_tree(path: Path, joints: tuple[TreeJoint, ...]) -> None:
    """No link hangs on two joints."""
    above: dict[str, str] = {}
    for joint in joints:
        if joint.child in above:
            raise ValueError(
                f"{path}: link {joint.child!r} hangs on two joints, {above[joint.child]!r} and {joint.name!r}: "
                "the links of a URDF are a tree"
            )
        above[joint.child] = joint.name


def _require_links(path: Path, joints: tuple[TreeJoint, ...], links: set[str]) -> None:
    """Joints hang between links that are there, unless the file is of joints alone."""
    for joint in joints if links else ():
        for link in (joint.parent, joint.child):
            if link not in links:
                raise ValueError(
                    f"{path}: joint {_short(joint.name)!r} names the link {_short(link)!r}, which is not there: "
                    "name one that is, or add it"
                )


def _read_joint(path: Path, element: ElementTree.Element) -> TreeJoint:
    name, kind = element.get("name", "?"), element.get("type", "")
    where = f"joint {name!r}"

    def numbers(tag: str, attribute: str, default: str) -> NDArray:
        return _numbers(path, where, element.find(tag), attribute, default)

    def link(tag: str) -> str:
        child = element.find(tag)
        named = None if child is None else child.get("link")
        if not named:
            raise ValueError(f"{path}: {where} has no <{tag} link=…>")
        return named

    axis = numbers("axis", "xyz", "1 0 0")
    if kind in TURNING + SLIDING and not np.linalg.norm(axis) >= LEAST_AXIS:
        raise ValueError(f"{path}: {where}: its axis is zero")
    endless, follows = kind == "continuous", element.find("mimic")
    return TreeJoint(
        name,
        kind,
        link("parent"),
        link("child"),
        _origin(path, where, element),
        axis,
        -np.pi if endless else numbers("limit", "lower", "0")[0],
        np.pi if endless else numbers("limit", "upper", "0")[0],
        element.find("limit") is not None,
        None
        if follows is None
        else Mimic(
            follows.get("joint", "?"), numbers("mimic", "multiplier", "1")[0], numbers("mimic", "offset", "0")[0]
        ),
    )


def _read_shapes(path: Path, link: ElementTree.Element, tag: str, faults: list[str]) -> Iterator[Shape]:
    where = f"link {link.get('name', '?')!r}"
    for seen in link.findall(tag):
        geometry = seen.find("geometry")
        element = None if geometry is None else next((child for child in geometry if child.tag in SHAPES), None)
        if element is None:
            continue
        defaults = SHAPES[element.tag]
        try:
            size = [_numbers(path, where, element, name, default) for name, default in defaults.items()]
            T_link_shape = _origin(path, where, seen)
        except ValueError as error:
            faults.append(f"{error}: not drawn")
            continue
        yield Shape(element.tag, T_link_shape, tuple(np.concatenate(size).tolist()), element.get("filename", ""))


def _origin(path: Path, where: str, element: ElementTree.Element) -> NDArray:
    origin = element.find("origin")
    rpy, xyz = (_numbers(path, where, origin, name, "0 0 0") for name in ("rpy", "xyz"))
    return rigid_transform(rotation_from_rpy(rpy), xyz)


def _numbers(path: Path, where: str, element: ElementTree.Element | None, attribute: str, default: str) -> NDArray:
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
    most = MOST_LIMIT if element is not None and element.tag == "limit" else MOST_LENGTH
    if element is not None and np.abs(values).max() > most:
        raise ValueError(f"{path}: {where}: <{element.tag} {attribute}={_short(text)!r}> is beyond {most:g}")
    return values


def _short(text: str) -> str:
    return text if len(text) <= MOST_QUOTED else f"{text[:MOST_QUOTED]}…"
