"""Simulated eyes of a session: projected points, or detections in rendered pictures."""

from ..geometry.arrays import Floats
from .robot import Angles, BodyPoints, marker_names
from .scene import Scene
from .world import Visible, World


class SimulatedEyes:
    """How a simulated head sees N body points, matched by index; here as the cameras' geometry projects them.

    Attributes
    ----------
    world : World
        The ground truth, for viewers only.
    noise_px : float
        Standard deviation of an image coordinate [px], without disturbances.
    """

    noise_px: float = 0.0

    def __init__(self, scene: Scene, points: int = 10, body: BodyPoints | None = None):
        """points, body: as of `World`."""
        self.world: World = World(scene, points, body=body)

    def demo_images(self, theta: Angles) -> tuple[Floats, Visible]:
        """Take the images of the demonstrator, [l] and [r], as `World.demo_images` returns them."""
        return self.world.demo_images(theta)

    def own_images(self, theta: Angles) -> tuple[Floats, Visible]:
        """Take the images of the learner, [L] and [R]."""
        return self.world.own_images(theta)


def open_eyes(sensor: str, scene: Scene, points: int) -> SimulatedEyes:
    """Open the eyes of a session.

    sensor: "projected" for projected points, "rendered" for pictures, which show the markers instead; points: layout of
    the scene. Raises ValueError as `require_eyes`.
    """
    if sensor == "projected":
        return SimulatedEyes(scene, points)
    require_eyes(sensor, scene)
    from .rendering import RenderedEyes

    return RenderedEyes(scene)


def require_eyes(sensor: str, scene: Scene) -> None:
    """Raise ValueError if pictures cannot be rendered, because no markers are known for the robot."""
    if sensor != "projected" and scene.robot not in marker_names():
        raise ValueError(f"camera images need markers on the arm, which {' and '.join(marker_names())} have")
