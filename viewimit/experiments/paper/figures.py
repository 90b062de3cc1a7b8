"""The experiments' figures by name; all are as large as each other."""

from ...simulation.scene import Scene, load_scene
from . import fig7_figure, fig9_figure, fig10_figure

VIEWS = {"fig7": fig7_figure.draw, "fig9": fig9_figure.draw, "fig10": fig10_figure.draw}


def draw(name: str, found) -> str:
    """Of a result, or of what is there of it so far."""
    settings = found.settings
    return VIEWS[name](load_scene(settings.scene, settings.robot, settings.joints), found)


def draw_empty(name: str, scene: Scene) -> str:
    """Frames and axes, and one sentence that says what the experiment shows."""
    return VIEWS[name](scene)
