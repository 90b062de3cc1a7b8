"""A client without a browser, for measuring a page and for testing it."""

import contextlib
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np


class QuietHandle:
    """Stands for any handle of viser and what it hangs on: keeps assigned values, sends nothing, can be a context."""

    content, value, visible, disabled, label, max = "", None, True, False, "", None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return self

    def __call__(self, *args, **kwargs):
        return QuietHandle()


@dataclass
class QuietClient:
    """A page's client: messages go nowhere."""

    client_id: int = 0
    scene: QuietHandle = field(default_factory=QuietHandle)
    gui: QuietHandle = field(default_factory=QuietHandle)
    camera: SimpleNamespace = field(
        default_factory=lambda: SimpleNamespace(image_width=552, image_height=720, position=np.ones(3))
    )

    def atomic(self):
        return contextlib.nullcontext()


def quiet_client(page_id: int) -> Any:
    """Return a client that stands for a viser.ClientHandle."""
    return QuietClient(page_id)
