"""The private parts of viser are still as they are relied upon."""

import asyncio
import contextlib
import dataclasses
import io
from types import SimpleNamespace
from typing import get_type_hints

import pytest
import viser
from protocol import Client
from viewimit.app.viser_private import LoopEvent, send_at_once, serving_with
from viser._messages import (
    GuiHtmlProps,
    GuiSliderProps,
    GuiUpdateMessage,
    SceneNodeUpdateMessage,
    SetOrientationMessage,
)
from waiting import wait_until


def test_the_private_messages_are_as_relied_upon():
    names = lambda message: [field.name for field in dataclasses.fields(message)]
    assert names(SetOrientationMessage) == ["name", "wxyz", "owner"]
    assert names(SceneNodeUpdateMessage) == ["name", "updates", "owner"]
    assert names(GuiUpdateMessage) == ["uuid", "updates"]
    assert "content" in get_type_hints(GuiHtmlProps) and "max" in get_type_hints(GuiSliderProps)


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
