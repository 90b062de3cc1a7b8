"""What links in the drawings ask for: the control in their address, and the command that its value stands for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from html import escape
from typing import ClassVar

import numpy as np

from viewimit.drawing.glossary import glossary

from ..checks import choice, number
from ..page_model import PageModel
from ..presets import Preset
from .command import Command, OfView
from .display import BuildUp, ChoosePoint, Enlarge, LeaveUndrawn, LetGo, PreferStill, Switch
from .links import FollowLink, ResendAll, Restore, TellUnsaved
from .points import BestNext, RemovePoint, SaveScene
from .session import Play, Scrub, StartAt


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
