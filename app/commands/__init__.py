"""What a visitor can do: one decorated function a command, called by its name from keys, buttons, sliders and links."""

from . import display, method, session, tools
from .registry import COMMANDS

__all__ = ["COMMANDS", "display", "method", "session", "tools"]
