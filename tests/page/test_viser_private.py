"""The private parts of viser are still as they are relied upon."""

import asyncio
import contextlib
import dataclasses
import io
from typing import get_type_hints

import pytest
import viser
from protocol import Client
from viewimit.app.viser_private import LoopEvent, NearLoop, serving_with, wake_in_loop
from viser import GuiHtmlHandle, GuiSliderHandle
from viser._messages import (
    GuiHtmlProps,
    GuiSliderProps,
    SceneNodeUpdateMessage,
    SetOrientationMessage,
    SetPositionMessage,
)
from waiting import wait_until


def test_the_private_messages_are_as_relied_upon():
    names = lambda message: [field.name for field in dataclasses.fields(message)]
    assert names(SetOrientationMessage) == ["name", "wxyz", "owner"]
    assert names(SetPositionMessage) == ["name", "position", "owner"]
    assert names(SceneNodeUpdateMessage) == ["name", "updates", "owner"]
    assert callable(GuiHtmlHandle._queue_update) and "content" in get_type_hints(GuiHtmlProps)
    assert "max" in get_type_hints(GuiSliderProps) and callable(GuiSliderHandle._queue_update)


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
    event = LoopEvent(event_loop)
    waiting = asyncio.run_coroutine_threadsafe(event.wait(), event_loop)
    event.set()
    assert not event.is_set()
    event_loop.call_soon_threadsafe(event.set)
    assert waiting.result(5) and event.is_set()


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


def test_a_viser_that_opens_its_port_otherwise_is_not_left_unguarded():
    with pytest.raises(RuntimeError, match="opens its port in a way"), serving_with(lambda plain, *_, **__: None):
        pass
