"""The private parts of viser are still as they are relied upon."""

import asyncio
import contextlib
import dataclasses
import io
import warnings
from types import SimpleNamespace
from typing import get_type_hints

import numpy as np
import pytest
import viser
from protocol import Client
from viewimit.app.viser_private import (
    LoopEvent,
    NearLoop,
    _ArrayUpdate,
    _Orientation,
    _WidgetUpdate,
    ignore_late_pushes,
    push_array,
    serving_with,
    wake_in_loop,
)
from viser._messages import (
    GuiHtmlProps,
    GuiSliderProps,
    GuiUpdateMessage,
    Message,
    SceneNodeUpdateMessage,
    SetOrientationMessage,
    SetPositionMessage,
)
from viser.infra._async_message_buffer import AsyncMessageBuffer
from waiting import wait_until


def test_the_private_messages_are_as_relied_upon():
    names = lambda message: [field.name for field in dataclasses.fields(message)]
    assert names(SetOrientationMessage) == ["name", "wxyz", "owner"]
    assert names(SetPositionMessage) == ["name", "position", "owner"]
    assert names(SceneNodeUpdateMessage) == ["name", "updates", "owner"]
    assert names(GuiUpdateMessage) == ["uuid", "updates"]
    assert "content" in get_type_hints(GuiHtmlProps) and "max" in get_type_hints(GuiSliderProps)


def test_messages_of_ones_own_are_sent_as_visers_are():
    turned = "/arm/joint", (1.0, 0.0, 0.0, 0.0)
    points = np.arange(6, dtype=np.float32).reshape(2, 3)
    for own, plain in (
        (_Orientation(*turned), SetOrientationMessage(*turned)),
        (_WidgetUpdate("uuid", {"content": "<b>θ</b>"}), GuiUpdateMessage("uuid", {"content": "<b>θ</b>"})),
        (_WidgetUpdate("uuid", {"value": 3}), GuiUpdateMessage("uuid", {"value": 3})),
        (_ArrayUpdate("/now/rays", {"points": points}), SceneNodeUpdateMessage("/now/rays", {"points": points})),
    ):
        for message in (own, plain):
            if hasattr(message, "owner"):
                message.owner = "of a client"
        theirs, ours = [memoryview(b"before")], [memoryview(b"before")]
        assert own.as_serializable_dict(ours) == plain.as_serializable_dict(theirs)
        assert [bytes(buffer) for buffer in ours] == [bytes(buffer) for buffer in theirs]
        assert own.entity_state_key() == plain.entity_state_key() is not None
        assert type(own) not in Message.get_subclasses(), "or it would be looked for in what browsers send"


def test_an_array_is_sent_in_the_order_of_its_rows():
    sent = []
    node = SimpleNamespace(name="/a", _impl=SimpleNamespace(api=SimpleNamespace(_queue_scene_message=sent.append)))
    push_array(node, "points", np.arange(6.0).reshape(3, 2).T)
    buffers: list[memoryview] = []
    assert sent[0].as_serializable_dict(buffers)["updates"] == {"points": {"__binary_index": 0, "dtype": "<f4"}}
    assert np.frombuffer(buffers[0], np.float32).tolist() == [0, 2, 4, 1, 3, 5]


def test_types_of_a_kind_of_node_are_looked_up_once():
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        one, other = (server.scene.add_icosphere(name, 1.0) for name in ("one", "other"))
        assert one._prop_hints is other._prop_hints and "radius" in one._prop_hints
    finally:
        server.stop()


def test_the_loop_is_woken_for_other_threads_only(event_loop):
    near, seen = NearLoop(event_loop), []

    async def inside() -> list:
        near.call_soon_threadsafe(seen.append, "at once")
        return list(seen)

    assert asyncio.run_coroutine_threadsafe(inside(), event_loop).result(5) == ["at once"]
    near.call_soon_threadsafe(seen.append, "soon")
    wait_until(lambda: seen == ["at once", "soon"])


def test_an_event_is_set_in_its_loop_alone(event_loop):
    event = LoopEvent(event_loop, lambda: False)
    waiting = asyncio.run_coroutine_threadsafe(event.wait(), event_loop)
    event.set()
    assert not event.is_set()
    event_loop.call_soon_threadsafe(event.set)
    assert waiting.result(5) and event.is_set()
    held = LoopEvent(event_loop, lambda: True)
    asyncio.run_coroutine_threadsafe(_in_loop(held.set), event_loop).result(5)
    assert not held.is_set()


async def _in_loop(do):
    do()


def test_what_another_thread_pushes_wakes_every_page():
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        early = Client(f"http://127.0.0.1:{server.get_port()}")
        wait_until(server.get_clients)
        wake_in_loop(server)
        pages = [early, Client(f"http://127.0.0.1:{server.get_port()}")]
        wait_until(lambda: len(server.get_clients()) == len(pages))
        for client in server.get_clients().values():
            wake_in_loop(client)
        for k in range(20):
            server.scene.add_frame(f"/all/{k}", visible=False)
            for client in server.get_clients().values():
                client.gui.add_html(f"{k}")
            wait_until(lambda k=k: all(f"/all/{k}" in page.nodes and f"{k}" in page.html.values() for page in pages))
    finally:
        server.stop()


def test_what_is_drawn_for_a_client_that_has_gone_is_no_line_in_the_log():
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            drawn = []
            for quietly in (False, True):
                with Client(f"http://127.0.0.1:{server.get_port()}"):
                    wait_until(lambda: len(server.get_clients()) == 1)
                    (client,) = server.get_clients().values()
                    if quietly:
                        ignore_late_pushes(client)
                wait_until(lambda: not server.get_clients())
                client.gui.add_html("late")
                drawn.append(len(said))
            assert drawn == [1, 1], "viser warns by itself, and not where it is told"
        finally:
            server.stop()


def test_a_viser_that_opens_its_port_otherwise_is_not_left_unguarded():
    with pytest.raises(RuntimeError, match="opens its port in a way"), serving_with(lambda plain, *_, **__: None):
        pass


def test_what_is_pushed_is_sent_at_once_and_all_that_one_tick_pushes_in_one_window(event_loop):
    async def windows():
        buffer = AsyncMessageBuffer(asyncio.get_running_loop(), persistent_messages=False, window_duration_sec=60.0)
        generator = buffer.window_generator(0)
        sent = []
        for tick in range(3):
            coming = asyncio.ensure_future(anext(generator))
            await asyncio.sleep(0)  # it waits for something to come
            for joint in "ab":
                buffer.push(SetOrientationMessage(joint, (1.0, 0.0, 0.0, float(tick))))
            sent.append([(message.name, message.wxyz[3]) for message in await asyncio.wait_for(coming, 5.0)])
        await generator.aclose()
        return sent

    sent = asyncio.run_coroutine_threadsafe(windows(), event_loop).result(20.0)
    assert sent == [[("a", tick), ("b", tick)] for tick in range(3)]
