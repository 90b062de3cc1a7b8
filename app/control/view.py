"""How a page shows its session."""

from dataclasses import dataclass

SWITCHES = ("rays", "residuals", "gizmo", "whole_frames")  # that are kept by their names


@dataclass(frozen=True)
class View:
    """chosen: a point or None; rays … dark: the switches of the folder Display; help: whether it is open; fits: how
    often the visitor has asked for the default camera."""

    chosen: int | None = None
    rays: bool = False
    residuals: bool = True
    gizmo: bool = True
    whole_frames: bool = False
    dark: bool = False
    help: bool = False
    fits: int = 0
