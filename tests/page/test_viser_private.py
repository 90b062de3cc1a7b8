"""The private parts of viser are still as they are relied upon."""

import dataclasses
from typing import get_type_hints

import pytest
from viewimit.app.viser_private import serving_with
from viser import GuiHtmlHandle
from viser._messages import GuiHtmlProps, SceneNodeUpdateMessage, SetOrientationMessage


def test_the_private_messages_are_as_relied_upon():
    names = lambda message: [field.name for field in dataclasses.fields(message)]
    assert names(SetOrientationMessage) == ["name", "wxyz", "owner"]
    assert names(SceneNodeUpdateMessage) == ["name", "updates", "owner"]
    assert callable(GuiHtmlHandle._queue_update) and "content" in get_type_hints(GuiHtmlProps)


def test_a_viser_that_opens_its_port_otherwise_is_not_left_unguarded():
    with pytest.raises(RuntimeError, match="opens its port in a way"), serving_with(lambda plain, *_, **__: None):
        pass
