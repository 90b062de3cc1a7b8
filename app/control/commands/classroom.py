"""Commands of a class: what the lecturer's page asks for, and what arrives at a page from the others."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from ...classroom.member import Heard, Rounds, Seen
from ..checks import words
from ..classroom.export import as_csv
from ..classroom.lecturer import SORTS, Lecturer
from ..classroom.student import Follow, Student
from ..classroom.summaries import name_of
from ..page_model import PageModel
from .command import Command, Value
from .links import FollowLink, follow_link


@dataclass(frozen=True)
class FollowShown(FollowLink):
    """What the lecturer shows, from its beginning. keep: Undo brings back what was there before."""

    keep: bool = True
    when_locked: ClassVar[bool] = True

    @property
    def control(self) -> Hashable:
        return FollowShown

    def apply(self, model: PageModel, now: float) -> None:
        follow_link(model, self.read(model), self.keep)


class FromLecturer(Value):
    """Whatever the page does, it follows."""

    moves: ClassVar[bool] = True
    in_lesson: ClassVar[bool] = True
    when_locked: ClassVar[bool] = True


class AboutClass(Command):
    """What changes nothing of the page's session, and is carried out in a lesson too."""

    in_lesson: ClassVar[bool] = True
    commutes: ClassVar[bool] = True


@dataclass(frozen=True, eq=False)
class TakeOrders(FromLecturer):
    """What the lecturer wants of the class now."""

    heard: Heard

    def apply(self, model: PageModel, now: float) -> None:
        role = model.role
        if isinstance(role, Lecturer):
            role.take(self.heard)
        elif isinstance(role, Student):
            _follow(role, role.take(model, self.heard))


class FollowOn(FromLecturer):
    """Do what the lecturer's session has done since."""

    def apply(self, model: PageModel, now: float) -> None:
        if isinstance(model.role, Student):
            _follow(model.role, model.role.follow(model, now))


@dataclass(frozen=True, eq=False)
class SeeClass(AboutClass, Value):
    """What there is of all, for the lecturer's page."""

    seen: Seen

    def apply(self, model: PageModel, now: float) -> None:
        lecturer = _lecturer(model)
        text = lecturer.see(self.seen)
        if text is not None:
            lecturer.queue.put(FollowLink(text))


@dataclass(frozen=True, eq=False)
class SaveAnswers(AboutClass):
    """All that was answered, as a file."""

    rounds: Rounds

    def apply(self, model: PageModel, now: float) -> None:
        model.send("viewimit-class.csv", as_csv(self.rounds, model.guided.lessons))


@dataclass(frozen=True)
class NameYourself(AboutClass, Value):
    """A student's name, for the lecturer to see; "" for none."""

    name: str
    when_locked: ClassVar[bool] = True

    @classmethod
    def parse(cls, value: object) -> NameYourself:
        return cls(name_of(words(value, "name")))

    def apply(self, model: PageModel, now: float) -> None:
        model.role.call(self.name)


@dataclass(frozen=True)
class OfClass(AboutClass):
    """What the lecturer does. verb: of VERBS; about: what it is about."""

    verb: str
    about: str = ""

    @classmethod
    def parse(cls, value: str) -> OfClass:
        verb, _, about = value.partition(",")
        if verb not in VERBS:
            raise ValueError(f"nothing in a class is {value[:40]!r}")
        return cls(verb, about)

    def apply(self, model: PageModel, now: float) -> None:
        VERBS[self.verb](_lecturer(model), model, now, self.about)


def _lecturer(model: PageModel) -> Lecturer:
    if not isinstance(model.role, Lecturer):
        raise ValueError("this page is not the lecturer's")
    return model.role


def _follow(student: Student, follow: Follow | None) -> None:
    if follow is not None:
        student.queue.put(FollowShown(follow.text, follow.keep))


def _sort(lecturer: Lecturer, model: PageModel, now: float, about: str) -> None:
    if about not in SORTS:
        raise ValueError(f"a class is sorted by {', '.join(SORTS)}")
    lecturer.sort = about


def _invite(lecturer: Lecturer, model: PageModel, now: float, about: str) -> None:
    """Show how students join, to be seen from the last row; once more: no longer."""
    lecturer.invites = not lecturer.invites


def _save(lecturer: Lecturer, model: PageModel, now: float, about: str) -> None:
    lecturer.save(lambda rounds: lecturer.queue.put(SaveAnswers(rounds)))


VERBS: Mapping[str, Callable[[Lecturer, PageModel, float, str], None]] = {
    "send": lambda lecturer, model, now, about: lecturer.send(model),
    "lead": lambda lecturer, model, now, about: lecturer.lead(model),
    "freeze": lambda lecturer, model, now, about: lecturer.freeze(),
    "reset": lambda lecturer, model, now, about: lecturer.reset(now),
    "open": lambda lecturer, model, now, about: lecturer.open(about),
    "sort": _sort,
    "invite": _invite,
    "take": lambda lecturer, model, now, about: lecturer.member.take_over(),
    "ask": lambda lecturer, model, now, about: lecturer.ask(model),
    "again": lambda lecturer, model, now, about: lecturer.ask_again(model),
    "tell": lambda lecturer, model, now, about: lecturer.tell(),
    "reveal": lambda lecturer, model, now, about: lecturer.reveal(model),
    "close": lambda lecturer, model, now, about: lecturer.close(model),
    "save": _save,
}
