"""The private parts of viser are still as they are relied upon."""

import asyncio
import contextlib
import dataclasses
import io
from types import SimpleNamespace
from typing import get_type_hints

import numpy as np
import pytest
import viser
from protocol import Client
from viewimit.app.viser_private import LoopEvent, push_array, send_at_once, serving_with
from viser._messages import (
    GuiHtmlProps,
    GuiSliderProps,
    GuiUpdateMessage,
    SceneNodeUpdateMessage,
    SetOrientationMessage,
)
from viser.infra._async_message_buffer import AsyncMessageBuffer
from waiting import wait_until


def test_the_private_messages_are_as_relied_upon():
    names = lambda message: [field.name for field in dataclasses.fields(message)]
    assert names(SetOrientationMessage) == ["name", "wxyz", "owner"]
    assert names(SceneNodeUpdateMessage) == ["name", "updates", "owner"]
    assert names(GuiUpdateMessage) == ["uuid", "updates"]
    assert "content" in get_type_hints(GuiHtmlProps) and "max" in get_type_hints(GuiSliderProps)


def test_an_array_is_sent_in_the_order_of_its_rows():
    sent = []
    node = SimpleNamespace(name="/a", _impl=SimpleNamespace(api=SimpleNamespace(_queue_scene_message=sent.append)))
    push_array(node, "points", np.arange(6.0).reshape(3, 2).T)
    buffers: list[memoryview] = []
    assert sent[0].as_serializable_dict(buffers)["updates"] == {"points": {"__binary_index": 0, "dtype": "<f4"}}
    assert np.frombuffer(buffers[0], np.float32).tolist() == [0, 2, 4, 1, 3, 5]


def test_an_event_is_set_in_its_loop_alone_and_not_while_its_buffer_is_held(event_loop):
    async def made():
        return LoopEvent(SimpleNamespace(atomic_counter=0, event_loop=event_loop))

    event = in_loop(event_loop, made())
    waiting = asyncio.run_coroutine_threadsafe(event.wait(), event_loop)
    event.set()
    assert not event.is_set()
    event_loop.call_soon_threadsafe(event.set)
    assert waiting.result(5) and event.is_set()

    async def set_while_held():
        held = LoopEvent(SimpleNamespace(atomic_counter=1, event_loop=event_loop))
        held.set()
        return held.is_set()

    assert not in_loop(event_loop, set_while_held())


def in_loop(loop: asyncio.AbstractEventLoop, coroutine):
    return asyncio.run_coroutine_threadsafe(coroutine, loop).result(20)


def test_what_another_thread_pushes_wakes_every_page():
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    try:
        early = Client(f"http://127.0.0.1:{server.get_port()}")
        wait_until(server.get_clients)
        send_at_once(server)
        pages = [early, Client(f"http://127.0.0.1:{server.get_port()}")]
        wait_until(lambda: len(server.get_clients()) == len(pages))
        for client in server.get_clients().values():
            send_at_once(client)
        for k in range(20):
            server.scene.add_frame(f"/all/{k}", visible=False)
            for client in server.get_clients().values():
                client.gui.add_html(f"{k}")
            wait_until(lambda k=k: all(f"/all/{k}" in page.nodes and f"{k}" in page.html.values() for page in pages))
    finally:
        server.stop()


def test_a_viser_that_opens_its_port_otherwise_is_not_left_unguarded():
    with pytest.raises(RuntimeError, match="opens its port in a way"), serving_with(lambda plain, *_, **__: None):
        pass


def test_what_is_pushed_is_sent_at_once_and_all_that_one_tick_pushes_in_one_window(event_loop):
    async def windows():
        buffer = AsyncMessageBuffer(asyncio.get_running_loop(), persistent_messages=False, window_duration_sec=60.0)
        send_at_once(SimpleNamespace(_websock_connection=SimpleNamespace(get_message_buffer=lambda: buffer)))
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

    assert in_loop(event_loop, windows()) == [[("a", tick), ("b", tick)] for tick in range(3)]
