"""Which joints of a URDF are the arm: the longest chain of those that turn, without fingers."""

import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .tree import REST_MARGIN, SLIDING, TURNING, Tree, TreeJoint

FINGER = re.compile(r"finger|jaw|thumb|knuckle|claw", re.IGNORECASE)  # in the name of a joint, or of what it moves
GRIPPER = re.compile(r"grip", re.IGNORECASE)  # in the name of a joint; a link of that name may be the whole hand
SMALL = 0.35  # of an arm's length, that what it holds reaches at most to be its hand
FEWEST = 2  # joints that an arm has without its fingers


@dataclass(frozen=True)
class Chain:
    """joints: from the link `base` to the last one that turns, fixed ones too; tip: the link at its end."""

    base: str
    tip: str
    joints: tuple[TreeJoint, ...]


def find_arm(tree: Tree, base: str | None = None, tip: str | None = None) -> Chain:
    """Raises ValueError that names the file for a link that is not there, a loop, or a chain in which nothing turns.

    Without a tip the chain with most joints that turn by themselves, and of those the longest in metres. Fingers are
    not counted, unless nothing else is there or the tip is beyond them.
    """
    by_child = {joint.child: joint for joint in tree.joints}
    for link in (base, tip):
        if link is not None and link not in tree.links:
            raise ValueError(f"{tree.path}: no link {link!r}; its links are {', '.join(sorted(tree.links))}")
    parents = {joint.parent for joint in tree.joints}
    tips = [tip] if tip else [link for link in by_child if link not in parents]
    chains = [_path_to(tree, by_child, end, base) for end in tips]
    arms = [arm if tip else _without_fingers(tree, arm) for arm in chains if arm is not None]
    if tip and not arms:
        raise ValueError(f"{tree.path}: link {tip!r} does not hang on link {base!r}")
    best = max(arms, key=lambda arm: (_count(arm), round(_length(arm), 6)), default=())
    arm = _to_the_last_that_turns(best)
    if not any(joint.turns and joint.mimic is None for joint in arm):
        start = "the root link" if base is None else f"link {base!r}"
        slides = any(joint.kind in SLIDING for joint in tree.joints)
        held = (
            "; joints that slide are held, and do not count" if slides else "" if tree.joints else "; it has no joint"
        )
        raise ValueError(f"{tree.path}: no revolute joint between {start} and {tip or 'any tip'}{held}")
    for joint in arm:
        if joint.kind in TURNING and joint.lower > joint.upper:
            raise ValueError(
                f"{tree.path}: joint {joint.name!r}: its limits lower={joint.lower:g} upper={joint.upper:g} leave it "
                "no angle: swap them"
            )
    return Chain(arm[0].parent, tip or arm[-1].child, arm)


def turning_joints(arm: Chain) -> list[TreeJoint]:
    """The joints of an arm that turn, by themselves or with another one of it: those of `Robot`, in its order."""
    leaders = {joint.name for joint in arm.joints if joint.turns and joint.mimic is None}
    return [joint for joint in arm.joints if joint.turns and (joint.mimic is None or joint.mimic.of in leaders)]


def _path_to(tree: Tree, by_child: dict[str, TreeJoint], link: str, base: str | None) -> tuple[TreeJoint, ...] | None:
    """Joints from the base, or else the root, to `link`; None if the base is not above it."""
    chain: list[TreeJoint] = []
    while link in by_child and link != base:
        chain.append(by_child[link])
        link = chain[-1].parent
        if len(chain) > len(by_child):
            raise ValueError(f"{tree.path}: its links form a loop at {link!r}")
    return tuple(chain[::-1]) if base is None or link == base else None


def _without_fingers(tree: Tree, arm: tuple[TreeJoint, ...]) -> tuple[TreeJoint, ...]:
    """Less what is a hand: where two small branches or more, or joints so named, move at its end."""
    for k, joint in enumerate(arm):
        before = arm[:k]
        branches = [other for other in tree.joints if other.parent == joint.parent]
        moving = [branch for branch in branches if _moves_below(tree, branch)]
        if _count(before) >= FEWEST and len(moving) >= 2:
            if max(_reach(tree, branch) for branch in moving) < SMALL * _length(before):
                arm = before
                break
    end = len(arm)
    while end and (not _itself(arm[end - 1]) or _is_finger(arm[end - 1])):
        end -= 1
    if _count(arm[:end]) < FEWEST:
        return arm
    leaders = {joint.name for joint in arm[:end]}
    for k, joint in enumerate(arm[end:], end + 1):  # what moves with the arm is of it
        if joint.turns and joint.mimic is None:
            break
        if joint.mimic is not None and joint.mimic.of in leaders:
            end = k
    return arm[:end]


def _is_finger(joint: TreeJoint) -> bool:
    return bool(FINGER.search(f"{joint.name} {joint.child}") or GRIPPER.search(joint.name))


def _to_the_last_that_turns(arm: tuple[TreeJoint, ...]) -> tuple[TreeJoint, ...]:
    last = max((k + 1 for k, joint in enumerate(arm) if joint.turns), default=0)
    return arm[:last]


def _itself(joint: TreeJoint) -> bool:
    """Turns by itself."""
    return joint.turns and joint.moves


def _count(arm: tuple[TreeJoint, ...]) -> int:
    return sum(map(_itself, arm))


def _length(arm: tuple[TreeJoint, ...]) -> float:
    return sum(float(np.linalg.norm(joint.T_parent_joint[:3, 3])) for joint in arm)


def _below(tree: Tree, joint: TreeJoint) -> list[TreeJoint]:
    return [other for other in tree.joints if other.parent == joint.child]


def _moves_below(tree: Tree, joint: TreeJoint) -> bool:
    moves = joint.kind in (*TURNING, "prismatic") and (joint.mimic is not None or joint.lower < joint.upper)
    return moves or any(_moves_below(tree, other) for other in _below(tree, joint))


def _reach(tree: Tree, joint: TreeJoint) -> float:
    own = float(np.linalg.norm(joint.T_parent_joint[:3, 3]))
    return own + max((_reach(tree, other) for other in _below(tree, joint)), default=0.0)


# Which joint of the arm carries each link of a URDF, and where it then is.


def carrier_frames(tree: Tree, arm: Chain) -> dict[str, tuple[int, NDArray]]:
    """By link: the number of the arm's joint that carries it rigidly, 0 = base, and T_carrier_link (4, 4).

    Numbers are those of `Robot.joints`; all that is no joint of the arm is at rest.
    """
    number = {joint.name: k for k, joint in enumerate(turning_joints(arm), 1)}
    on_the_way = {joint.name for joint in arm.joints}
    hanging: dict[str, list[TreeJoint]] = {}
    for joint in tree.joints:
        hanging.setdefault(joint.parent, []).append(joint)
    root, T_root_base = _above(tree, arm.base)
    frames = {root: (0, np.linalg.inv(T_root_base))}
    waiting = [root]
    while waiting:
        link = waiting.pop()
        carrier, T_carrier_link = frames[link]
        for joint in hanging.get(link, []):
            if joint.name in number:
                frames[joint.child] = number[joint.name], np.eye(4)
            else:
                margin = REST_MARGIN if joint.name in on_the_way else 0.0
                frames[joint.child] = carrier, T_carrier_link @ joint.at(tree.rest(joint, margin))
            waiting.append(joint.child)
    return frames


def _above(tree: Tree, link: str) -> tuple[str, NDArray]:
    """The root over a link, and T_root_link."""
    by_child = {joint.child: joint for joint in tree.joints}
    T = np.eye(4)
    while link in by_child:
        joint = by_child[link]
        T = joint.at(tree.rest(joint)) @ T
        link = joint.parent
    return link, T
