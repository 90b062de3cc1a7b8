"""Robots by name, the shipped ones, or by the path of a URDF."""

from pathlib import Path

import numpy as np

from ..assets import ROOT
from .robot import Robot
from .urdf.formats import require_urdf
from .urdf.reference import is_reference, parse_reference


def robot_names() -> list[str]:
    """Names of the shipped robots."""
    return sorted(path.name for path in (ROOT / "robots").iterdir() if path.is_dir())


def load_robot(name: str | Path) -> Robot:
    """A shipped robot by name, or any URDF by path. Raises ValueError with what there is."""
    require_urdf(name)
    if is_reference(name):
        found = parse_reference(name)
        return Robot.from_urdf(found.path, found.tip, found.base)
    path = ROOT / "robots" / str(name) / f"{name}.urdf"
    if not path.is_file():
        raise ValueError(f"no robot {str(name)!r}; there are {', '.join(robot_names())}, or the path of a .urdf file")
    return Robot.from_urdf(path)


def require_joints(robot: Robot, joints: tuple[int, ...]) -> None:
    """Raises ValueError unless they are in order, of the robot's, and each moves by itself."""
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
        if joint not in robot.free:
            raise ValueError(
                f"joint {joint}, {one.name}, is held by its limits at {np.degrees(one.lower):.4g}°: give it a "
                '<limit lower=… upper=…> in the URDF, or type="continuous", or move another'
            )
