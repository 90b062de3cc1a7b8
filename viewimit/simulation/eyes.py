"""Simulated eyes of a session: projected points, or detections in rendered pictures."""

from .robot import marker_names
from .scene import Scene
from .world import SimulatedEyes

__all__ = ["SimulatedEyes", "open_eyes", "require_eyes"]


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
