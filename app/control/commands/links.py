"""Commands that make a page what a link holds."""

from __future__ import annotations

from dataclasses import dataclass

from ...sessions.link import Linked, read
from ..page_model import PageModel
from .command import Value


@dataclass(frozen=True)
class FollowLink(Value):
    """What somebody has sent, motion by motion: beside the page, as that may take seconds."""

    text: str

    def opens_pictures(self, model: PageModel) -> bool:
        try:
            return self.read(model).script.settings.sensor == "rendered"
        except ValueError:
            return False

    def apply(self, model: PageModel, now: float) -> None:
        linked = self.read(model)
        if linked.script.settings.sensor == "rendered":  # by the page's own camera images
            model.repeat(linked)
        else:
            model.following.begin(linked)

    def read(self, model: PageModel) -> Linked:
        return read(self.text, model.begun)
