"""The experiments' figures by name, on the page and in files."""

from ...simulation.scene import Scene, load_scene
from . import fig7_figure, fig8_figure, fig9_figure, fig10_figure

VIEWS = {"fig7": fig7_figure.draw, "fig9": fig9_figure.draw, "fig10": fig10_figure.draw}  # all of one size
TITLES = {
    "fig7": "Fig. 7: E over the postures of the learner",
    "fig8": "Fig. 8: E over the postures of the learner, on pictures",
    "fig9": "Fig. 9: joint angles and E over the motions",
    "fig10": "Fig. 10: a trajectory imitated by a frozen transfer",
}


def draw(name: str, found) -> str:
    """Of a result, or of what is there of it so far."""
    settings = found.settings
    scene = load_scene(settings.scene, settings.robot, settings.joints)
    return fig8_figure.draw(scene, found) if name == "fig8" else VIEWS[name](scene, found)


def draw_empty(name: str, scene: Scene) -> str:
    """Frames and axes, and one sentence that says what the experiment shows."""
    return VIEWS[name](scene)
