"""What a page's script sends by the page's own connection: clicks in its drawings, and what its browser says of itself.

It puts numbered actions into a text widget that nobody sees, and sends them again until the widget shows the last
number. So each is taken once, and in order, whatever becomes of the connection.
"""

from collections.abc import Callable, Mapping
from typing import Annotated

import msgspec

from ..commands.display import TOUCHES
from ..model.queue import Command, CommandQueue
from ..model.state import PageState
from ..sessions.link import MAX_TEXT
from ..viser_private import push_input
from .panel import Layout, Panel

LABEL = "vi-actions"  # of the widget
KEPT_LABEL = "vi-session"  # of the widget whose value is for the tab to keep
MAX_CHARS = 16_000  # of what it is sent
MAX_ACTIONS = 64  # of a message
PIECE = "piece"  # control of the first parts of a value

Number = Annotated[int, msgspec.Meta(ge=1)]
Control = Annotated[str, msgspec.Meta(max_length=20)]
Value = Annotated[str, msgspec.Meta(max_length=6_000)]  # a link is the longest; what is longer comes in pieces


class Message(msgspec.Struct, forbid_unknown_fields=True):
    """Actions as (number, control, value), numbered from 1 in each load of the page; load: a word for that load."""

    load: Annotated[str, msgspec.Meta(max_length=40)]
    acts: Annotated[list[tuple[Number, Control, Value]], msgspec.Meta(max_length=MAX_ACTIONS)]


def read_message(text: str) -> Message:
    """Decode a message. Raises ValueError for what is none."""
    if len(text) > MAX_CHARS:
        raise ValueError(f"{len(text)} characters of actions; at most {MAX_CHARS} are read")
    return msgspec.json.decode(text, type=Message)


class Actions:
    """Put each new action into a page's queue.

    Parameters
    ----------
    queue
        The page's.
    parsers
        By control: what a value of it asks for, or ValueError.
    """

    def __init__(self, queue: CommandQueue, parsers: Mapping[str, Callable[[str], Command]]):
        self._queue, self._parsers = queue, parsers
        self._load = ""
        self._pieces = ""  # of the next value
        self.last = 0  # number that was taken

    def take(self, text: str) -> None:
        """Take what is new of a message. Raises ValueError for what is none."""
        message = read_message(text)
        if message.load != self._load:
            self._load, self.last = message.load, 0
        for number, control, value in message.acts:
            if number > self.last:
                self.last = number
                if control == PIECE:
                    self._pieces = (self._pieces + value)[: MAX_TEXT + 1]  # one too many is refused where it is read
                    continue
                self._queue.put_value(self._parser(control), self._pieces + value, ("action", control))
                self._pieces = ""

    def _parser(self, control: str) -> Callable[[str], Command]:
        def unknown(value: str) -> Command:
            raise ValueError(f"this page has no {control!r}: reload it")

        return self._parsers.get(control, unknown)


# Hidden text widgets: for what is clicked in drawings, and for what the tab keeps.


class ActionsPanel(Panel):
    def build(self, layout: Layout, state: PageState) -> None:
        self.actions = Actions(layout.queue, TOUCHES)
        box = layout.gui.add_text(LABEL, "", visible=False)

        @box.on_update
        async def _(event) -> None:
            if event.client_id is not None:  # None: the page itself wrote it
                self.actions.take(event.target.value)
                push_input(box, str(self.actions.last))

        self._kept = layout.gui.add_text(KEPT_LABEL, "", visible=False)

    @property
    def last(self) -> int:
        """The number of the last action that was taken."""
        return self.actions.last

    def send_part(self, part: str) -> None:
        """Send the tab a part of what it is to keep."""
        push_input(self._kept, part)

    def depends_on(self, state: PageState) -> tuple:
        return ()

    def show(self, state: PageState) -> None:
        """It shows nothing."""
