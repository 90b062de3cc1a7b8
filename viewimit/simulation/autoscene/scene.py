"""Make all fields of a scene file from a URDF.

`urdf.chain` finds the arm. Here its posture, moving joints, ranges and body points are chosen, and the arms and the
head are placed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ...geometry.arrays import Floats
from ...wording import first_of
from ..camera import Cameras
from ..robot import Robot
from ..urdf.chain import Chain, find_arm, held_links
from ..urdf.reference import Reference
from ..urdf.shapes import Shapes, shapes_of
from ..urdf.tree import FREE, KINDS, REST_MARGIN, SLIDING, Tree, read_tree
from .placing import (
    CENTRE,
    FOCAL,
    IMAGE,
    Placing,
    fit_to_view,
    image_jacobian,
    imitating_joints,
    rest_posture,
    separate_robots,
    turning_range,
    two_that_move_most,
)
from .surface import Surface, choose_layout, parts_of, sample_arm, sample_body, sample_links, visible_fraction

LAYOUTS = 10, 16, 20  # numbers of points
MAX_NAMED = 3  # joints and tips in a message
YAWS_DEG = range(0, 360, 45)
GRID_ANGLES = 5  # for each moving joint, over its range
VIEW_ANGLES = 3  # of those, for visibility
MIN_GAIN = 1.02  # by which another yaw must be better
START = 0.2, 0.8, 0.35  # of the ranges of the moving joints: the learner's start

Ranges = Sequence[tuple[float, float]]  # of the moving joints [deg]


@dataclass(frozen=True)
class AutoScene:
    """A scene made for a URDF."""

    fields: dict[str, Any]  # of `Scene`
    choices: tuple[str, ...]  # messages about the choices
    faults: tuple[str, ...]  # messages about shapes that are not drawn


def make_scene(reference: Reference, joints: Sequence[int] | None = None) -> AutoScene:
    """Make a scene for a URDF. joints: numbers, from 1, of one or two moving joints; by default the two that move the
    images most. Raises ValueError: names the file and the joint."""
    shapes = shapes_of(reference)
    return _make_scene(read_tree(reference.path), shapes, reference, None if joints is None else tuple(joints))


@lru_cache(16)
def _make_scene(tree: Tree, shapes: Shapes, reference: Reference, joints: tuple[int, ...] | None) -> AutoScene:
    arm = find_arm(tree, reference.base, reference.tip)
    robot = Robot.from_urdf(reference.path, reference.tip, reference.base)
    among = imitating_joints(robot)
    _require_movable(tree, arm, robot, among, joints)
    rest = rest_posture(robot)
    held, loose = shapes.split()
    surface = sample_arm(held, robot, rest, (joints or among)[0])
    lowest = _lowest(shapes, robot, rest)
    yaw, moving = _best_view(robot, rest, surface, lowest, among if joints is None else joints, joints is not None)
    ranges = [turning_range(robot, joint, rest) for joint in moving]
    rest[np.array(moving) - 1] = np.radians(np.mean(ranges, axis=1))
    rest = np.array(robot.with_mimics(rest), float)
    postures = _posture_grid(robot, rest, moving, ranges)
    sides = [surface.at(robot.link_frames(posture)) for posture in postures]
    rough = fit_to_view(np.array([places for places, _ in sides]), lowest, yaw)
    body = surface.and_also(sample_links(loose))
    visible = _visibility(rough, [body.at(robot.link_frames(posture)) for posture in postures])[: len(surface.link)]
    part = parts_of(surface.link, moving)
    places = surface.at(robot.link_frames(rest))[0]
    chosen = {count: choose_layout(surface, places, visible, part, count) for count in LAYOUTS}
    layouts = {count: found for count, found in chosen.items() if len(found) == count}
    used = np.unique(np.concatenate(list(layouts.values())))
    placing = fit_to_view(np.array([places[used] for places, _ in sides]), lowest, yaw)
    placing = separate_robots(placing, sample_body(shapes.meshes, robot, rest))
    fields = _fields(tree, reference, robot, moving, ranges, rest, placing)
    fields["points"] = {
        str(count): [[int(surface.link[k]), *surface.local[k].round(4).tolist()] for k in found]
        for count, found in layouts.items()
    }
    choices = tuple(f"{tree.path}: {line}" for line in _choices(tree, arm, robot, surface))
    return AutoScene(fields, choices, shapes.faults)


def _require_movable(tree: Tree, arm: Chain, robot: Robot, among: list[int], joints: tuple[int, ...] | None) -> None:
    for joint in joints or ():
        if not 1 <= joint <= len(robot.joints):
            raise ValueError(f"{tree.path}: there is no joint {joint}; its joints are {_numbered(robot)}")
        if joint not in among:
            one = robot.joints[joint - 1]
            raise ValueError(f"{tree.path}: joint {joint}, {one.name}, {_why_fixed(tree, one.name)}")
    if len(among) >= 2 or (joints and len(among) >= len(joints)):
        return
    stiff = [joint.name for k, joint in enumerate(robot.joints, 1) if k not in among]
    slides = [joint.name for joint in arm.joints if joint.kind in SLIDING]
    why = f"; {slides[0]} slides, and is held" if slides else ""
    if stiff:
        why = f"; {stiff[0]} {_why_fixed(tree, stiff[0])}"
    raise ValueError(
        f"{tree.path}: from {arm.base} to {arm.tip} {len(among) or 'no'} joint{'s' * (not among)} can turn, "
        f"and two are needed{why}; another chain can be named by --tip"
    )


def _why_fixed(tree: Tree, name: str) -> str:
    """Why a joint cannot move, and the remedy."""
    joint = next(joint for joint in tree.joints if joint.name == name)
    if joint.mimic is not None:
        return f"follows {joint.mimic.of}: move that one"
    if not joint.limited or (joint.lower == joint.upper == 0.0):
        return 'has no <limit lower=… upper=…>: give it limits, or type="continuous"'
    return f"turns only from {np.degrees(joint.lower):.4g}° to {np.degrees(joint.upper):.4g}°: widen its limits"


def _best_view(
    robot: Robot, rest: Floats, surface: Surface, lowest: float, among: Sequence[int], given: bool
) -> tuple[float, list[int]]:
    """Yaw of the bases [rad] at which two joints, or the given ones, move the images most, and these joints."""
    spans = np.zeros(len(robot.joints))
    for joint in among:
        low, high = np.radians(turning_range(robot, joint, rest))
        spans[joint - 1] = high - low
    places, _ = surface.at(robot.link_frames(rest))
    best: tuple[float, float, list[int]] = (-1.0, 0.0, [])
    for yaw in np.radians(YAWS_DEG):
        placing = fit_to_view(places, lowest, yaw)
        seen = [(Cameras(placing.cameras(side)), placing.base(side)) for side in (1, -1)]
        J = np.concatenate([image_jacobian(robot, rest, surface, *one) for one in seen])
        if len(among) == 1:
            pair, score = [among[0]], float(np.linalg.norm(J[:, among[0] - 1]))
        else:
            chosen, score = two_that_move_most(J, spans, among)
            pair = list(among) if given else list(chosen)
        if score > best[0] * MIN_GAIN:
            best = score, float(yaw), pair
    return best[1:]


def _posture_grid(robot: Robot, rest: Floats, moving: Sequence[int], ranges: Ranges) -> list[Floats]:
    """Postures on a grid over the ranges, (n,) rad each."""
    axes = [np.radians(np.linspace(low, high, GRID_ANGLES)) for low, high in ranges]
    found = []
    for angles in np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, len(moving)):
        posture = rest.copy()
        posture[np.array(moving) - 1] = angles
        found.append(np.array(robot.with_mimics(posture), float))
    return found


def _visibility(placing: Placing, sides: list[tuple[Floats, Floats]]) -> Floats:
    """Fraction of the views of both arms over the ranges that show each place, (K,)."""
    views = sides[:: max(1, len(sides) // VIEW_ANGLES**2)]
    seen = [(list(placing.cameras(side)), placing.base(side)) for side in (1, -1)]
    return np.mean([visible_fraction(*one, *each) for one in seen for each in views], axis=0)


def _lowest(shapes: Shapes, robot: Robot, rest: Floats) -> float:
    """Height of the lowest vertex in the base frame [m]."""
    frames = robot.link_frames(rest)
    return min(float((mesh.vertices @ frames[k][2, :3] + frames[k][2, 3]).min()) for k, mesh in shapes.meshes.items())


def _fields(
    tree: Tree,
    reference: Reference,
    robot: Robot,
    moving: Sequence[int],
    ranges: Ranges,
    rest: Floats,
    placing: Placing,
) -> dict[str, Any]:
    start = [round(low + share * (high - low), 2) for (low, high), share in zip(ranges, START)]
    shown = rest.copy()
    shown[np.array(moving) - 1] = np.radians([low + (high - low) / 3 for low, high in ranges])  # no stretched pole
    posture = np.degrees(np.asarray(robot.with_mimics(shown))).round(2)
    yaw = float(np.degrees(placing.yaw).round(2))
    return {
        "title": f"{tree.path.stem}, parallel cameras",
        "robot": str(reference),
        "moving_joints": list(moving),
        "range_deg": [list(each) for each in ranges],
        "posture_deg": posture.tolist(),
        "start_deg": start,
        "size": round(placing.size, 4),
        "head": {
            "position": _rounded(placing.head),
            "baseline": round(placing.baseline, 4),
            "image": list(IMAGE),
            "focal": FOCAL,
            "centre": list(CENTRE),
            "gaze_demonstrator": _rounded(placing.gaze(1)),
            "gaze_learner": _rounded(placing.gaze(-1)),
        },
        "demonstrator": {"position": _rounded(placing.base(1)[:3, 3]), "yaw_deg": yaw},
        "learner": {"position": _rounded(placing.base(-1)[:3, 3]), "yaw_deg": yaw},
    }


def _rounded(values: Floats) -> list[float]:
    """Rounded to 0.1 mm, without minus zero."""
    return [float(value) for value in np.asarray(values).round(4) + 0.0]


def _choices(tree: Tree, arm: Chain, robot: Robot, surface: Surface) -> Iterator[str]:
    """Messages about the arm, its joints that do not imitate, and what has no points because it moves by itself."""
    yield f"{arm.base} to {arm.tip}, {len(robot.joints)} joints: {_numbered(robot)}"
    if arm.equal_tips:
        others = " or ".join(f"--tip {link}" for link in arm.equal_tips[:MAX_NAMED])
        more = f" or {len(arm.equal_tips) - MAX_NAMED} more" if len(arm.equal_tips) > MAX_NAMED else ""
        yield f"equally long arms: this one is --tip {arm.tip}; for another, {others}{more}"
    for joint in arm.joints:
        if joint.kind in SLIDING:
            yield f"{joint.name} slides, and is held at {tree.rest(joint, REST_MARGIN):.4g} m"
    for one in robot.joints:
        if one.leader is not None:
            yield f"{one.name} follows {robot.joints[one.leader.joint].name}"
    held = held_links(tree, arm)
    loose = [joint.name for joint in tree.joints if (joint.parent in held) != (joint.child in held)]
    if loose and any(shapes for link, shapes in tree.shapes.items() if link not in held):
        yield f"no point beyond {first_of(loose, MAX_NAMED)}, which the arm does not hold"
    if not (surface.link == 0).any():
        yield "no point on the base: all that is drawn of it moves by itself; --base names another link"
    for kind in sorted({joint.kind for joint in tree.joints} - set(KINDS)):  # one of unknown type may end the arm
        names = ", ".join(joint.name for joint in tree.joints if joint.kind == kind)
        yield f"held, as type {kind!r} is none of {', '.join(KINDS)}: {names}"
    turning = {joint.name for joint in robot.joints}
    for joint in arm.joints:
        if joint.kind in FREE:
            yield f"{joint.name} is {joint.kind}, and is held"
        elif joint.turns and joint.mimic is not None and joint.name not in turning:
            yield f"{joint.name} follows {joint.mimic.of}, which does not turn in this arm, and is held"


def _numbered(robot: Robot) -> str:
    return ", ".join(f"{k} {joint.name}" for k, joint in enumerate(robot.joints, 1))
