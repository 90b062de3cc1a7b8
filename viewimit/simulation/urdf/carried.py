"""Which joint of the arm carries each link of a URDF, and where it then is."""

import numpy as np
from numpy.typing import NDArray

from .chain import Chain, turning_of
from .tree import MARGIN, Tree, TreeJoint


def carried_frames(tree: Tree, arm: Chain) -> dict[str, tuple[int, NDArray]]:
    """By link: the number of the arm's joint that carries it rigidly, 0 = base, and T_carrier_link (4, 4).

    Numbers are those of `Robot.joints`; all that is no joint of the arm is at rest.
    """
    number = {joint.name: k for k, joint in enumerate(turning_of(arm), 1)}
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
                margin = MARGIN if joint.name in on_the_way else 0.0
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
