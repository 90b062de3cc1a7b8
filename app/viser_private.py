"""The one place that uses viser's private interface. Each entry says what viser would have to offer in its stead."""

import asyncio
import contextlib
import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np
import websockets.asyncio.server
from numpy.typing import NDArray
from viser import ClientHandle, ImageHandle, ViserServer, _assignable_props_api
from viser._messages import GuiUpdateMessage, SceneNodeUpdateMessage, SetOrientationMessage, SetPositionMessage
from viser.infra import _async_message_buffer
from viser.infra._messages import get_type_hints_cached
from websockets.asyncio.server import ServerConnection

# Every scene node and every widget would look up the types of its kind anew, half of what it takes to make one. Offer:
# the same, as viser does for its messages.
_assignable_props_api.get_type_hints = get_type_hints_cached  # type: ignore[assignment]


@contextlib.contextmanager
def serving_with(serve: Callable) -> Iterator[None]:
    """A ViserServer made inside opens its port with serve(plain, handler, host, port, **options), plain being what it
    would have called; else RuntimeError. Offer: an argument of ViserServer by which connections are accepted."""
    module: Any = websockets.asyncio.server
    plain, calls = module.serve, itertools.count()
    module.serve = lambda *args, **options: (next(calls), serve(plain, *args, **options))[1]
    try:
        yield
    finally:
        module.serve = plain
    if next(calls) == 0:
        raise RuntimeError("this version of viser opens its port in a way that viewimit does not know")


def connection_of(server: ViserServer, client_id: int) -> ServerConnection | None:
    """None once it is closed. Offer: `client.connection`, for pings and for closing it."""
    return server._websock_server._live_connections.get(client_id)


def origin_of(server: ViserServer, client_id: int) -> str | None:
    """scheme://host:port of the browser's page; None if it does not say. Offer: `client.request.headers`."""
    connection = connection_of(server, client_id)
    request = None if connection is None else connection.request
    return None if request is None else request.headers.get("Origin")


class Own(NamedTuple):
    """What is a client's own, by what messages call it. Offer: `client.gui.get(uuid)`, `client.scene.get(name)`."""

    widgets: Mapping[str, Any]  # that take input
    commands: Mapping[str, Any]
    gizmos: Mapping[str, Any]


def own(client: ClientHandle) -> Own:
    gui, scene = client.gui, client.scene
    inputs, commands = gui._gui_input_handle_from_uuid, gui._command_handle_from_uuid
    return Own(inputs, commands, scene._handle_from_transform_controls_name)


def drop_upload(client: ClientHandle, transfer: str) -> None:
    """Forget what has come of an unfinished upload. Offer: to refuse one."""
    client.gui._current_file_upload_states.pop(transfer, None)


def push_value(client: ClientHandle, widget) -> None:
    """Show what the widget's value is, whatever the browser has made of it. Offer: `widget.resend()`."""
    client.gui._websock_interface.queue_message(GuiUpdateMessage(widget._impl.uuid, {"value": widget.value}))


class NearLoop:
    """An event loop that what is called in its own thread need not be woken for through its socket, which takes two
    calls of the system."""

    def __init__(self, loop: asyncio.AbstractEventLoop):
        self._loop = loop

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loop, name)

    def call_soon_threadsafe(self, callback: Callable, *args) -> None:
        if asyncio._get_running_loop() is self._loop:
            callback(*args)
        else:
            self._loop.call_soon_threadsafe(callback, *args)


class AtOnce:
    """asyncio for whoever sends what is pushed: it waits for nothing."""

    def __getattr__(self, name: str) -> Any:
        return getattr(asyncio, name)

    async def wait(self, tasks: Iterable[asyncio.Task], timeout: float) -> tuple[set, set]:
        return set(), set(tasks)


# Before and after all that is sent viser waits 17 ms whether more is pushed, by a timer and a future each, and longer
# while pages are drawn, so that two ticks' poses come as one. A page pushes all of a tick before anything can be sent.
# Offer: `window_duration_sec=0`, with which nothing waits.
_async_message_buffer.asyncio = AtOnce()  # type: ignore[assignment]


class LoopEvent(asyncio.Event):
    """It is set in its loop's thread alone: another's would change what the loop may be iterating over. held():
    whether nothing is to be sent yet, for which nobody needs to be woken."""

    def __init__(self, loop: asyncio.AbstractEventLoop, held: Callable[[], bool]):
        super().__init__()
        self._its_loop, self._held = loop, held

    def set(self) -> None:
        if not self._held() and asyncio._get_running_loop() is self._its_loop:
            super().set()


def wake_in_loop(source: ViserServer | ClientHandle) -> None:
    """What is pushed wakes who sends it in the event loop's own thread: never from another, where now and then a push
    failed with "deque mutated during iteration", and without a call of the system where that is the pushing one.
    Offer: the same in `AsyncMessageBuffer.push`, which sets its event in any thread, then once more in the loop."""
    pushes = source._websock_server if isinstance(source, ViserServer) else source._websock_connection
    buffer: Any = pushes.get_message_buffer()
    loop, replaced = buffer.event_loop, buffer.message_event
    buffer.message_event, buffer.event_loop = LoopEvent(loop, lambda: buffer.atomic_counter > 0), NearLoop(loop)
    loop.call_soon_threadsafe(replaced.set)  # who waits for it goes on with its successor


def ignore_late_pushes(client: ClientHandle) -> None:
    """Say nothing, the first time either, of what is drawn for a client before it is known that it has gone: on a
    server that is no fault. Offer: a page's choice, as viser gives itself with `_sanctioned_dead_writes`."""
    buffer: Any = client._websock_connection.get_message_buffer()
    buffer._warned_push_after_done = True


# Offer for the next three: messages that are known to hold what is sent. viser looks at the type of every value of a
# message, which takes twenty times as long as to name them.
class _Orientation(SetOrientationMessage):
    def as_serializable_dict(self, binary_buffers: list[memoryview] | None = None) -> dict[str, Any]:
        return {"type": "SetOrientationMessage", "name": self.name, "wxyz": self.wxyz, "owner": self.owner}


class _WidgetUpdate(GuiUpdateMessage):
    def as_serializable_dict(self, binary_buffers: list[memoryview] | None = None) -> dict[str, Any]:
        return {"type": "GuiUpdateMessage", "uuid": self.uuid, "updates": self.updates}


class _ArrayUpdate(SceneNodeUpdateMessage):
    """updates: one array, of all its memory in a row."""

    def as_serializable_dict(self, binary_buffers: list[memoryview] | None = None) -> dict[str, Any]:
        assert binary_buffers is not None, "of messages that are sent"
        ((name, array),) = self.updates.items()
        sent = {name: {"__binary_index": len(binary_buffers), "dtype": array.dtype.str}}
        binary_buffers.append(array.data)
        return {"type": "SceneNodeUpdateMessage", "name": self.name, "updates": sent, "owner": self.owner}


# Offer for the next five: setters without a comparison of arrays, a look at types and a task for every callback, which
# take 52 to 200 µs where the message takes 11 to 22; thirty pages at 20 Hz would spend a core on them.
def push_orientation(client: ClientHandle, name: str, wxyz: tuple[float, float, float, float]) -> None:
    """Turn a scene node of its own. A later push of the same node replaces one that is still unsent."""
    client.scene._queue_scene_message(_Orientation(name, wxyz))


def push_array(node, name: str, value: NDArray) -> None:
    """Set an array of a scene node, which nobody may change or read back afterwards."""
    node._impl.api._queue_scene_message(_ArrayUpdate(node.name, {name: value.astype(np.float32, order="C")}))


def push_position(node, position: tuple[float, float, float]) -> None:
    """Move a scene node, whose position nobody may read back afterwards."""
    node._impl.api._queue_scene_message(SetPositionMessage(node.name, position))


def push_property(handle, name: str, value: str | float) -> None:
    """Set what a part of the panels is made with, such as the content of HTML, of the type that it is declared with."""
    setattr(handle._impl.props, name, value)
    _queue_update(handle, name, value)


def push_input(widget, value: float | str) -> None:
    """Show a value in place of what the widget's is; its callbacks, which hear of nothing but what a person
    does, are not called."""
    widget._impl.value = value
    _queue_update(widget, "value", value)


def _queue_update(handle, name: str, value: str | float) -> None:
    handle._impl.gui_api._websock_interface.queue_message(_WidgetUpdate(handle._impl.uuid, {name: value}))


def push_jpeg(handle: ImageHandle, picture: bytes) -> None:
    """Show a picture that is packed already. Offer: images from bytes; the handle would take pixels, and pack them."""
    handle._data = picture
