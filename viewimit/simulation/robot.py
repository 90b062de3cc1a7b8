"""A serial arm read from a URDF: joint limits, batched forward kinematics, points on its body."""

import xml.etree.ElementTree as ElementTree
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..geometry.rigid import rigid_transform, rotation_about_axis, rotation_from_rpy

IDENTITY = np.eye(4)
Angles = Sequence[ArrayLike] | NDArray  # one array a joint, rad, broadcast against each other


@dataclass(frozen=True)
class Joint:
    """A revolute joint. T_parent_joint: (4, 4) at angle 0; axis: (3,) in the joint's frame; limits in rad."""

    name: str
    T_parent_joint: NDArray
    axis: NDArray
    lower: float
    upper: float


@dataclass(frozen=True)
class BodyPoints:
    """N points fixed to the body. link: (N,) 0 = base, i = moved by joint i; local: (N, 3) m in that link's frame."""

    link: NDArray
    local: NDArray

    def __len__(self) -> int:
        return len(self.link)


@dataclass(frozen=True)
class Robot:
    """The chain of revolute joints of one arm, base to tip."""

    name: str
    joints: tuple[Joint, ...]

    @property
    def lower(self) -> NDArray:
        """(n,) rad"""
        return np.array([joint.lower for joint in self.joints])

    @property
    def upper(self) -> NDArray:
        """(n,) rad"""
        return np.array([joint.upper for joint in self.joints])

    def link_frames(self, angles: ArrayLike, T_world_base: NDArray = IDENTITY) -> NDArray:
        """T_world_link of every link for one posture. angles: (n,) rad → (n + 1, 4, 4)."""
        angle = np.array(angles, float).reshape(-1, 1, 1)
        rest, sine, rise = self._turns  # all joints are turned at once, for every call of numpy takes its time
        steps = rest + np.sin(angle) * sine + (1 - np.cos(angle)) * rise
        frames = np.empty((len(self.joints) + 1, 4, 4))
        frames[0] = T_world_base
        for i, step in enumerate(steps):
            np.matmul(frames[i], step, out=frames[i + 1])
        return frames

    @cached_property
    def _turns(self) -> NDArray:
        """(3, n, 4, 4): what T_parent_link is made of by 1, sin and 1 - cos of a joint's angle (Rodrigues)."""
        parts = np.zeros((3, len(self.joints), 4, 4))
        for k, joint in enumerate(self.joints):
            quarter, half = (rotation_about_axis(joint.axis, angle) for angle in (np.pi / 2, np.pi))
            square = (half - np.eye(3)) / 2  # half a turn: I + 2 K²
            parts[0, k], parts[1, k, :3, :3], parts[2, k, :3, :3] = np.eye(4), quarter - np.eye(3) - square, square
            parts[:, k] = joint.T_parent_joint @ parts[:, k]
        return parts

    def held(self, angles: NDArray, moving: Sequence[int] | NDArray, body: BodyPoints) -> tuple["Robot", BodyPoints]:
        """The arm with all joints but `moving` (from 0) held at `angles` (n,) rad: a shorter chain, the same points."""
        joints: list[Joint] = []
        T_kept_link = np.eye(4)  # of the link at hand, in the frame of the last link that still moves
        owner, offset = [0], [T_kept_link]
        for i, (joint, angle) in enumerate(zip(self.joints, angles, strict=True)):
            T_kept_joint = T_kept_link @ joint.T_parent_joint
            if i in moving:
                joints.append(replace(joint, T_parent_joint=T_kept_joint))
                T_kept_link = np.eye(4)
            else:
                T_kept_link = T_kept_joint @ rigid_transform(rotation_about_axis(joint.axis, angle))
            owner.append(len(joints))
            offset.append(T_kept_link)
        T = np.array(offset)[body.link]
        local = np.einsum("nij,nj->ni", T[:, :3, :3], body.local) + T[:, :3, 3]
        return Robot(self.name, tuple(joints)), BodyPoints(np.array(owner)[body.link], local)

    def place_points(self, angles: Angles, body: BodyPoints) -> list[tuple[NDArray, NDArray]]:
        """Body points in the base frame, grouped by the joints that move them.

        angles: one array a joint, so that a grid over two joints is the outer product of its
        axes: angles[1] of shape (91, 1) and angles[3] of shape (181,) give groups of shape (1, 1),
        (91, 1) and (91, 181), and a point that only joint 2 moves is placed 91 times.
        Returns groups (index (k,) into the body's points, xyz (3, k, *shape) m).

        Horner's scheme from the tip: each joint carries all points beyond it one frame down.
        """
        dims = max(np.ndim(angle) for angle in angles)
        groups: dict[tuple[int, ...], tuple[NDArray, NDArray]] = {}
        for i in range(len(self.joints), -1, -1):
            here = np.flatnonzero(body.link == i)
            _gather(groups, here, body.local[here].T.reshape((3, len(here)) + (1,) * dims))
            if i == 0:
                break
            origin, angle = self.joints[i - 1].T_parent_joint, np.asarray(angles[i - 1], float)
            angle = angle.reshape((1,) * (dims - angle.ndim) + angle.shape)
            turn = rotation_about_axis(self.joints[i - 1].axis, angle)
            rotation = np.einsum("ij,jk...->ik...", origin[:3, :3], turn)
            beyond, groups = groups, {}
            for index, xyz in beyond.values():
                _gather(groups, index, _carried(rotation, origin[:3, 3], xyz))
        return list(groups.values())

    @classmethod
    def from_urdf(cls, path: str | Path, tip: str | None = None) -> "Robot":
        """Read the revolute chain from the root link to `tip` (default: the longest chain).

        Fixed joints are merged; raises ValueError that names the file for XML that does not
        parse, a missing tip, a loop, or a chain without revolute joints.
        """
        path = Path(path)
        try:
            return cls._parsed(path, path.read_bytes(), tip)
        except OSError as error:
            raise ValueError(f"{path}: cannot be read: {error.strerror}") from None

    @classmethod
    @lru_cache(8)  # every run of a study begins with it
    def _parsed(cls, path: Path, content: bytes, tip: str | None) -> "Robot":
        joints = _joints(path, content)
        by_child = {joint["child"]: joint for joint in joints}
        parents = {joint["parent"] for joint in joints}
        if tip is not None and tip not in by_child:
            raise ValueError(f"{path}: no link {tip!r}; its links are {', '.join(sorted(by_child))}")
        tips = [tip] if tip else [link for link in by_child if link not in parents]
        chain = max((_chain_to(path, by_child, end) for end in tips), key=_revolute_count, default=[])
        if _revolute_count(chain) == 0:
            raise ValueError(f"{path}: no revolute joint between the root link and {tip or 'any tip'}")
        merged, T = [], np.eye(4)
        for joint in chain:
            T = T @ joint["origin"]
            if joint["kind"] == "fixed":
                continue
            if joint["kind"] not in ("revolute", "continuous"):
                break
            merged.append(Joint(joint["name"], T, joint["axis"], joint["lower"], joint["upper"]))
            T = np.eye(4)
        return cls(path.stem, tuple(merged))


def _carried(rotation: NDArray, offset: NDArray, xyz: NDArray) -> NDArray:
    """rotation: (3, 3, ...), offset: (3,), xyz: (3, k, ...) → (3, k, ...)."""
    if rotation.size == 9:  # a joint at rest: one product for the whole grid
        moved = (rotation.reshape(3, 3) @ xyz.reshape(3, -1)).reshape(xyz.shape)
    else:
        moved = np.einsum("ij...,jk...->ik...", rotation, xyz)
    moved += offset.reshape((3,) + (1,) * (xyz.ndim - 1))
    return moved


def _gather(groups: dict, index: NDArray, xyz: NDArray) -> None:
    """Add points to the group of their batch shape."""
    if len(index) == 0:
        return
    shape = xyz.shape[2:]
    if shape in groups:
        index = np.concatenate([groups[shape][0], index])
        xyz = np.concatenate([groups[shape][1], xyz], axis=1)
    groups[shape] = index, xyz


def _joints(path: Path, content: bytes) -> list[dict]:
    """Every joint of the file as a dict with arrays; errors name the file and the joint."""
    try:
        root = ElementTree.fromstring(content)
    except (ElementTree.ParseError, LookupError, ValueError) as error:  # LookupError: an unknown encoding
        raise ValueError(f"{path}: not a URDF that parses: {error}") from None
    if root.tag != "robot":
        raise ValueError(f"{path}: not a URDF: its root element is <{root.tag}>, not <robot>")
    return [_read_joint(path, element) for element in root.findall("joint")]


def _read_joint(path: Path, element: ElementTree.Element) -> dict:
    name = element.get("name", "?")

    def numbers(tag: str, attribute: str, default: str) -> NDArray:
        child = element.find(tag)
        text = default if child is None else child.get(attribute, default)
        try:
            values = np.array([float(word) for word in text.split()]).reshape(len(default.split()))
        except ValueError:
            values = np.array([np.nan])
        if not np.isfinite(values).all():
            raise ValueError(f"{path}: joint {name!r}: <{tag} {attribute}={text!r}> is not numbers")
        return values

    def link(tag: str) -> str:
        child = element.find(tag)
        named = None if child is None else child.get("link")
        if not named:
            raise ValueError(f"{path}: joint {name!r} has no <{tag} link=…>")
        return named

    kind = element.get("type", "")
    endless = kind == "continuous"
    axis = numbers("axis", "xyz", "1 0 0")
    if kind in ("revolute", "continuous") and not np.any(axis):
        raise ValueError(f"{path}: joint {name!r}: its axis is zero")
    return {
        "name": name,
        "kind": kind,
        "parent": link("parent"),
        "child": link("child"),
        "origin": rigid_transform(
            rotation_from_rpy(numbers("origin", "rpy", "0 0 0")), numbers("origin", "xyz", "0 0 0")
        ),
        "axis": axis,
        "lower": -np.pi if endless else numbers("limit", "lower", "0")[0],
        "upper": np.pi if endless else numbers("limit", "upper", "0")[0],
    }


def _chain_to(path: Path, by_child: dict[str, dict], link: str) -> list[dict]:
    """Joints from the root to `link`."""
    chain: list[dict] = []
    while link in by_child:
        chain.append(by_child[link])
        link = chain[-1]["parent"]
        if len(chain) > len(by_child):
            raise ValueError(f"{path}: its links form a loop at {link!r}")
    return chain[::-1]


def _revolute_count(chain: list[dict]) -> int:
    return sum(joint["kind"] in ("revolute", "continuous") for joint in chain)
