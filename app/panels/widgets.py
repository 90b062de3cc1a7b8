"""Widgets of viser: what a person does with them goes into the queue, and they are written only if they differ."""

from collections.abc import Callable
from typing import Any

from viser import GuiButtonHandle, IconName

from ..control.commands.command import Command
from ..control.queue import CommandQueue
from ..viser_private import push_html


def on_value(handle, queue: CommandQueue, parse: Callable[[Any], Command]) -> None:
    """A person's changes of a widget go into the queue as what `parse` makes of them."""

    @handle.on_update
    async def _(event) -> None:
        if event.client_id is not None:  # None: the page itself wrote it
            queue.put_value(parse, event.target.value)


def on_click(handle, queue: CommandQueue, command: Command) -> None:
    @handle.on_click
    async def _(_event) -> None:
        queue.put(command)


def put(handle, value) -> None:
    """Write a value only if it differs: nothing is sent when nothing changes. A slider's own rounding is no change."""
    differs = abs(handle.value - value) > 1e-9 if _is_number(handle.value) else handle.value != value
    if differs:
        handle.value = value


def put_html(handle, content: str) -> None:
    if handle.content != content:
        push_html(handle, content)


def put_label(button: GuiButtonHandle, label: str, icon: IconName) -> None:
    """What a button does now."""
    if button.label != label:
        button.label, button.icon = label, icon


def put_visible(handle, visible: bool) -> None:
    if handle.visible != visible:
        handle.visible = visible


def _is_number(value) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)
