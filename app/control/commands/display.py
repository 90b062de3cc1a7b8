"""Commands to what the page shows of a session: they change nothing of it."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import ClassVar

from ..checks import choice, number, switch
from ..names import NO_POINT
from ..page_model import PageModel
from .command import Command, Value


@dataclass(frozen=True)
class ChoosePoint(Value):
    """point: None for none"""

    point: int | None

    @classmethod
    def parse(cls, value: object) -> ChoosePoint:
        return cls(None if value == NO_POINT else round(number(value)))

    def apply(self, model: PageModel, now: float) -> None:
        count = len(model.session.world.body)
        if self.point is not None and not 0 <= self.point < count:
            raise ValueError(f"no point {self.point}; there are {count}")
        model.view = replace(model.view, chosen=self.point)


class NextPoint(Command):
    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        chosen, count = model.view.chosen, len(model.session.world.body)
        model.view = replace(model.view, chosen=0 if chosen is None else (chosen + 1) % count)


@dataclass(frozen=True)
class Switch(Value):
    """One of the switches of `View`."""

    name: str
    on: bool
    commutes: ClassVar[bool] = True

    @classmethod
    def parse(cls, name: str, value: object) -> Switch:
        return cls(name, switch(value))

    @property
    def control(self) -> Hashable:
        return Switch, self.name

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, **{self.name: self.on})


@dataclass(frozen=True)
class PreferDark(Command):
    """What the browser's colour scheme is, which holds until the visitor chooses another."""

    dark: bool
    commutes: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: str) -> PreferDark:
        return cls(choice(value, {"0": False, "1": True}, "colour scheme"))

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, prefers_dark=self.dark)


@dataclass(frozen=True)
class PreferStill(Command):
    """Whether the browser asks for less motion: arms are then seen where they arrive, not on their way."""

    still: bool
    commutes: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: str) -> PreferStill:
        return cls(choice(value, {"0": False, "1": True}, "preference"))

    def apply(self, model: PageModel, now: float) -> None:
        model.player.still = self.still


@dataclass(frozen=True)
class LayOut(Value):
    """For a window with room for more, or not. Browsers ask for it by themselves."""

    wide: bool
    commutes: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: str) -> LayOut:
        return cls(choice(value, {"0": False, "1": True}, "layout"))

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, wide=self.wide)


class LetGo(Command):
    """Of the help, or else of an imitation and the see-through arm."""

    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        if model.view.help:
            model.view = replace(model.view, help=False)
        else:
            model.imitated.stop()
            model.see_through.let_go()


class FitView(Command):
    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, fits=model.view.fits + 1)


class ToggleHelp(Command):
    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, help=not model.view.help)


class FromStarts(Command):
    """Find from where the learner arrives, or hide it."""

    def apply(self, model: PageModel, now: float) -> None:
        model.basins.toggle(model.session)


class ToggleComparison(Command):
    """The landscapes of all transfers, or of the one that is used."""

    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.comparison.toggle()
