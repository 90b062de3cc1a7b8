"""Commands that hand the visitor files: a replay, pictures."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

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
class ChoosePicture(Value):
    """Which panel is saved."""

    what: str

    @classmethod
    def parse(cls, value: object) -> ChoosePicture:
        return cls(choice(value, {name: name for name in PICTURES}, "picture"))

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, picture=self.what)


@dataclass(frozen=True)
class ChooseFormat(Value):
    form: str

    @classmethod
    def parse(cls, value: object) -> ChooseFormat:
        return cls(choice(value, {name: name for name in FORMATS}, "format"))

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, picture_as=self.form)


class SavePicture(Command):
    """Of the panel that is chosen, or of a lesson's figures."""

    in_lesson: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.save_picture(now)
        model.say("drawing the picture, in colours of print and with its caption …", now + WRITES)
