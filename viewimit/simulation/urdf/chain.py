"""Find the arm of a URDF, the longest chain of revolute joints without fingers, and the joint that moves each link."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...geometry.arrays import Floats
from .tree import KINDS, REST_MARGIN, SLIDING, TURNING, Tree, TreeJoint

FINGER = re.compile(r"finger|jaw|thumb|knuckle|claw", re.IGNORECASE)  # in the name of a joint or of its child link
GRIPPER = re.compile(r"grip", re.IGNORECASE)  # in the name of a joint; a link of that name may be the whole hand
HAND = re.compile(r"grip|hand(?!le)|jaw|claw", re.IGNORECASE)  # in the names of both links of a finger's joint
MAX_HAND_REACH = 0.35  # of the arm's length
MIN_ARM_JOINTS = 2  # without fingers
EQUAL_LENGTH = 1e-3  # relative difference of two arms of one kind


@dataclass(frozen=True)
class Chain:
    """A chain of joints that is an arm."""

    base: str  # link
    tip: str  # link
    joints: tuple[TreeJoint, ...]  # from the base to the last one that turns, fixed ones too
    equal_tips: tuple[str, ...] = ()  # links: last ones of other arms that are as long, where the tip was not given


def find_arm(tree: Tree, base: str | None = None, tip: str | None = None) -> Chain:
    """Find the arm between two links.

    Without a tip, this is the chain with the most revolute joints that follow no other, and of those the longest in
    metres. Fingers do not count, unless there is nothing else or the tip is beyond them.

    Raises ValueError that names the file: a missing link, a loop, or a chain in which nothing turns.
    """
    by_child = {joint.child: joint for joint in tree.joints}
    for link in (base, tip):
        if link is not None and link not in tree.links:
            raise ValueError(f"{tree.path}: no link {link!r}; its links are {', '.join(sorted(tree.links))}")
    parents = {joint.parent for joint in tree.joints}
    tips = [tip] if tip else [link for link in by_child if link not in parents]
    if by_child and not tips:
        raise ValueError(f"{tree.path}: its links form a loop at {next(iter(by_child))!r}")
    chains = [_path_to(tree, by_child, end, base) for end in tips]
    arms = [arm if tip else _without_fingers(tree, arm) for arm in chains if arm is not None]
    if tip and not arms:
        raise ValueError(f"{tree.path}: link {tip!r} does not hang on link {base!r}")
    best = max(arms, key=lambda arm: (_count(arm), round(_length(arm), 6)), default=())
    arm = _up_to_last_revolute(best)
    if not any(joint.turns and joint.mimic is None for joint in arm):
        start = "the root link" if base is None else f"link {base!r}"
        held = "" if tree.joints else "; it has no joint"
        if any(joint.kind in SLIDING for joint in tree.joints):
            held = "; joints that slide are held, and do not count"
        unknown = next((joint for joint in tree.joints if joint.kind not in KINDS), None)
        if unknown is not None:
            meant = unknown.kind.lower()
            held += f"; joint {unknown.name!r} has the type {unknown.kind!r}: "
            held += f"write {meant!r}" if meant in KINDS else f"there are {', '.join(KINDS)}"
        raise ValueError(f"{tree.path}: no revolute joint between {start} and {tip or 'any tip'}{held}")
    for joint in arm:
        if joint.kind in TURNING and joint.lower > joint.upper:
            limits = f"lower={joint.lower:g} upper={joint.upper:g}"
            raise ValueError(f"{tree.path}: joint {joint.name!r}: its limits {limits} leave it no angle: swap them")
    return Chain(arm[0].parent, tip or arm[-1].child, arm, () if tip else _equal_tips(arm, arms))


def _equal_tips(arm: tuple[TreeJoint, ...], arms: Iterable[tuple[TreeJoint, ...]]) -> tuple[str, ...]:
    """Last links of the other arms with as many joints and the same length, rounding aside."""
    ends = [each[-1].child for each in map(_up_to_last_revolute, arms) if each and _is_as_long(each, arm)]
    return tuple(dict.fromkeys(link for link in ends if link != arm[-1].child))


def turning_joints(arm: Chain) -> list[TreeJoint]:
    """Return the joints of `Robot`: those of an arm that turn, by themselves or with another joint of the arm."""
    leaders = {joint.name for joint in arm.joints if joint.turns and joint.mimic is None}
    return [joint for joint in arm.joints if joint.turns and (joint.mimic is None or joint.mimic.of in leaders)]


def _path_to(tree: Tree, by_child: dict[str, TreeJoint], link: str, base: str | None) -> tuple[TreeJoint, ...] | None:
    """Joints from the base, or the root, to `link`; None if the base is not above it."""
    chain: list[TreeJoint] = []
    while link in by_child and link != base:
        chain.append(by_child[link])
        link = chain[-1].parent
        if len(chain) > len(by_child):
            raise ValueError(f"{tree.path}: its links form a loop at {link!r}")
    return tuple(chain[::-1]) if base is None or link == base else None


def _without_fingers(tree: Tree, arm: tuple[TreeJoint, ...]) -> tuple[TreeJoint, ...]:
    """Remove the hand: two or more small moving branches, or joints with a finger's name, at the end."""
    for k, joint in enumerate(arm):
        before = arm[:k]
        branches = [other for other in tree.joints if other.parent == joint.parent]
        moving = [branch for branch in branches if _subtree_moves(tree, branch)]
        if _count(before) >= MIN_ARM_JOINTS and len(moving) >= 2:
            if max(_subtree_length(tree, branch) for branch in moving) < MAX_HAND_REACH * _length(before):
                arm = before
                break
    end = len(arm)
    while end and (not _turns_freely(arm[end - 1]) or _is_finger(arm[end - 1])):
        end -= 1
    if _count(arm[:end]) < MIN_ARM_JOINTS:
        return arm
    leaders = {joint.name for joint in arm[:end]}
    for k, joint in enumerate(arm[end:], end + 1):  # mimic joints of the arm belong to it
        if joint.turns and joint.mimic is None:
            break
        if joint.mimic is not None and joint.mimic.of in leaders:
            end = k
    return arm[:end]


def _is_finger(joint: TreeJoint) -> bool:
    if HAND.search(joint.parent) and HAND.search(joint.child):
        return True
    return bool(FINGER.search(f"{joint.name} {joint.child}") or GRIPPER.search(joint.name))


def _up_to_last_revolute(arm: tuple[TreeJoint, ...]) -> tuple[TreeJoint, ...]:
    last = max((k + 1 for k, joint in enumerate(arm) if joint.turns), default=0)
    return arm[:last]


def _turns_freely(joint: TreeJoint) -> bool:
    return joint.turns and joint.moves


def _count(arm: tuple[TreeJoint, ...]) -> int:
    return sum(map(_turns_freely, arm))


def _length(arm: tuple[TreeJoint, ...]) -> float:
    return sum(float(np.linalg.norm(joint.T_parent_joint[:3, 3])) for joint in arm)


def _is_as_long(one: tuple[TreeJoint, ...], other: tuple[TreeJoint, ...]) -> bool:
    return _count(one) == _count(other) and abs(_length(one) - _length(other)) <= EQUAL_LENGTH * _length(other)


def _below(tree: Tree, joint: TreeJoint) -> list[TreeJoint]:
    return [other for other in tree.joints if other.parent == joint.child]


def _subtree_moves(tree: Tree, joint: TreeJoint) -> bool:
    moves = joint.kind in (*TURNING, "prismatic") and (joint.mimic is not None or joint.lower < joint.upper)
    return moves or any(_subtree_moves(tree, other) for other in _below(tree, joint))


def _subtree_length(tree: Tree, joint: TreeJoint) -> float:
    own = float(np.linalg.norm(joint.T_parent_joint[:3, 3]))
    return own + max((_subtree_length(tree, other) for other in _below(tree, joint)), default=0.0)


def carrier_frames(tree: Tree, arm: Chain) -> dict[str, tuple[int, Floats]]:
    """Return for each link the number of the arm's joint that moves it rigidly (0 = base), and T_carrier_link (4, 4).

    Numbers are those of `Robot.joints`, from 1. Joints outside the arm are at rest.
    """
    number = {joint.name: k for k, joint in enumerate(turning_joints(arm), 1)}
    in_arm = {joint.name for joint in arm.joints}
    below: dict[str, list[TreeJoint]] = {}
    for joint in tree.joints:
        below.setdefault(joint.parent, []).append(joint)
    root, T_root_base = _root_of(tree, arm.base)
    frames: dict[str, tuple[int, Floats]] = {root: (0, np.asarray(np.linalg.inv(T_root_base), float))}
    pending = [root]
    while pending:
        link = pending.pop()
        carrier, T_carrier_link = frames[link]
        for joint in below.get(link, []):
            if joint.name in number:
                frames[joint.child] = number[joint.name], np.eye(4)
            else:
                margin = REST_MARGIN if joint.name in in_arm else 0.0
                frames[joint.child] = carrier, T_carrier_link @ joint.at(tree.rest(joint, margin))
            pending.append(joint.child)
    return frames


def held_links(tree: Tree, arm: Chain) -> set[str]:
    """Return the links that an arm moves or stands on: no joint outside it that can move is between them."""
    in_arm = {joint.name for joint in arm.joints}
    passed = [joint for joint in tree.joints if joint.name in in_arm or not joint.is_loose]
    held, pending = {arm.base}, [arm.base]
    while pending:
        link = pending.pop()
        beside = {joint.child if joint.parent == link else joint.parent for joint in passed if joint.touches(link)}
        pending += beside - held
        held |= beside
    return held


def _root_of(tree: Tree, link: str) -> tuple[str, Floats]:
    """The root above a link, and T_root_link."""
    by_child = {joint.child: joint for joint in tree.joints}
    T = np.eye(4)
    while link in by_child:
        joint = by_child[link]
        T = joint.at(tree.rest(joint)) @ T
        link = joint.parent
    return link, T
