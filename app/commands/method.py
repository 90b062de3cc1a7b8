"""Commands that change settings: method, joints that move, disturbances, what the learner looks with."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar

from viewimit.estimation.transfers import TRANSFERS
from viewimit.servo import SERVOS

from ..model.choices import Amount, choice, joint_choices, named, number, switch, words
from ..model.page_model import PageModel
from ..model.queue import Value


@dataclass(frozen=True)
class Change(Value):
    """One field of `Settings`, whose range the session checks."""

    field: str
    value: str | int | float
    moves: ClassVar[bool] = True

    @property
    def control(self) -> Hashable:
        return Change, self.field

    def opens_pictures(self, model: PageModel) -> bool:
        return self.value == "rendered"

    def apply(self, model: PageModel, now: float) -> None:
        model.undoable.change(**{self.field: self.value})


def change_transfer(value: object) -> Change:
    return Change("transfer", named(value, TRANSFERS, "transfer"))


def change_servo(value: object) -> Change:
    return Change("servo", named(value, SERVOS, "servo"))


def change_disturbance(amount: Amount, value: object) -> Change:
    """value: in the units of the slider"""
    return Change(amount.name, amount.asked(value))


def change_seed(value: object) -> Change:
    return Change("seed", round(number(value)))


def switch_rectify(value: object) -> Change:
    return Change("rectify", "auto" if switch(value) else "off")


def switch_camera(value: object) -> Change:
    return Change("sensor", "rendered" if switch(value) else "projected")


@dataclass(frozen=True)
class FreeJoints(Value):
    """Let other joints move, by the name of the choice; which there are depends on the scene."""

    name: str
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: object) -> FreeJoints:
        return cls(words(value, "joints"))

    def apply(self, model: PageModel, now: float) -> None:
        """What the page has now may be meant by it, which changes nothing."""
        settings = model.session.settings
        joints = choice(self.name, joint_choices(settings), "joints")
        if joints != settings.joints:
            model.undoable.change(**model.freedom.fields(settings, model.session.scene, joints))
