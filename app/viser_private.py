"""The one place that uses viser's private interface: its registries, and messages pushed without its setters."""

import asyncio
import contextlib
from collections.abc import Callable, Iterator

import numpy as np
import websockets.asyncio.server
from numpy.typing import NDArray
from viser import ClientHandle, ImageHandle, ViserServer
from viser._messages import GuiUpdateMessage, SceneNodeUpdateMessage, SetOrientationMessage
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed


@contextlib.contextmanager
def serving_with(serve: Callable) -> Iterator[None]:
    """A ViserServer made inside opens its port with serve(plain, handler, host, port, **options).

    plain: what viser would have called. Raises RuntimeError if viser did not open its port that way.
    """
    plain, used = websockets.asyncio.server.serve, []

    def opened(*args, **options):
        used.append(True)
        return serve(plain, *args, **options)

    websockets.asyncio.server.serve = opened
    try:
        yield
    finally:
        websockets.asyncio.server.serve = plain
    if not used:
        raise RuntimeError("this version of viser opens its port in a way that viewimit does not know")


def loop_of(server: ViserServer) -> asyncio.AbstractEventLoop:
    """In which the server receives and sends."""
    return server._websock_server._background_event_loop


def client_of(server: ViserServer, connection: ServerConnection) -> ClientHandle | None:
    """Whose connection it is; None before its first camera message."""
    for client_id, live in list(server._websock_server._live_connections.items()):
        if live is connection:
            return server.get_clients().get(client_id)
    return None


def connection_of(server: ViserServer, client_id: int) -> ServerConnection | None:
    """None once it is closed."""
    return server._websock_server._live_connections.get(client_id)


def answers(server: ViserServer, client_id: int, within: float) -> bool:
    """Whether the client is still there: it answers a ping within so many seconds. Not from viser's own thread."""
    connection, loop = connection_of(server, client_id), loop_of(server)

    async def ask() -> bool:
        try:
            await asyncio.wait_for(await connection.ping(), within)
        except (asyncio.TimeoutError, ConnectionClosed):
            return False
        return True

    return connection is not None and asyncio.run_coroutine_threadsafe(ask(), loop).result()


def cut_off(server: ViserServer, client_id: int) -> None:
    """Close a connection that nobody answers on."""
    connection, loop = connection_of(server, client_id), loop_of(server)
    if connection is not None:
        loop.call_soon_threadsafe(connection.transport.abort)


def widget_of(client: ClientHandle, uuid: str):
    """The client's own widget that takes input, or None."""
    return client.gui._gui_input_handle_from_uuid.get(uuid)


def command_of(client: ClientHandle, uuid: str):
    return client.gui._command_handle_from_uuid.get(uuid)


def has_node(client: ClientHandle, name: str) -> bool:
    return name in client.scene._handle_from_node_name


def has_gizmo(client: ClientHandle, name: str) -> bool:
    return name in client.scene._handle_from_transform_controls_name


def push_value(client: ClientHandle, widget) -> None:
    """Show what the widget's value is, whatever the browser has made of it."""
    client.gui._websock_interface.queue_message(GuiUpdateMessage(widget._impl.uuid, {"value": widget.value}))


def drop_upload(client: ClientHandle, transfer: str) -> None:
    """Forget what has come of an unfinished upload."""
    client.gui._current_file_upload_states.pop(transfer, None)


def push_orientation(client: ClientHandle, name: str, wxyz: tuple[float, float, float, float]) -> None:
    """Turn the client's own scene node `name` (a later push of the same node replaces one still unsent).

    `handle.wxyz = …` compares arrays and costs 60 µs a joint; thirty pages at 20 Hz would spend a core on it.
    """
    client.scene._queue_scene_message(SetOrientationMessage(name, wxyz))


def push_array(node, name: str, value: NDArray) -> None:
    """Set an array of a scene node, which nobody may change or read back afterwards.

    `node.name = …` looks up types, compares and copies, which takes longer than all the rest of drawing it.
    """
    node._impl.api._queue_scene_message(SceneNodeUpdateMessage(node.name, {name: value.astype(np.float32)}))


def push_html(handle, content: str) -> None:
    """Set an HTML widget's content without its setter's checks."""
    handle._impl.props.content = content
    handle._queue_update("content", content)


def push_jpeg(handle: ImageHandle, picture: bytes) -> None:
    """Show a picture that is packed already; the handle itself would take pixels, and pack them."""
    handle._data = picture
