"""Commands to the experiments and to the demonstrator's motions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from viewimit.experiments import EXPERIMENTS

from ..checks import choice, named, number
from ..motions import MOST_BYTES, NAMES
from ..page_model import PageModel
from .command import Command, Value


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
