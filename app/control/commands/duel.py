"""Commands to the duel."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar

from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

from ..checks import named
from ..page_model import PageModel
from .command import Command, Value


class ToggleDuel(Command):
    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.duel.toggle()


@dataclass(frozen=True)
class ChooseOpponent(Value):
    """part: "transfer" or "servo"; name: of the opponent's."""

    part: str
    name: str
    moves: ClassVar[bool] = True

    @property
    def control(self) -> Hashable:
        return ChooseOpponent, self.part

    @classmethod
    def transfer(cls, value: object) -> ChooseOpponent:
        return cls("transfer", named(value, TRANSFERS, "transfer"))

    @classmethod
    def servo(cls, value: object) -> ChooseOpponent:
        return cls("servo", named(value, SERVOS, "servo"))

    def apply(self, model: PageModel, now: float) -> None:
        model.duel.choose(**{self.part: self.name})
