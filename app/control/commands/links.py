"""Commands that make a page what a link holds."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from ...sessions.link import Linked, read
from ..memory import switched
from ..page_model import PageModel
from ..presets import AS_STARTED, Preset
from .command import Value


@dataclass(frozen=True)
class FollowLink(Value):
    """What somebody has sent, motion by motion: beside the scheduler, as that may take seconds."""

    text: str
    moves: ClassVar[bool] = True
    takes_long: ClassVar[bool] = True

    def opens_pictures(self, model: PageModel) -> bool:
        try:
            return self.read(model).script.settings.sensor == "rendered"
        except ValueError:
            return False

    def apply(self, model: PageModel, now: float) -> None:
        follow_link(model, self.read(model))

    def read(self, model: PageModel) -> Linked:
        return read(self.text, model.begun)


def follow_link(model: PageModel, linked: Linked, keep: bool = True) -> None:
    """The page becomes what the link holds; keep: Undo brings back what it was. Raises ValueError, with all as it
    is."""
    model.undoable.repeat(linked.script, keep)
    sent = Preset("From a link", linked.script.settings, linked.speed, "As it was sent.")
    model.presets.chosen = model.presets.offered.get(linked.preset, sent)
    if linked.preset == AS_STARTED and model.modified:  # another server was started otherwise
        model.presets.chosen = sent
    show_view_of(model, linked)
    model.undoable.begin_anew()


def show_view_of(model: PageModel, linked: Linked) -> None:
    """What of a link is no part of the session."""
    model.player.speed = linked.speed
    view = replace(switched(model.view, linked.show), chosen=linked.chosen)
    if view != model.view:
        model.view = view
