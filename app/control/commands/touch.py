"""What links in the drawings ask for: the control in their address, and the command that its value stands for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from ..checks import number
from ..page_model import PageModel
from .command import Command
from .display import ChoosePoint, PreferDark


@dataclass(frozen=True)
class TogglePoint(Command):
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


TOUCHES: Mapping[str, Callable[[str], Command]] = {
    "dark": PreferDark.parse,
    "point": TogglePoint.parse,
}
