"""Simulated arms: how a commanded posture is reached, exactly or against gravity."""

import importlib.util
import platform
import sys

from .disturbances import SimulatedArm
from .robot import robot_names
from .scene import Scene

__all__ = ["DYNAMICS", "SimulatedArm", "open_arm", "require_arm"]

DYNAMICS = ("none", "pybullet")
WHEELS = "CPython 3.10 and 3.11 on Linux x86-64"  # of PyBullet; elsewhere pip would compile it for minutes


def open_arm(dynamics: str, scene: Scene) -> SimulatedArm:
    """Make the arm of a scene: "none" without mass, "pybullet" with it. Raises ValueError as `require_arm`."""
    if dynamics == "none":
        return SimulatedArm(scene)
    require_arm(dynamics, scene)
    from .physics import PhysicalArm  # loads pybullet

    return PhysicalArm(scene)


def require_arm(dynamics: str, scene: Scene) -> None:
    """Raise ValueError if an arm with mass cannot be simulated: no PyBullet, or a robot without known masses."""
    if dynamics == "none":
        return
    if importlib.util.find_spec("pybullet") is None:
        install = "pip install 'viewimit[pybullet]'"
        if not pybullet_has_wheel():
            install = f"it has wheels only for {WHEELS}; elsewhere {install} compiles it"
        raise ValueError(f"arms with mass need PyBullet: {install}")
    if scene.robot not in robot_names():
        raise ValueError(f"arms with mass are simulated of the shipped robots only, {' and '.join(robot_names())}")


def pybullet_has_wheel() -> bool:
    """Return whether pip installs PyBullet here without a compiler."""
    here = platform.python_implementation(), sys.platform, platform.machine()
    return here == ("CPython", "linux", "x86_64") and sys.version_info < (3, 12)
