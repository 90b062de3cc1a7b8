"""Commands to what the page shows of a session: they change nothing of it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, replace
from html import escape
from typing import Any, ClassVar

import numpy as np

from viewimit.drawing.glossary import glossary

from ..model.choices import NO_POINT, choice, number, switch
from ..model.page_model import PageModel
from ..model.presets import Preset
from ..model.queue import Command, OfView, Value
from ..model.state import LARGE
from .links import FollowLink, ResendAll, Restore, TellUnsaved
from .session import Play, Scrub, StartAt
from .tools import BestNext, RemovePoint, SaveScene


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


# What links in the drawings ask for: the control in their address, and the command that its value stands for.


@dataclass(frozen=True)
class TogglePoint(OfView):
    """Choose a point; the chosen one again: none."""

    point: int

    @classmethod
    def parse(cls, value: str) -> TogglePoint:
        return cls(round(number(value)))

    def apply(self, model: PageModel, now: float) -> None:
        if self.point == model.view.chosen:
            model.view = replace(model.view, chosen=None)
        else:
            ChoosePoint(self.point).apply(model, now)


@dataclass(frozen=True)
class TouchPosture(Command):
    """A place of the landscape: the learner starts there, or a see-through arm shows it. angles_deg: (m,)"""

    angles_deg: tuple[float, ...]
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: str) -> TouchPosture:
        return cls(tuple(map(number, value.split(","))))

    def apply(self, model: PageModel, now: float) -> None:
        if not model.view.look_only:
            StartAt(self.angles_deg).apply(model, now)
        else:
            model.player.pause()
            model.moments.see_through.look(np.radians(self.angles_deg))


class StartThere(Command):
    """Where the see-through arm is."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        moment = model.moments.see_through.moment
        if moment is None:
            raise ValueError("there is no see-through arm to start from")
        StartAt(tuple(np.degrees(moment.theta).tolist())).apply(model, now)


def _told(name: str) -> Callable[[str], Command]:
    """What a browser says of itself, by a picture that it chooses: see `told` among the panels."""
    return lambda value: Switch(name, choice(value, {"0": False, "1": True}, name))


@dataclass(frozen=True)
class ShowWord(Command):
    """Begin with the settings in which an entry of the glossary is seen; at once where that takes motions."""

    key: str
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: str) -> ShowWord:
        choice(value, glossary(), "entry of the glossary")
        return cls(value)

    def apply(self, model: PageModel, now: float) -> None:
        entry = glossary()[self.key]
        speed = 0.0 if entry.plays else model.player.speed
        lesson = f"{entry.symbol}, {entry.name}{': where it is bad' if entry.bad else ''}."
        preset = Preset(f"Show me: {entry.symbol}", entry.show, speed, escape(lesson))
        model.word.show(self.key, preset, model.view)
        model.view = replace(model.view, help=False)
        if entry.plays:
            Play().apply(model, now)


class GiveBack(Command):
    """What was there before an entry of the glossary was shown."""

    moves: ClassVar[bool] = True

    def opens_pictures(self, model: PageModel) -> bool:
        before = model.word.before
        return before is not None and before.left.sensor == "rendered" != model.session.settings.sensor

    def apply(self, model: PageModel, now: float) -> None:
        model.view = model.word.give_back(model.view)


TOUCHES: Mapping[str, Callable[[str], Command]] = {
    "dark": _told("prefers_dark"),
    "still": PreferStill.parse,
    "point": TogglePoint.parse,
    "layout": _told("wide"),
    "vast": _told("vast"),
    "truth": _told("truth"),
    "unseen": LeaveUndrawn.parse,
    "posture": TouchPosture.parse,
    "construction": lambda value: BuildUp(),
    "large": Enlarge.parse,
    "best": lambda value: BestNext(),
    "remove": lambda value: RemovePoint(),
    "scene": lambda value: SaveScene(),
    "start": lambda value: StartThere(),
    "dismiss": lambda value: LetGo(),
    "moment": Scrub.parse,
    "link": FollowLink,
    "session": Restore,
    "resend": lambda value: ResendAll(),
    "unsaved": TellUnsaved,
    "show": ShowWord.parse,
    "restore": lambda value: GiveBack(),
}
