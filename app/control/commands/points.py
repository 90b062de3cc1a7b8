"""Commands to the body points: edit them, place and remove one, take the best next, save the scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

from ..checks import choice, words
from ..page_model import PageModel
from ..points.layouts import layout_choices
from .command import Command, Value


@dataclass(frozen=True)
class ChooseLayout(Value):
    """By its name; which there are depends on the scene."""

    name: str
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: object) -> ChooseLayout:
        return cls(words(value, "layout"))

    def apply(self, model: PageModel, now: float) -> None:
        fields = choice(self.name, layout_choices(model.session.settings), "layout")
        if fields:
            model.undoable.change(**fields)


class EditPoints(Command):
    """Begin, or end; nothing moves meanwhile."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.points.toggle()
        if model.points.on:
            model.player.pause()
            model.moments.see_through.let_go()
            model.moments.imitated.stop()


@dataclass(frozen=True)
class PlacePoint(Command):
    """On both arms, and choose it. link: 0 = base; local: (3,) m in its frame."""

    link: int
    local: tuple[float, float, float]
    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.points.place(self.link, self.local)
        _choose_last(model)


class RemovePoint(Command):
    """The chosen one."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.points.remove(model.view.chosen)
        model.view = replace(model.view, chosen=None)


class BestNext(Command):
    """Propose the point that would tell most; or take the one that is proposed."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        if model.points.propose_or_take():
            _choose_last(model)


class SaveScene(Command):
    def apply(self, model: PageModel, now: float) -> None:
        model.points.save()


def _choose_last(model: PageModel) -> None:
    model.view = replace(model.view, chosen=len(model.session.world.body) - 1)
