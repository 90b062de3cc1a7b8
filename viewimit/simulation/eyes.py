"""What a session in a scene looks with and moves arms by: projected points, or pictures of arms that have weight."""

import importlib.util
import platform
import sys
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .disturbances import ActuatorSettings, ArmDisturbance, any_active, drive
from .markers import marker_names
from .robot import Angles
from .scene import Scene
from .world import World

__all__ = ["SimulatedEyes", "ProjectedEyes", "open_eyes", "require_eyes"]

NEEDS = {"pybullet": "pybullet", "cv2": "opencv"}  # packages, and the extras that bring them
WHEELS = "CPython 3.10 and 3.11 on Linux x86-64"  # of PyBullet; elsewhere pip would compile it, for minutes


class SimulatedEyes(Protocol):
    """N body points, matched by index; arms of m moving joints."""

    @property
    def world(self) -> World:
        """The truth that they look at, for viewers only."""
        ...

    @property
    def noise_px(self) -> float:
        """Standard deviation of an image coordinate, as their maker states it; a disturbance comes on top."""
        ...

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        """The demonstrator in [l], [r]. theta: m arrays of angles, rad, broadcast against each other to (...) →
        points (..., N, 4) px, visible (..., N, 2) bool. Coordinates of what is not visible mean nothing."""
        ...

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        """The learner in [L], [R], likewise."""
        ...

    def settle(self, theta: NDArray) -> NDArray:
        """Where an arm comes to rest that is told to stand at theta; (m,) rad each."""
        ...

    def drive(self, settings: ActuatorSettings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        """Where an arm at theta, last sent to `sent`, comes to rest once it is sent to `commanded`; (m,) rad each."""
        ...


# Image points as a camera's geometry has them, and arms without weight.


class ProjectedEyes:
    """See `protocol.SimulatedEyes`."""

    noise_px = 0.0

    def __init__(self, scene: Scene, points: int):
        self.world = World(scene, points)

    def demo_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        return self.world.demo_images(theta)

    def own_images(self, theta: Angles) -> tuple[NDArray, NDArray]:
        return self.world.own_images(theta)

    def settle(self, theta: NDArray) -> NDArray:
        return theta

    def drive(self, settings: ActuatorSettings, theta: NDArray, sent: NDArray, commanded: NDArray) -> NDArray:
        amounts, scene = settings.amounts(ArmDisturbance), self.world.scene
        if not any_active(amounts):
            return commanded
        return np.clip(drive(amounts, theta, theta + (commanded - sent)), scene.lower, scene.upper)


def open_eyes(camera: str, scene: Scene, points: int) -> SimulatedEyes:
    """camera: of `settings.CAMERAS`; points: layout of the scene, in place of which pictures show the markers.

    Raises ValueError as `require_eyes`.
    """
    if camera == "points":
        return ProjectedEyes(scene, points)
    require_eyes(camera, scene)
    from .rendering import RenderedEyes  # loads pybullet and OpenCV

    return RenderedEyes(scene)


def require_eyes(camera: str, scene: Scene) -> None:
    """Raises ValueError if what rendered pictures need is not installed, or the scene's robot has no markers, or its
    lenses distort."""
    if camera == "points":
        return
    missing = [package for package in NEEDS if importlib.util.find_spec(package) is None]
    if "pybullet" in missing and not pybullet_has_wheel():
        raise ValueError(f"camera images need PyBullet, which has wheels only for {WHEELS}")
    if missing:
        extras = ",".join(NEEDS[package] for package in missing)
        raise ValueError(f"camera images need what is not installed: pip install 'viewimit[{extras}]'")
    if scene.robot not in marker_names():
        raise ValueError(f"camera images need markers on the arm, which {' and '.join(marker_names())} have")
    head = scene.stereo_head()
    if head.left.is_distorted or head.right.is_distorted:
        raise ValueError("camera images are rendered without distortion: leave it out of the scene's head")


def pybullet_has_wheel() -> bool:
    """Whether PyBullet is installed here without a compiler, as pyproject.toml has it by default."""
    here = platform.python_implementation(), sys.platform, platform.machine()
    return here == ("CPython", "linux", "x86_64") and sys.version_info < (3, 12)
