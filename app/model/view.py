"""How a page shows its session: what its visitor and its browser have chosen, and messages."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

LARGE = ("images", "figures", "l", "r", "L", "R")  # the panels, one of the images
CLIENT_REPORTED = ("prefers_dark", "flat", "truth", "unseen")  # fields that the browser reports
WINDOW = "window"  # in place of all tabs' names
SWITCHES = (
    "goal",
    "rays",
    "residuals",
    "gizmo",
    "whole_frames",
    "rectified",
    "shadows",
)  # kept by their names
SWITCHED = {name: name for name in (*SWITCHES, "flat", "dark", "look_only")}  # that the visitor sets


@dataclass(frozen=True)
class View:
    """Choices of one page. `on` tells the switches that follow the browser until the visitor chooses."""

    chosen: int | None = None  # body point that is explained
    goal: bool = True  # from here to `dark`: the switches of the folder Display
    rays: bool = False
    residuals: bool = True
    gizmo: bool = True
    whole_frames: bool = False
    rectified: bool = False
    shadows: bool = False
    flat: bool = False  # a still picture instead of the 3-D view, as a browser without WebGL or speed asks for it
    dark: bool | None = None  # None: as the browser prefers
    prefers_dark: bool = False  # the browser's preference
    help: bool = False  # whether the help is open
    fits: int = 0  # how often the visitor has asked for the default camera
    look_only: bool = False  # a posture that is clicked is previewed, and nothing moves
    share: bool = False  # whether the card with link and code is open
    large: str | None = None  # of LARGE: what fills the window beside the controls
    picture: str = "Images"  # panel that is saved as a picture
    picture_as: str = "SVG"
    truth: bool = (
        True  # whether the scene shows what only the viewer knows; hidden before a class until it is asked for
    )
    unseen: frozenset[str] = frozenset()  # tabs that are not open, or WINDOW where nobody sees any of the page

    def on(self, switch: str) -> bool:
        """Return whether a switch is on, by its name."""
        chosen = getattr(self, switch)
        return self.prefers_dark if chosen is None else chosen


def switched(view: View, show: Mapping[str, bool]) -> View:
    """Return a view with the switches on or off that are kept by their names."""
    known: dict[str, Any] = {name: show[name] for name in SWITCHES if name in show}
    return replace(view, **known)


@dataclass(frozen=True)
class Message:
    """A sentence for the visitor, until a time of the scheduler's clock, s."""

    text: str
    until: float
