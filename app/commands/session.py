"""Commands to the session: play, step, go back, move the demonstrator, begin with a preset, come back."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from viewimit.drawing.svg import count_motions
from viewimit.loop.settings import given
from viewimit.simulation.world import pose_for_hand

from ..model.choices import SPEEDS, choice, modified, number, words
from ..model.displayed import rehearsal_of
from ..model.page_model import PageModel
from ..model.queue import Command, Value

BACK_STAYS = 6.0  # s that it is said


class Play(Command):
    """Play or pause, which need not wait. A duel's opponent gets what has changed for the learner before both go on."""

    moves: ClassVar[bool] = True
    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        if not model.player.playing:
            model.past.keep_branch()
            model.duel.follow()
        model.player.toggle()


class Step(Command):
    """One motion."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.player.pause()
        model.past.keep_branch()
        model.duel.follow()
        model.player.step(now)


class Undo(Command):
    """One motion back; where a reset, a preset, a start or other motions began, to what they took the place of. A
    link that is still followed is let go."""

    moves: ClassVar[bool] = True
    cancels: ClassVar[bool] = True

    def opens_pictures(self, model: PageModel) -> bool:
        left = model.past.here
        return left is not None and left.sensor == "rendered" != model.session.settings.sensor

    def apply(self, model: PageModel, now: float) -> None:
        if model.following.let_go():
            return
        model.player.pause()
        left = model.past.here
        if left is None:
            model.player.undo(now)
        else:
            model.undoable.bring_back(left)
            points = f", {len(model.session.world.body)} points" if model.points.on else ""
            what = f"{left.preset.name}, {count_motions(left.motions)}{points}"
            model.say(f"Back is what was here before: {what}.", now + BACK_STAYS)


class Reset(Command):
    """Back to the start; an error that the page has met is over."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.undoable.reset()
        model.message = None


class ToggleRehearsal(Command):
    """The learner watches itself first; or it forgets what it has seen of itself."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        if rehearsal_of(model.session).held:
            model.undoable.forget_rehearsal()
        else:
            model.undoable.rehearse()


@dataclass(frozen=True)
class Scrub(Value):
    """To the moment after so many motions."""

    motion: int
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: object) -> Scrub:
        return cls(round(number(value)))

    def apply(self, model: PageModel, now: float) -> None:
        model.player.pause()
        model.player.scrub(self.motion)


@dataclass(frozen=True)
class ChooseSpeed(Value):
    """motions_per_second: 0 as fast as it computes."""

    motions_per_second: float

    @classmethod
    def parse(cls, value: object) -> ChooseSpeed:
        return cls(choice(value, SPEEDS, "speed"))

    def apply(self, model: PageModel, now: float) -> None:
        model.player.speed = self.motions_per_second


@dataclass(frozen=True)
class ChoosePreset(Value):
    """By its name; which there are differs from page to page."""

    name: str
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: object) -> ChoosePreset:
        return cls(words(value, "preset"))

    def opens_pictures(self, model: PageModel) -> bool:
        return self.name in model.presets.offered and model.presets.offered[self.name].settings.sensor == "rendered"

    def apply(self, model: PageModel, now: float) -> None:
        if self.name != modified(model.preset.name):  # which it is already
            offered = {**model.presets.offered, model.preset.name: model.preset}
            model.undoable.begin_preset(choice(self.name, offered, "preset"))


@dataclass(frozen=True)
class PoseJoint(Value):
    """One of the demonstrator's joints, counted among those that move, to an angle in rad."""

    k: int
    angle: float
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, k: int, value: object) -> PoseJoint:
        """value: degrees"""
        return cls(k, float(np.radians(number(value))))

    @property
    def control(self) -> Hashable:
        return PoseJoint, self.k

    def apply(self, model: PageModel, now: float) -> None:
        theta = model.session.snapshot.theta_demo.copy()
        if self.k < len(theta):  # a slider of the scene before may still have sent
            theta[self.k] = self.angle
            model.undoable.pose(theta)


@dataclass(frozen=True)
class StartAt(Command):
    """The learner begins anew there. angles_deg: (m,)"""

    angles_deg: tuple[float, ...]
    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.undoable.start_at(self.angles_deg)


@dataclass(frozen=True)
class StartJoint(Value):
    """One joint of the learner's start, counted among those that move; degrees."""

    k: int
    angle_deg: float
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, k: int, value: object) -> StartJoint:
        return cls(k, number(value))

    @property
    def control(self) -> Hashable:
        return StartJoint, self.k

    def apply(self, model: PageModel, now: float) -> None:
        start = list(given(model.session.settings.start_deg))
        if self.k < len(start):  # a slider of the scene before may still have sent
            start[self.k] = self.angle_deg
            model.undoable.start_at(tuple(start))


@dataclass(frozen=True, eq=False)
class PoseHand(Value):
    """The demonstrator's hand to a place, (3,) m in the world, as near as its joints can bring it."""

    position: NDArray
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: object) -> PoseHand:
        return cls(np.array(value, float))

    def apply(self, model: PageModel, now: float) -> None:
        model.undoable.pose(pose_for_hand(model.session.world, self.position, model.session.snapshot.theta_demo))
