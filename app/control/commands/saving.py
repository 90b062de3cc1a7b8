"""Commands that hand the visitor files: a replay, pictures."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from ..checks import choice
from ..page_model import PageModel
from ..saving import FORMATS, PICTURES
from .command import Command, Value

WRITES = 6.0  # s that it is said


class SaveReplay(Command):
    """The session as one page that needs no server."""

    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.saving.replay(model.session, model.view.chosen)
        model.say("writing the replay: one file that opens anywhere, without a server …", now + WRITES)


@dataclass(frozen=True)
class PictureChoice(Value):
    """Which panel is saved, or in which format: a field of `View`, and what it becomes."""

    field: str
    value: str

    @property
    def control(self) -> Hashable:
        return PictureChoice, self.field

    def apply(self, model: PageModel, now: float) -> None:
        changed: dict[str, Any] = {self.field: self.value}
        model.view = replace(model.view, **changed)


def choose_picture(value: object) -> PictureChoice:
    return PictureChoice("picture", choice(value, {name: name for name in PICTURES}, "picture"))


def choose_format(value: object) -> PictureChoice:
    return PictureChoice("picture_as", choice(value, {name: name for name in FORMATS}, "format"))


class SavePicture(Command):
    """Of the panel that is chosen."""

    def apply(self, model: PageModel, now: float) -> None:
        model.save_picture(now)
        model.say("drawing the picture, in colours of print and with its caption …", now + WRITES)
