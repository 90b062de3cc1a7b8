"""What a person did and what workers have made, in order, until the page's loop takes it."""

import threading
from collections.abc import Callable
from typing import Any

from .commands.command import Command, Refused

PENDING_LIMIT = 200  # actions that wait, per page


def _all(command: Command) -> bool:
    return True


class CommandQueue:
    """Any thread puts, the scheduler takes. Of one control the newest value wins, unless an action lies between.

    "Slider, then reset" and "reset, then slider" are two things; a hundred values of one dragged slider are one.
    """

    def __init__(self):
        self._lock = threading.Lock()
        self._waiting: list[Command] = []

    def put(self, command: Command) -> None:
        with self._lock:
            full = len(self._waiting) >= PENDING_LIMIT
            if command.control is not None:
                self._drop_older(command, beyond_actions=full)
            elif full:
                return
            self._waiting.append(command)

    def put_value(self, parse: Callable[[Any], Command], value: Any) -> None:
        """The command that a browser's value stands for, checked here and nowhere else: parse may raise ValueError."""
        try:
            command = parse(value)
        except ValueError as refusal:
            command = Refused(str(refusal))
        self.put(command)

    def on_value(self, widget: Any, parse: Callable[[Any], Command]) -> None:
        """A person's changes of a widget are put as what `parse` makes of them."""

        @widget.on_update
        async def _(event) -> None:
            if event.client_id is not None:  # None: the page itself wrote it
                self.put_value(parse, event.target.value)

    def on_click(self, widget: Any, command: Command) -> None:
        @widget.on_click
        async def _(_event) -> None:
            self.put(command)

    def take(self, wanted: Callable[[Command], bool] = _all) -> list[Command]:
        """What is wanted of it, in order; the rest waits."""
        with self._lock:
            taken = [command for command in self._waiting if wanted(command)]
            self._waiting = [command for command in self._waiting if not wanted(command)]
        return taken

    def _drop_older(self, command: Command, beyond_actions: bool) -> None:
        for k in reversed(range(len(self._waiting))):
            other = self._waiting[k]
            if other.control == command.control:
                del self._waiting[k]
                return
            if other.control is None and not beyond_actions:
                return
