"""The one place that uses viser's private interface. Each entry says what viser would have to offer instead."""

import asyncio
import contextlib
import itertools
from collections.abc import Callable, Iterator, Mapping
from typing import Any, NamedTuple

import websockets.asyncio.server
from numpy.typing import NDArray
from viser import ClientHandle, ImageHandle, ViserServer, _assignable_props_api
from viser._messages import GuiUpdateMessage, SceneNodeUpdateMessage, SetOrientationMessage
from viser.infra._messages import get_type_hints_cached

# The one change of viser for the whole process: each scene node and widget would look up the types of its kind again,
# a quarter of the time to open a page. Offer: the same, as viser does for its messages.
_assignable_props_api.get_type_hints = get_type_hints_cached  # type: ignore[assignment]


@contextlib.contextmanager
def serving_with(serve: Callable) -> Iterator[None]:
    """Let a ViserServer made inside open its port with serve(plain, handler, host, port, **options); else RuntimeError.
    plain: what it would have called. Offer: an argument of ViserServer by which connections are accepted."""
    module: Any = websockets.asyncio.server
    plain, calls = module.serve, itertools.count()
    module.serve = lambda *args, **options: (next(calls), serve(plain, *args, **options))[1]
    try:
        yield
    finally:
        module.serve = plain
    if next(calls) == 0:
        raise RuntimeError("this version of viser opens its port in a way that viewimit does not know")


class Own(NamedTuple):
    """A client's own handles, by the names in messages. Offer: `client.gui.get(uuid)`, `client.scene.get(name)`."""

    widgets: Mapping[str, Any]  # that take input
    commands: Mapping[str, Any]
    gizmos: Mapping[str, Any]


def own(client: ClientHandle) -> Own:
    inputs, commands = client.gui._gui_input_handle_from_uuid, client.gui._command_handle_from_uuid
    return Own(inputs, commands, client.scene._handle_from_transform_controls_name)


def drop_upload(client: ClientHandle, transfer: str) -> None:
    """Forget the parts of an unfinished upload. Offer: to refuse one."""
    client.gui._current_file_upload_states.pop(transfer, None)


def push_value(client: ClientHandle, widget) -> None:
    """Send the widget's value again, though it has not changed here. Offer: `widget.resend()`."""
    client.gui._websock_interface.queue_message(GuiUpdateMessage(widget._impl.uuid, {"value": widget.value}))


class LoopEvent(asyncio.Event):
    """An event that is set in its loop's thread alone, and not while the buffer is held: nothing is sent then."""

    def __init__(self, buffer):
        super().__init__()
        self._buffer = buffer

    def set(self) -> None:
        if self._buffer.atomic_counter == 0 and asyncio._get_running_loop() is self._buffer.event_loop:
            super().set()


def send_at_once(source: ViserServer | ClientHandle) -> None:
    """Send each message without waiting for more, and wake the sender in the event loop's own thread alone. viser waits
    17 ms by a timer before and after each window; a page pushes all of a tick before anything can be sent. viser's
    event is set in the pushing thread too, where now and then a push failed with "deque mutated during iteration".
    Offer: `window_duration_sec` as an argument; `AsyncMessageBuffer.push` that sets its event in the loop."""
    pushes = source._websock_server if isinstance(source, ViserServer) else source._websock_connection
    buffer: Any = pushes.get_message_buffer()
    buffer.window_duration_sec, replaced, buffer.message_event = 0.0, buffer.message_event, LoopEvent(buffer)
    buffer.event_loop.call_soon_threadsafe(replaced.set)  # who waits for it goes on with its successor


# Offer for the next four: setters without a comparison of arrays, a look at types and a task for every callback, which
# would take 13 % more of a page's processor time.
def push_orientation(client: ClientHandle, name: str, wxyz: tuple[float, float, float, float]) -> None:
    """Turn a scene node of its own. A later push of the same node replaces one that is still unsent."""
    client.scene._queue_scene_message(SetOrientationMessage(name, wxyz))


def push_array(node, name: str, value: NDArray) -> None:
    """Set an array of a scene node, which nobody may change or read back afterwards."""
    node._impl.api._queue_scene_message(SceneNodeUpdateMessage(node.name, {name: value.astype("f4", order="C")}))


def push_property(handle, name: str, value: str | float) -> None:
    """Set what a part of the panels is made with, such as the content of HTML, of its declared type."""
    setattr(handle._impl.props, name, value)
    handle._impl.gui_api._websock_interface.queue_message(GuiUpdateMessage(handle._impl.uuid, {name: value}))


def push_input(widget, value: float | str) -> None:
    """Show another value in a widget, without its callbacks, which are for a person's changes."""
    widget._impl.value = value
    widget._impl.gui_api._websock_interface.queue_message(GuiUpdateMessage(widget._impl.uuid, {"value": value}))


def push_jpeg(handle: ImageHandle, picture: bytes) -> None:
    """Show a picture that is packed already. Offer: images from bytes; the handle would take pixels, and pack them."""
    handle._data = picture
