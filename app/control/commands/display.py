"""Commands to what the page shows of a session: they change nothing of it."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from ..checks import choice, number, switch
from ..names import NO_POINT
from ..page_model import PageModel
from ..state import LARGE
from .command import Command, OfView, Value


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


class NextPoint(OfView):
    def apply(self, model: PageModel, now: float) -> None:
        chosen, count = model.view.chosen, len(model.session.world.body)
        model.view = replace(model.view, chosen=0 if chosen is None else (chosen + 1) % count)


@dataclass(frozen=True)
class Switch(OfView, Value):
    """One of the switches of `View`."""

    name: str
    on: bool

    @classmethod
    def parse(cls, name: str, value: object) -> Switch:
        return cls(name, switch(value))

    @property
    def control(self) -> Hashable:
        return Switch, self.name

    def apply(self, model: PageModel, now: float) -> None:
        changed: dict[str, Any] = {self.name: self.on}
        model.view = replace(model.view, **changed)


class ToggleGoal(OfView):
    """Draw the learner in L and R as it would look in the demonstrator's posture, or do so no longer."""

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, goal=not model.view.goal)


class BuildUp(OfView):
    """Show step by step how the chosen point is recovered; once more: all at once."""

    def apply(self, model: PageModel, now: float) -> None:
        if model.moments.building.goes_on:
            model.moments.building.end()
            return
        if model.view.chosen is None:
            NextPoint().apply(model, now)
        model.moments.building.begin(now)


@dataclass(frozen=True)
class Enlarge(OfView):
    """A panel or an image, by its name in LARGE; the one that is large already: all as before."""

    what: str

    @classmethod
    def parse(cls, value: str) -> Enlarge:
        return cls(choice(value, {str(k): what for k, what in enumerate(LARGE)}, "panel or image"))

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, large=None if model.view.large == self.what else self.what)


@dataclass(frozen=True)
class PreferStill(OfView):
    """Whether the browser asks for less motion: arms are then seen where they arrive, not on their way."""

    still: bool

    @classmethod
    def parse(cls, value: str) -> PreferStill:
        return cls(choice(value, {"0": False, "1": True}, "preference"))

    def apply(self, model: PageModel, now: float) -> None:
        model.player.still = self.still


@dataclass(frozen=True)
class LeaveUndrawn(OfView):
    """What the browser says that nobody sees: see `View.unseen`."""

    unseen: frozenset[str]

    @classmethod
    def parse(cls, value: str) -> LeaveUndrawn:
        return cls(frozenset() if value == "none" else frozenset(value.split(",")))

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, unseen=self.unseen)


class NextLarger(OfView):
    """The images large, then the figures, then all as before."""

    def apply(self, model: PageModel, now: float) -> None:
        after = {None: "images", "images": "figures"}
        model.view = replace(model.view, large=after.get(model.view.large))


class LetGo(OfView):
    """Close the help, or else a link that is followed, a proposed point or editing them, or else an imitation, the
    see-through arm, what is large and the offer of the tour."""

    def apply(self, model: PageModel, now: float) -> None:
        if model.view.help or model.view.share:
            model.view = replace(model.view, help=False, share=False)
        elif not model.following.let_go() and not model.points.let_go():
            model.tour_offered = False
            model.moments.imitated.stop()
            model.moments.see_through.let_go()
            model.view = replace(model.view, large=None)


class FitView(OfView):
    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, fits=model.view.fits + 1)


class ToggleShare(OfView):
    """The card with a link to what the page shows, and with the code that repeats it."""

    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, share=not model.view.share)


class ToggleHelp(OfView):
    def apply(self, model: PageModel, now: float) -> None:
        model.view = replace(model.view, help=not model.view.help)


class FromStarts(Command):
    """Find from where the learner arrives, or hide it; over the landscape of the transfer that is used."""

    def apply(self, model: PageModel, now: float) -> None:
        hidden = model.comparison.on
        if hidden:
            model.comparison.toggle()
        if not hidden or model.basins.run is None:
            model.basins.toggle(model.session)


class ToggleComparison(Command):
    """The landscapes of all transfers, or of the one that is used."""

    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.comparison.toggle()
