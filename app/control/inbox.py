"""What passes between a page's controls and the scheduler.

viser runs callbacks on its own threads. Each does nothing but put the newest value, or an action, into the
inbox; the scheduler takes them out.
"""

import threading
from collections.abc import Callable

from ..viser_private import push_html

PENDING_LIMIT = 200  # actions that wait for the scheduler, per page


class Inbox:
    """Newest value a name, and actions in order; written by any thread, taken by the scheduler."""

    def __init__(self):
        self._lock = threading.Lock()
        self._values: dict[str, object] = {}
        self._actions: list[str] = []

    def put(self, name: str, value) -> None:
        with self._lock:
            self._values[name] = value

    def act(self, action: str) -> None:
        with self._lock:
            if len(self._actions) < PENDING_LIMIT:
                self._actions.append(action)

    def take(self, wanted: Callable[[str], bool] = lambda name: True) -> tuple[dict[str, object], list[str]]:
        """What is wanted of it, by name; the rest waits."""
        with self._lock:
            values = {name: value for name, value in self._values.items() if wanted(name)}
            actions = [action for action in self._actions if wanted(action)]
            self._values = {name: value for name, value in self._values.items() if name not in values}
            self._actions = [action for action in self._actions if not wanted(action)]
        return values, actions


def on_value(handle, inbox: Inbox, name: str) -> None:
    """A person's changes of a widget go into the inbox under this name."""

    @handle.on_update
    async def _(event) -> None:
        if event.client_id is not None:  # None: the page itself wrote it
            inbox.put(name, event.target.value)


def on_click(handle, inbox: Inbox, action: str) -> None:
    @handle.on_click
    async def _(_event) -> None:
        inbox.act(action)


def put(handle, value) -> None:
    """Write a value only if it differs: nothing is sent when nothing changes."""
    if handle.value != value:
        handle.value = value


def put_html(handle, content: str) -> None:
    if handle.content != content:
        push_html(handle, content)


def put_label(button, label: str, icon: str) -> None:
    """What a button does now."""
    if button.label != label:
        button.label, button.icon = label, icon
