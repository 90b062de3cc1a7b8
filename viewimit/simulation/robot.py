"""Robots: joints, links and meshes, from a URDF; body points, and the coloured balls that mark them in pictures.

The balls are TOML files in assets/markers. A ball looks like a disc from every side, and the centre of the disc is the
image of the centre of the ball.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..assets import ROOT
from ..geometry.arrays import Floats
from ..geometry.rigid import rigid_transform, rotation_about_axis
from ..sensing.files import parse_toml, read_toml
from .meshes import Mesh, read_glb
from .urdf.chain import find_arm, turning_joints
from .urdf.reference import is_reference, parse_reference, require_urdf
from .urdf.tree import REST_MARGIN, Tree, read_tree

IDENTITY = np.eye(4)
BodyPoint = tuple[int, float, float, float]  # link (0 = base), and x, y, z in its frame [m]
Angles = Sequence[ArrayLike] | Floats  # one array for each joint [rad], broadcast against each other
Ints = NDArray[np.int_]


@dataclass(frozen=True)
class Leader:
    """The joint that a mimic joint follows: its angle is multiplier * angle of the leader + offset."""

    joint: int  # index from 0
    multiplier: float
    offset: float  # rad


@dataclass(frozen=True)
class Joint:
    """A revolute joint."""

    name: str
    T_parent_joint: Floats  # (4, 4) at angle 0, m
    axis: Floats  # (3,) in the joint's frame
    lower: float  # rad
    upper: float  # rad
    leader: Leader | None = None  # of a mimic joint


@dataclass(frozen=True)
class BodyPoints:
    """N points fixed to the body."""

    link: Ints  # (N,) 0 = base, i = moved by joint i
    local: Floats  # (N, 3) in that link's frame [m]

    def __len__(self) -> int:
        return len(self.link)

    def at(self, link_frames: Floats) -> Floats:
        """Return the points, (N, 3) m, given the frames of all links, (n + 1, 4, 4)."""
        T = link_frames[self.link]
        return np.einsum("nij,nj->ni", T[:, :3, :3], self.local) + T[:, :3, 3]


@dataclass(frozen=True)
class BodyFrames:
    """The n + 1 links of an arm, fixed to the links of a shorter chain."""

    link: Ints  # (n + 1,) link of the chain, 0 = base
    T_chain_link: Floats  # (n + 1, 4, 4) in the frame of that link, m

    def link_frames(self, T_world_chain: Floats) -> Floats:
        """Return T_world_link of all links, (n + 1, 4, 4), given the frames of the chain's links."""
        return T_world_chain[self.link] @ self.T_chain_link

    def points(self, body: BodyPoints) -> BodyPoints:
        """Return the same points, fixed to the chain."""
        return BodyPoints(self.link[body.link], body.at(self.T_chain_link))


@dataclass(frozen=True)
class Robot:
    """The chain of revolute joints of one arm, base to tip."""

    name: str
    joints: tuple[Joint, ...]

    @property
    def lower(self) -> Floats:
        """(n,) lower joint limits [rad]."""
        return np.array([joint.lower for joint in self.joints])

    @property
    def upper(self) -> Floats:
        """(n,) upper joint limits [rad]."""
        return np.array([joint.upper for joint in self.joints])

    @property
    def movable_joints(self) -> tuple[int, ...]:
        """Numbers, from 1, of the joints that follow no other joint and can turn."""
        return tuple(k for k, joint in enumerate(self.joints, 1) if joint.leader is None and joint.lower < joint.upper)

    @cached_property
    def has_mimics(self) -> bool:
        """Whether some joint follows another joint."""
        return any(joint.leader is not None for joint in self.joints)

    def with_mimics(self, angles: Angles) -> Angles:
        """Return one angle for each joint [rad], with those of mimic joints computed from their leaders."""
        if not self.has_mimics:
            return angles
        found = list(angles)
        for k, joint in enumerate(self.joints):
            if joint.leader is not None:
                found[k] = joint.leader.multiplier * np.asarray(angles[joint.leader.joint]) + joint.leader.offset
        return found

    def expand_mimics(self, angles: Angles) -> Angles:
        """Return one angle for each joint [rad], given those of the joints that follow no other."""
        if not self.has_mimics:
            return angles
        given = iter(angles)
        return self.with_mimics([next(given) if joint.leader is None else 0.0 for joint in self.joints])

    def link_frames(self, angles: ArrayLike, T_world_base: Floats = IDENTITY) -> Floats:
        """Return T_world_link of every link for one posture: (n,) rad -> (n + 1, 4, 4)."""
        angle = np.array(angles, float).reshape(-1, 1, 1)
        constant, sine, cosine = self._rotation_terms  # all joints at once, to save numpy calls
        steps = constant + np.sin(angle) * sine + (1 - np.cos(angle)) * cosine
        frames = np.empty((len(self.joints) + 1, 4, 4))
        frames[0] = T_world_base
        for i, step in enumerate(steps):
            np.matmul(frames[i], step, out=frames[i + 1])
        return frames

    @cached_property
    def _rotation_terms(self) -> Floats:
        """(3, n, 4, 4): coefficients of 1, sin and 1 - cos of a joint's angle in T_parent_link (Rodrigues' formula)."""
        parts = np.zeros((3, len(self.joints), 4, 4))
        for k, joint in enumerate(self.joints):
            quarter, half = (rotation_about_axis(joint.axis, angle) for angle in (np.pi / 2, np.pi))
            square = (half - np.eye(3)) / 2  # half a turn: I + 2 K²
            parts[0, k], parts[1, k, :3, :3], parts[2, k, :3, :3] = np.eye(4), quarter - np.eye(3) - square, square
            parts[:, k] = joint.T_parent_joint @ parts[:, k]
        return parts

    def with_fixed_joints(self, angles: Floats, moving: Sequence[int] | Ints) -> tuple["Robot", BodyFrames]:
        """Fix all joints but some at given angles. angles: (n,) angles of all joints [rad]; moving: indices, from 0, of
        the joints that still move. Returns a shorter chain, and the frames of all links on it."""
        joints: list[Joint] = []
        T_kept_link = np.eye(4)  # of the current link, in the frame of the last one that still moves
        owner, offset = [0], [T_kept_link]
        kept = [i for i, joint in enumerate(self.joints) if (joint.leader.joint if joint.leader else i) in moving]
        for i, (joint, angle) in enumerate(zip(self.joints, self.with_mimics(angles), strict=True)):
            T_kept_joint = T_kept_link @ joint.T_parent_joint
            if i in kept:
                leader = joint.leader and replace(joint.leader, joint=kept.index(joint.leader.joint))
                joints.append(replace(joint, T_parent_joint=T_kept_joint, leader=leader))
                T_kept_link = np.eye(4)
            else:
                T_kept_link = T_kept_joint @ rigid_transform(rotation_about_axis(joint.axis, angle))
            owner.append(len(joints))
            offset.append(T_kept_link)
        return Robot(self.name, tuple(joints)), BodyFrames(np.array(owner), np.array(offset))

    def place_points(self, angles: Angles, body: BodyPoints) -> list[tuple[Ints, Floats]]:
        """Return body points in the base frame, grouped by the joints that move them.

        angles: angles of all joints [rad]. With shape (91, 1) for one joint and (181,) for another, the points of the
        base are placed once, those moved by the first joint alone 91 times, and the others 91 x 181 times. Returns
        indices of body points, and their places [m]. Horner's scheme from the tip: each joint moves all points beyond
        it one frame down.
        """
        dims = max(np.ndim(angle) for angle in angles)
        groups: dict[tuple[int, ...], tuple[Ints, Floats]] = {}
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
                _gather(groups, index, _transformed(rotation, origin[:3, 3], xyz))
        return list(groups.values())

    @classmethod
    def from_urdf(cls, path: str | Path, tip: str | None = None, base: str | None = None) -> "Robot":
        """Read the chain of revolute joints between two links of a URDF.

        Fixed joints are merged, and so are prismatic ones, at rest. tip: last link; by default the end of the longest
        chain, without fingers; base: by default the root. Raises ValueError that names the file: XML that does not
        parse, a missing link, a loop, or a chain without revolute joints.
        """
        return _chain_robot(read_tree(Path(path)), tip, base)


@lru_cache(8)  # every run of a study starts with it
def _chain_robot(tree: Tree, tip: str | None, base: str | None) -> Robot:
    chain = find_arm(tree, base, tip)
    turning = turning_joints(chain)
    number = {joint.name: k for k, joint in enumerate(turning)}
    merged, T = [], np.eye(4)
    for joint in chain.joints:
        if joint.name not in number:
            T = T @ joint.at(tree.rest(joint, REST_MARGIN))
            continue
        leader = None
        if joint.mimic is not None:
            leader = Leader(number[joint.mimic.of], joint.mimic.multiplier, joint.mimic.offset)
        merged.append(Joint(joint.name, T @ joint.T_parent_joint, joint.axis, joint.lower, joint.upper, leader))
        T = np.eye(4)
    return Robot(tree.path.stem, tuple(merged))


def _transformed(rotation: Floats, offset: Floats, xyz: Floats) -> Floats:
    """Rotate by (3, 3, ...) and translate by (3,): (3, k, ...) -> (3, k, ...)."""
    if rotation.size == 9:  # one angle for the whole grid
        moved = (rotation.reshape(3, 3) @ xyz.reshape(3, -1)).reshape(xyz.shape)
    else:
        moved = np.einsum("ij...,jk...->ik...", rotation, xyz)
    moved += offset.reshape((3,) + (1,) * (xyz.ndim - 1))
    return moved


def _gather(groups: dict[tuple[int, ...], tuple[Ints, Floats]], index: Ints, xyz: Floats) -> None:
    """Add points to the group of their batch shape."""
    if len(index) == 0:
        return
    shape = xyz.shape[2:]
    if shape in groups:
        index = np.concatenate([groups[shape][0], index])
        xyz = np.concatenate([groups[shape][1], xyz], axis=1)
    groups[shape] = index, xyz


@cache
def robot_names() -> tuple[str, ...]:
    """Return the names of the shipped robots."""
    return tuple(sorted(path.name for path in (ROOT / "robots").iterdir() if path.is_dir()))


def load_robot(name: str | Path) -> Robot:
    """Return a shipped robot by name, or a URDF's by path. Raises ValueError that lists the shipped ones."""
    require_urdf(name)
    if is_reference(name):
        found = parse_reference(name)
        return Robot.from_urdf(found.path, found.tip, found.base)
    path = ROOT / "robots" / str(name) / f"{name}.urdf"
    if not path.is_file():
        raise ValueError(f"no robot {str(name)!r}; there are {', '.join(robot_names())}, or the path of a .urdf file")
    return Robot.from_urdf(path)


def require_joints(robot: Robot, joints: tuple[int, ...]) -> None:
    """Raise ValueError unless these joint numbers ascend, exist, and can move without another joint."""
    if not joints:
        raise ValueError(f"needs joints that move, of 1 … {len(robot.joints)}, got none")
    if list(joints) != sorted(set(joints)) or not 1 <= joints[0] <= joints[-1] <= len(robot.joints):
        raise ValueError(f"joints {', '.join(map(str, joints))} must ascend, within 1 … {len(robot.joints)}")
    for joint in joints:
        one = robot.joints[joint - 1]
        if one.leader is not None:
            leader = one.leader.joint
            raise ValueError(
                f"joint {joint}, {one.name}, follows joint {leader + 1}, {robot.joints[leader].name}: move that one"
            )
        if joint not in robot.movable_joints:
            raise ValueError(
                f"joint {joint}, {one.name}, is held by its limits at {np.degrees(one.lower):.4g}°: give it a "
                '<limit lower=… upper=…> in the URDF, or type="continuous", or move another'
            )


def link_meshes(robot: str, held_only: bool = False) -> dict[int, Mesh]:
    """Return meshes by link number (0 = base), each in its link's frame, for a robot as a scene names it.

    held_only: without what moves by itself, such as another arm of a URDF. Raises ValueError for a URDF that cannot be
    read.
    """
    if is_reference(robot):
        from .urdf.shapes import shapes_of  # loads trimesh

        shapes = shapes_of(parse_reference(robot))
        return shapes.split()[0] if held_only else shapes.meshes
    return _shipped_meshes(robot)


@cache
def _shipped_meshes(robot: str) -> dict[int, Mesh]:
    meshes = read_glb(ROOT / "robots" / robot / f"{robot}.glb")
    return {int(name.removeprefix("link")): mesh for name, mesh in meshes.items()}


THIRDS = np.radians([0.0, 120.0, 240.0])
GREY, CHROMA = 0.5, 0.5  # the circle of hues that touches all six faces of the RGB cube


class Markers(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The balls on one arm."""

    radius: float  # m
    balls: tuple[tuple[int, float, float, float, float], ...]  # link, x, y, z in its frame [m], hue [deg]

    @property
    def body(self) -> BodyPoints:
        """Centres of the balls."""
        rows = np.array(self.balls, float).reshape(-1, 5)
        return BodyPoints(rows[:, 0].astype(int), rows[:, 1:4])

    @property
    def hue_deg(self) -> Floats:
        """(N,) hues [deg]."""
        return np.array(self.balls, float).reshape(-1, 5)[:, 4]


def colours(hue_deg: ArrayLike) -> Floats:
    """Return colours of equal chroma, towards cos(hue - (0°, 120°, 240°)): (N,) deg -> (N, 3) RGB in 0 … 1."""
    return GREY + CHROMA * np.cos(np.radians(np.asarray(hue_deg))[..., None] - THIRDS)


def marker_names() -> list[str]:
    """Return the names of the shipped robots with markers."""
    return sorted(path.stem for path in (ROOT / "markers").glob("*.toml"))


def load_markers(name: str | Path) -> Markers:
    """Read the markers of a shipped robot, or a TOML file. Raises ValueError that names the file and the field."""
    path = Path(name)
    if path.suffix.lower() != ".toml":
        path = ROOT / "markers" / f"{name}.toml"
    if not path.is_file():
        names = ", ".join(marker_names())
        raise ValueError(f"no markers {str(name)!r}; there are {names}, or the path of a .toml file")
    try:
        markers = parse_toml(read_toml(path), Markers)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    if not markers.radius > 0 or not np.isfinite(np.array(markers.balls, float)).all():
        raise ValueError(f"{path}: radius must be positive, and all numbers finite")
    if len(set(markers.hue_deg.tolist())) < len(markers.balls):
        raise ValueError(f"{path}: two balls have the same hue")
    return markers
