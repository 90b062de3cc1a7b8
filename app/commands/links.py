"""Commands that make a page what a link holds, or what its own tab has kept."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar

from ..model.following import Played
from ..model.keeping import become
from ..model.page_model import PageModel
from ..model.queue import Command, Value
from ..sessions.link import decode


@dataclass(frozen=True)
class FollowLink(Value):
    """Become what a link holds. Its motions are computed beside the page, as that may take seconds."""

    text: str
    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.following.begin(decode(self.text, model.begun), Arrived)


@dataclass(frozen=True)
class Restore(Value):
    """Become what the tab has kept; an empty text of a new tab."""

    text: str

    def apply(self, model: PageModel, now: float) -> None:
        if model.is_kept:
            return
        model.is_kept = True
        if self.text:
            try:
                page = decode(self.text, model.begun)
            except ValueError as error:
                why = str(error).removeprefix("the link ")
                raise ValueError(f"what this tab has kept {why}, so the session begins again") from None
            model.following.begin(page, Arrived, is_own=True)


@dataclass(frozen=True, eq=False)
class Arrived(Command):
    """Take what was played."""

    played: Played
    moves: ClassVar[bool] = True
    cancels: ClassVar[bool] = True

    @property
    def control(self) -> Hashable:
        return Arrived

    def opens_pictures(self, model: PageModel) -> bool:
        return self.played.page.uses_pictures

    def apply(self, model: PageModel, now: float) -> None:
        if model.following.finish(self.played):
            become(model, self.played, now)


class ResendAll(Value):
    """The tab has missed a part of what it is to keep."""

    def apply(self, model: PageModel, now: float) -> None:
        model.resends_all = True


@dataclass(frozen=True)
class TellUnsaved(Value):
    """Why the browser cannot keep the session; empty where it can."""

    why: str

    def apply(self, model: PageModel, now: float) -> None:
        model.unsaved = self.why[:200] or None
