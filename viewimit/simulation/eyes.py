"""Simulated eyes of a session: projected points, or detections in rendered pictures."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .robot import Angles, marker_names
from .scene import Scene
from .world import World

__all__ = ["SimulatedEyes", "ProjectedEyes", "open_eyes", "require_eyes"]

Floats = NDArray[np.float64]
Visible = NDArray[np.bool_]


class SimulatedEyes(Protocol):
    """Sees N body points, matched by index."""

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


class ProjectedEyes:
    """Projects points through the cameras' geometry. See `SimulatedEyes`."""

    noise_px: float = 0.0

    def __init__(self, scene: Scene, points: int):
        self.world: World = World(scene, points)

    def demo_images(self, theta: Angles) -> tuple[Floats, Visible]:
        return self.world.demo_images(theta)

    def own_images(self, theta: Angles) -> tuple[Floats, Visible]:
        return self.world.own_images(theta)


def open_eyes(sensor: str, scene: Scene, points: int) -> SimulatedEyes:
    """Open the eyes of a session.

    sensor: "projected" for projected points, "rendered" for pictures, which show the markers instead; points: layout of
    the scene. Raises ValueError as `require_eyes`.
    """
    if sensor == "projected":
        return ProjectedEyes(scene, points)
    require_eyes(sensor, scene)
    from .rendering import RenderedEyes

    return RenderedEyes(scene)


def require_eyes(sensor: str, scene: Scene) -> None:
    """Raise ValueError if pictures cannot be rendered, because no markers are known for the robot."""
    if sensor != "projected" and scene.robot not in marker_names():
        raise ValueError(f"camera images need markers on the arm, which {' and '.join(marker_names())} have")
