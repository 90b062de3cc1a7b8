"""Layouts of body points to choose from: the scene's own, and the one that was made by hand."""

from typing import Any

from viewimit.loop.settings import Settings
from viewimit.simulation.scene import load_scene


def layout_choices(settings: Settings) -> dict[str, dict[str, Any]]:
    """Settings to change, by name; none for the points by hand, if there are some."""
    own = load_scene(settings.scene, settings.robot).points
    choices: dict[str, dict[str, Any]] = {
        f"{count} points": {"points": int(count), "body_points": None} for count in own
    }
    return choices if settings.body_points is None else {**choices, chosen_layout(settings): {}}


def chosen_layout(settings: Settings) -> str:
    """The name of the layout that there is now."""
    return f"{settings.points} points" if settings.body_points is None else f"{len(settings.body_points)} by hand"
