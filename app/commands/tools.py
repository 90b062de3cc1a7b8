"""Commands to the duel."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from viewimit.estimation.transfers import TRANSFERS
from viewimit.experiments import EXPERIMENTS
from viewimit.servo import SERVOS

from ..model.choices import choice, named, number, words
from ..model.motions import MOST_BYTES, NAMES
from ..model.page_model import PageModel
from ..model.points import layout_choices
from ..model.queue import Command, Value
from ..model.saving import FORMATS, PICTURES


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


# Commands to the experiments and to the demonstrator's motions.


@dataclass(frozen=True)
class ChooseExperiment(Value):
    name: str

    @classmethod
    def parse(cls, value: object) -> ChooseExperiment:
        return cls(named(value, EXPERIMENTS, "experiment"))

    def apply(self, model: PageModel, now: float) -> None:
        model.experiments.chosen = self.name


class RunOrCancel(Command):
    def apply(self, model: PageModel, now: float) -> None:
        model.experiments.run_or_cancel()


class Download(Command):
    def apply(self, model: PageModel, now: float) -> None:
        model.experiments.download()


class ShowImitation(Command):
    """See what was imitated, or see it no more."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        run = model.experiments.shown
        if model.moments.imitated.playing:
            model.moments.imitated.stop()
        elif run is None or run.imitation is None:
            raise ValueError("there is no imitation to be seen before the experiment is done")
        else:
            model.player.pause()
            model.moments.imitated.play(run.imitation, now)


@dataclass(frozen=True)
class ChooseMotion(Value):
    name: str
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: object) -> ChooseMotion:
        return cls(choice(value, {title: name for name, title in NAMES.items()}, "motion"))

    def apply(self, model: PageModel, now: float) -> None:
        model.motions.choose(self.name)


class Record(Command):
    """Begin to record the demonstrator, or end it."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.motions.record()


class Replay(Command):
    """Play the chosen motion on, or stop."""

    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.motions.replay()


@dataclass(frozen=True)
class ShowMoment(Value):
    """A moment of the chosen motion."""

    seconds: float
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: object) -> ShowMoment:
        return cls(number(value))

    def apply(self, model: PageModel, now: float) -> None:
        model.motions.scrub(self.seconds)


class SaveMotion(Command):
    moves: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.motions.save()


@dataclass(frozen=True)
class LoadMotion(Value):
    """data: what a file holds, or its size if that is too large."""

    data: bytes | int
    moves: ClassVar[bool] = True

    @classmethod
    def parse(cls, data: bytes) -> LoadMotion:
        return cls(data if len(data) <= MOST_BYTES else len(data))

    def apply(self, model: PageModel, now: float) -> None:
        model.motions.load(self.data)


# Commands to the body points: edit them, place and remove one, take the best next, save the scene.


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


# Commands that hand the visitor files: a replay, pictures.

WRITES = 6.0  # s that it is said


class SaveReplay(Command):
    """The session as one page that needs no server."""

    commutes: ClassVar[bool] = True

    def apply(self, model: PageModel, now: float) -> None:
        model.saving.replay(model.session, model.view.chosen)
        model.say("writing the replay: one file that opens anywhere, without a server …", now + WRITES)


@dataclass(frozen=True)
class PictureChoice(Value):
    """Which panel is saved, or in which format: a field of `View`, and what it becomes."""

    field: str
    value: str

    @property
    def control(self) -> Hashable:
        return PictureChoice, self.field

    def apply(self, model: PageModel, now: float) -> None:
        changed: dict[str, Any] = {self.field: self.value}
        model.view = replace(model.view, **changed)


def choose_picture(value: object) -> PictureChoice:
    return PictureChoice("picture", choice(value, {name: name for name in PICTURES}, "picture"))


def choose_format(value: object) -> PictureChoice:
    return PictureChoice("picture_as", choice(value, {name: name for name in FORMATS}, "format"))


class SavePicture(Command):
    """Of the panel that is chosen."""

    def apply(self, model: PageModel, now: float) -> None:
        model.save_picture(now)
        model.say("drawing the picture, in colours of print and with its caption …", now + WRITES)
