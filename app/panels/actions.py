"""What a page's script sends by the page's own connection: clicks in its drawings, and what its browser says of itself.
It puts numbered actions into a text widget that nobody sees, and sends them again until the widget shows the last
number. So each is taken once, and in order, even if the connection breaks."""

from collections.abc import Callable
from functools import partial
from typing import Annotated

import msgspec

from viewimit.loop.link import MAX_LINK

from ..model.page_model import PageModel
from ..model.queue import CommandQueue
from ..viser_private import push_input
from .panel import Layout

LABEL = "vi-actions"  # of the widget
KEPT_LABEL = "vi-session"  # of the widget whose value is for the tab to keep
MAX_CHARS = 16_000  # of what it is sent
MAX_ACTIONS = 64  # of a message

Number = Annotated[int, msgspec.Meta(ge=1)]
Control = Annotated[str, msgspec.Meta(max_length=20)]
Value = Annotated[str, msgspec.Meta(max_length=MAX_LINK)]  # a link is the longest


class Message(msgspec.Struct, forbid_unknown_fields=True):
    """Actions as (number, control, value), numbered from 1 in each load of the page; load: a word for that load."""

    load: Annotated[str, msgspec.Meta(max_length=40)]
    acts: Annotated[list[tuple[Number, Control, Value]], msgspec.Meta(max_length=MAX_ACTIONS)]


def read_message(text: str) -> Message:
    """Decode a message. Raises ValueError for an invalid one."""
    if len(text) > MAX_CHARS:
        raise ValueError(f"{len(text)} characters of actions; at most {MAX_CHARS} are read")
    return msgspec.json.decode(text, type=Message)


class Actions:
    """Put each new action into a page's queue."""

    def __init__(self, queue: CommandQueue):
        self._queue = queue
        self._load = ""
        self.keep: Callable[[str], None] = lambda kept: None  # sends the tab what it is to keep
        self.last = 0  # number that was taken

    def take(self, text: str) -> None:
        """Take the new actions of a message. Raises ValueError for an invalid one."""
        message = read_message(text)
        if message.load != self._load:
            self._load, self.last = message.load, 0
        for number, control, value in message.acts:
            if number > self.last:
                self.last = number
                self._call(control, value)

    def _call(self, control: str, value: str) -> None:
        command, sender = self._queue.commands.get(control), ("action", control)
        if command is None or not command.link:
            self._queue.reject(f"this page has no control {control!r}: reload it", sender)
        else:
            self._queue.call(control, *[value] * len(command.parsers), sender=sender)


def actions(layout: Layout, model: PageModel) -> None:
    """Hidden text widgets: for clicks in drawings, and for the text that the tab stores."""
    taken = layout.named["actions"] = Actions(layout.queue)
    box = layout.gui.add_text(LABEL, "", visible=False)

    @box.on_update
    async def take(event) -> None:
        if event.client_id is not None:  # None: the page itself wrote it
            taken.take(event.target.value)
            push_input(box, str(taken.last))

    kept = layout.gui.add_text(KEPT_LABEL, "", visible=False)
    taken.keep = partial(push_input, kept)
