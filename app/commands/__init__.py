"""What a visitor can do: one decorated function a command, called by its name from keys, buttons, sliders and links."""

from . import display, links, method, session, tools
from .registry import COMMANDS

__all__ = ["COMMANDS", "display", "links", "method", "session", "tools"]
