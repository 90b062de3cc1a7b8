"""What links in the drawings ask for: the control in their address, and the command that its value stands for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from ..checks import choice, number
from ..page_model import PageModel
from .command import Command
from .display import BuildUp, ChoosePoint, Enlarge, LetGo, Switch
from .session import Scrub, StartAt


@dataclass(frozen=True)
class TogglePoint(Command):
    """Choose a point; the chosen one again: none."""

    point: int
    commutes: ClassVar[bool] = True

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
            model.see_through.look(np.radians(self.angles_deg))


class StartThere(Command):
    """Where the see-through arm is."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        moment = model.see_through.moment
        if moment is None:
            raise ValueError("there is no see-through arm to start from")
        StartAt(tuple(np.degrees(moment.theta).tolist())).apply(model, now)


def _told(name: str) -> Callable[[str], Command]:
    """What a browser says of itself, by a picture that it chooses: see `told` among the panels."""
    return lambda value: Switch(name, choice(value, {"0": False, "1": True}, name))


TOUCHES: Mapping[str, Callable[[str], Command]] = {
    "dark": _told("prefers_dark"),
    "point": TogglePoint.parse,
    "layout": _told("wide"),
    "posture": TouchPosture.parse,
    "construction": lambda value: BuildUp(),
    "large": Enlarge.parse,
    "start": lambda value: StartThere(),
    "dismiss": lambda value: LetGo(),
    "moment": Scrub.parse,
}
