"""What the lecturer's page wants of the class, and what it is told of it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from viewimit.script import Script

from ...classroom.classroom import NOBODY, Heard, Member, Rounds, Seen
from ...classroom.messages import (
    MOST_ROUNDS,
    STATES,
    Asked,
    Copy,
    Orders,
    Round,
    Sent,
    Shown,
    Summary,
    Tally,
    Wanted,
)
from ...lessons.format import Choice, Number, Place, Pose
from ...sessions.link import written
from ..queue import CommandQueue
from .tally import tally_of

SURE_FOR = 5.0  # s in which all are reset by a second click
SORTS: dict[str, Callable[[Summary], tuple]] = {
    "state": lambda one: (STATES.index(one.state), -(one.E or 0.0)),
    "E": lambda one: (-(np.inf if one.E is None else one.E),),
    "motions": lambda one: (-one.motions,),
}
CAN_BE_ASKED = Choice | Number | Place | Pose
replace = msgspec.structs.replace


@dataclass(frozen=True)
class ClassView:
    """What the lecturer's page shows of the class. leads: whether it is this page that gives orders; students: sorted;
    sure: whether a click resets all; told: whether answers are shown before they are revealed; tally: of the question
    that goes on; invites: whether the address is shown to all."""

    leads: bool
    present: bool
    orders: Orders
    students: tuple[Summary, ...]
    sort: str
    sure: bool
    told: bool
    tally: Tally | None
    problem: str | None
    invites: bool


class Lecturer:
    """A page of the lecturer's. save(rounds): all that was answered, once it was asked for."""

    def __init__(self, member: Member, queue: CommandQueue):
        self.member, self.queue = member, queue
        self.heard: Heard | None = None
        self.seen: Seen = NOBODY
        self.sort, self.told, self.invites = "state", False, False
        self._sure_until = -np.inf
        self._copied = 0
        self._shown: Shown | None = None
        self._of: tuple[Any, ...] = ()
        self._tally: Tally | None = None
        self._counted: tuple[Any, ...] = ()
        self._view: tuple[tuple[Any, ...], ClassView] | None = None
        member.take_over()

    @property
    def orders(self) -> Orders:
        return Orders() if self.heard is None else self.heard.orders

    @property
    def leads(self) -> bool:
        """Whether it is this page that gives the orders: the newest of the lecturer's."""
        return self.orders.leader == self.member.id

    @property
    def leading(self) -> bool:
        """Whether all follow this page."""
        return self.leads and self.orders.lead is not None

    def take(self, heard: Heard) -> None:
        self.heard = heard

    def see(self, seen: Seen) -> str | None:
        """What there is of all. → a link to a copy that was asked for. Raises ValueError for one that cannot be."""
        self.seen = seen
        if seen.copy is None or seen.copy[0] <= self._copied or not self.leads:
            return None
        self._copied, copy = seen.copy
        return _text_of(copy)

    # Orders

    def send(self, model: Any) -> None:
        """My state to all, once."""
        shown = shown_of(model)
        self._order(lambda orders: replace(orders, sent=Sent(number=_next(orders.sent), shown=shown)))

    def lead(self, model: Any) -> None:
        """All follow, until let go; once more: let go."""
        shown = None if self.leading else shown_of(model)
        self._shown = shown
        self._order(lambda orders: replace(orders, lead=shown))

    def freeze(self) -> None:
        """Their controls are locked; once more: no longer."""
        frozen = not self.orders.frozen
        self._order(lambda orders: replace(orders, frozen=frozen))

    def reset(self, now: float) -> None:
        """All, at the second click."""
        if now > self._sure_until:
            self._sure_until = now + SURE_FOR
            return
        self._sure_until = -np.inf
        self._order(lambda orders: replace(orders, reset=orders.reset + 1))

    def open(self, student: str) -> None:
        """A copy of a student's session, here."""
        self._copied = _next(self.orders.wanted) - 1
        self._order(lambda orders: replace(orders, wanted=Wanted(number=_next(orders.wanted), student=student)))

    def ask(self, model: Any) -> None:
        """The question of the step that is shown, to all; the one that goes on: once more."""
        course = model.guided.course
        step = None if course is None else course.step
        if step is None or not isinstance(step.ask, CAN_BE_ASKED):
            raise ValueError("this step asks nothing that a class could answer: a choice, number, place or posture")
        lesson, id = course.progress.lesson, step.id
        self.told, self._tally, self._counted = False, None, ()
        course.ask_anew()

        def asked(orders: Orders) -> Orders:
            asked = Round(number=max((one.number for one in orders.rounds), default=0) + 1, lesson=lesson, step=id)
            return replace(orders, asked=Asked(round=asked), rounds=(*orders.rounds[1 - MOST_ROUNDS :], asked))

        self._order(asked)

    def ask_again(self, model: Any) -> None:
        """The question that was asked last, after it was talked about."""
        asked = self._require_asked()
        model.guided.go_to_step(asked.round.lesson, asked.round.step)
        self.ask(model)

    def reveal(self, model: Any) -> None:
        """What is true, and what all have answered, to all."""
        asked = self._require_asked()
        model.guided.go_to_step(asked.round.lesson, asked.round.step)
        model.guided.course.reveal()
        self.told = True
        self._order(lambda orders: replace(orders, asked=orders.asked and replace(orders.asked, revealed=True)))

    def tell(self) -> None:
        """Show what was answered here, before it is revealed; once more: no longer."""
        self._require_asked()
        self.told = not self.told

    def close(self, model: Any) -> None:
        """The question is over: all go on where they were."""
        self._require_asked()
        self.told = False
        if model.guided.course is not None:
            model.guided.course.show_others(())
        self._order(lambda orders: replace(orders, asked=None))

    def save(self, done: Callable[[Rounds], None]) -> None:
        """All that was answered in this class, to be given to done() by another thread."""
        if not self.orders.rounds:
            raise ValueError("nothing was asked yet")
        self.member.collect(done)

    # What goes on by itself

    def follow(self, model: Any) -> None:
        """Let all follow what has changed here, and count what has come."""
        if self.leading:
            of = model.session.snapshot, model.view, model.player.speed, model.player.playing, _at(model)
            if len(of) != len(self._of) or any(a is not b and a != b for a, b in zip(of, self._of)):
                self._of = of
                shown = shown_of(model)
                if shown != self._shown:
                    self._shown = shown
                    self._order(lambda orders: replace(orders, lead=orders.lead and shown))
        self._count(model)

    def view(self, now: float) -> ClassView:
        sure = now <= self._sure_until
        of = self.heard, self.seen, self.sort, sure, self.told, self._tally, self.invites
        if self._view is None or any(a is not b and a != b for a, b in zip(of, self._view[0])):
            students = tuple(sorted(self.seen.students, key=lambda one: (*SORTS[self.sort](one), one.id)))
            present, shown = self.heard is not None, (self.sort, sure, self.told, self._tally)
            view = ClassView(self.leads, present, self.orders, students, *shown, self.seen.problem, self.invites)
            self._view = of, view
        return self._view[1]

    def _count(self, model: Any) -> None:
        """What was answered, as long as this page stands at the question."""
        asked, course = self.orders.asked, model.guided.course
        step = None if course is None else course.step
        if asked is None or step is None or (course.progress.lesson, step.id) != (asked.round.lesson, asked.round.step):
            return
        of = self.seen.answers, self.seen.earlier, asked.round, asked.revealed, self.told, len(course.made)
        if len(self._counted) == len(of) and all(a is b or a == b for a, b in zip(of, self._counted)):
            return
        self._counted = of
        self._tally = tally_of(course.stage, self.seen.answers, self.seen.earlier)
        course.show_others(self._tally.places if self.told else ())
        if asked.revealed and self.leads and asked.tally != self._tally:
            tally = self._tally
            self._order(lambda orders: replace(orders, asked=orders.asked and replace(orders.asked, tally=tally)))

    def _require_asked(self) -> Asked:
        if self.orders.asked is None:
            raise ValueError("nothing is asked now")
        return self.orders.asked

    def _order(self, change: Callable[[Orders], Orders]) -> None:
        if not self.leads:
            raise ValueError("another of the lecturer's pages leads now; Take over brings that here")
        self.member.order(change)


def shown_of(model: Any) -> Shown:
    """What a page shows, for others; where too much was done to be said, what it shows from now on."""
    at = _at(model)
    if at is not None:
        return Shown(lesson=at)
    playing = model.player.playing and not all(runner.resting for runner in model.player.runners)
    linked = model.linked()
    try:
        text = written(linked)
    except ValueError:
        text = written(replace(linked, script=_from_here(model)))
        return Shown(text=text, playing=playing)
    return Shown(text=text, motion=model.session.cursor, playing=playing)


def _from_here(model: Any) -> Script:
    present = model.session.snapshot
    start, demo = (tuple(np.degrees(theta).tolist()) for theta in (present.theta, present.theta_demo))
    return Script(replace(model.session.settings, start_deg=start, demonstrator_deg=demo))


def _at(model: Any) -> tuple[str, int] | None:
    """Lesson and screen."""
    course = model.guided.course
    return None if course is None else (course.progress.lesson, course.progress.at)


def _next(before: Sent | Wanted | None) -> int:
    return 1 if before is None else before.number + 1


def _text_of(copy: Copy) -> str:
    if not copy.text:
        raise ValueError(f"this session cannot be copied: {copy.why or 'its page says nothing'}")
    return copy.text
