"""The private parts of viser are still as they are relied upon."""

import asyncio
import dataclasses
from typing import get_type_hints

import pytest
from viewimit.app.viser_private import NearLoop, serving_with
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


def test_the_loop_is_woken_for_other_threads_only(event_loop):
    near, seen = NearLoop(event_loop), []

    async def inside() -> list:
        near.call_soon_threadsafe(seen.append, "at once")
        return list(seen)

    assert asyncio.run_coroutine_threadsafe(inside(), event_loop).result(5) == ["at once"]
    near.call_soon_threadsafe(seen.append, "soon")
    wait_until(lambda: seen == ["at once", "soon"])


def test_a_viser_that_opens_its_port_otherwise_is_not_left_unguarded():
    with pytest.raises(RuntimeError, match="opens its port in a way"), serving_with(lambda plain, *_, **__: None):
        pass
