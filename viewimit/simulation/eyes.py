"""Simulated eyes and arms of a session: projected points, or detections in rendered pictures of arms with mass."""

import importlib.util
import platform
import sys
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .disturbances import ActuatorSettings, ArmDisturbance, any_active, drive
from .robot import Angles, marker_names
from .scene import Scene
from .world import World

__all__ = ["SimulatedEyes", "ProjectedEyes", "open_eyes", "require_eyes"]

NEEDS = {"pybullet": "pybullet", "cv2": "opencv"}  # packages, and the extras that install them
WHEELS = "CPython 3.10 and 3.11 on Linux x86-64"  # of PyBullet; elsewhere pip would compile it for minutes

Floats = NDArray[np.float64]
Visible = NDArray[np.bool_]


class SimulatedEyes(Protocol):
    """Sees N body points, matched by index, and moves arms of m moving joints."""

    @property
    def world(self) -> World:
        """The ground truth, for viewers only."""
        ...

    @property
    def noise_px(self) -> float:
        """Standard deviation of an image coordinate [px], without disturbances."""
        ...

    def demo_images(self, theta: Angles) -> tuple[Floats, Visible]:
        """Take the images of the demonstrator, [l] and [r].

        Parameters
        ----------
        theta : m arrays
            Angles of the moving joints [rad], broadcast against each other to shape (...).

        Returns
        -------
        (..., N, 4) and (..., N, 2) arrays
            Points [px], and whether they are visible. Coordinates of other points mean nothing.
        """
        ...

    def own_images(self, theta: Angles) -> tuple[Floats, Visible]:
        """Take the images of the learner, [L] and [R].

        Parameters
        ----------
        theta : m arrays
            Angles of the moving joints [rad], broadcast against each other to shape (...).

        Returns
        -------
        (..., N, 4) and (..., N, 2) arrays
            Points [px], and whether they are visible.
        """
        ...

    def settle(self, theta: Floats) -> Floats:
        """Return the posture at which an arm comes to rest.

        Parameters
        ----------
        theta : (m,) array
            Posture at which it is placed [rad].

        Returns
        -------
        (m,) array
            Posture [rad].
        """
        ...

    def drive(self, settings: ActuatorSettings, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        """Return the posture that an arm reaches for a new command.

        Parameters
        ----------
        settings : ActuatorSettings
            Actuation errors.
        theta, sent : (m,) arrays
            Present posture, and the last command [rad].
        commanded : (m,) array
            New command [rad].

        Returns
        -------
        (m,) array
            Posture [rad].
        """
        ...


class ProjectedEyes:
    """Projects points through the cameras' geometry, and moves arms without mass. See `SimulatedEyes`."""

    noise_px: float = 0.0

    def __init__(self, scene: Scene, points: int):
        self.world: World = World(scene, points)

    def demo_images(self, theta: Angles) -> tuple[Floats, Visible]:
        return self.world.demo_images(theta)

    def own_images(self, theta: Angles) -> tuple[Floats, Visible]:
        return self.world.own_images(theta)

    def settle(self, theta: Floats) -> Floats:
        return theta

    def drive(self, settings: ActuatorSettings, theta: Floats, sent: Floats, commanded: Floats) -> Floats:
        amounts, scene = settings.amounts(ArmDisturbance), self.world.scene
        if not any_active(amounts):
            return commanded
        return np.clip(drive(amounts, theta, theta + (commanded - sent)), scene.lower, scene.upper)


def open_eyes(sensor: str, scene: Scene, points: int) -> SimulatedEyes:
    """Open the eyes of a session.

    Parameters
    ----------
    sensor : str
        "projected" for projected points, "rendered" for pictures.
    scene : Scene
    points : int
        Layout of the scene. Pictures show the markers instead.

    Raises
    ------
    ValueError
        As `require_eyes`.
    """
    if sensor == "projected":
        return ProjectedEyes(scene, points)
    require_eyes(sensor, scene)
    from .rendering import RenderedEyes  # loads pybullet and OpenCV

    return RenderedEyes(scene)


def require_eyes(sensor: str, scene: Scene) -> None:
    """Raise ValueError if pictures cannot be rendered: a missing package, no markers, or lenses with distortion."""
    if sensor == "projected":
        return
    missing = [package for package in NEEDS if importlib.util.find_spec(package) is None]
    if "pybullet" in missing and not pybullet_has_wheel():
        raise ValueError(f"camera images need PyBullet, which has wheels only for {WHEELS}")
    if missing:
        extras = ",".join(NEEDS[package] for package in missing)
        raise ValueError(f"camera images need packages that are missing: pip install 'viewimit[{extras}]'")
    if scene.robot not in marker_names():
        raise ValueError(f"camera images need markers on the arm, which {' and '.join(marker_names())} have")
    head = scene.stereo_head()
    if head.left.is_distorted or head.right.is_distorted:
        raise ValueError("camera images are rendered without distortion: leave it out of the scene's head")


def pybullet_has_wheel() -> bool:
    """Return whether pip installs PyBullet here without a compiler, as pyproject.toml does by default."""
    here = platform.python_implementation(), sys.platform, platform.machine()
    return here == ("CPython", "linux", "x86_64") and sys.version_info < (3, 12)
