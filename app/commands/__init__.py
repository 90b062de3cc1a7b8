"""What a visitor can do: one function a command, called by its name from keys, buttons, sliders and links."""

from ..model.queue import COMMANDS, command
from . import display, method, session, tools

__all__ = ["COMMANDS", "command", "display", "method", "session", "tools"]
