"""What the lecturer's page wants of the class, and what it is told of it."""

from collections.abc import Callable
from typing import Any

import msgspec
import numpy as np

from ...classroom.member import NOBODY, Heard, Member, Rounds, Seen
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
    Wanted,
)
from ...lessons.format import Choice, Number, Place, Pose
from ..page_model import PageModel
from ..queue import CommandQueue
from .answer_count import AnswerCount
from .class_view import ClassView
from .role import Role
from .shown import shown_of

SURE_FOR = 5.0  # s in which all are reset by a second click
SORTS: dict[str, Callable[[Summary], tuple]] = {
    "state": lambda one: (STATES.index(one.state), -(one.E or 0.0)),
    "E": lambda one: (-(np.inf if one.E is None else one.E),),
    "motions": lambda one: (-one.motions,),
}
CAN_BE_ASKED = Choice | Number | Place | Pose
replace = msgspec.structs.replace


class Lecturer(Role):
    """A page of the lecturer's. save(rounds): all that was answered, once it was asked for."""

    def __init__(self, member: Member, queue: CommandQueue):
        self.member, self.queue = member, queue
        self.heard: Heard | None = None
        self.seen: Seen = NOBODY
        self.sort, self.answers, self.invites = "state", AnswerCount(), False
        self._sure_until = -np.inf
        self._copied = 0
        self._shown: Shown | None = None
        self._of: tuple[Any, ...] = ()
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

    def send(self, model: PageModel) -> None:
        """My state to all, once."""
        shown = shown_of(model)
        self._order(lambda orders: replace(orders, sent=Sent(number=_next(orders.sent), shown=shown)))

    def lead(self, model: PageModel) -> None:
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

    def ask(self, model: PageModel) -> None:
        """The question of the step that is shown, to all; the one that goes on: once more."""
        course = model.guided.course
        step = None if course is None else course.step
        if course is None or step is None or not isinstance(step.ask, CAN_BE_ASKED):
            raise ValueError("this step asks nothing that a class could answer: a choice, number, place or posture")
        lesson, id = course.progress.lesson, step.id
        self.answers.begin()
        course.ask_anew()

        def asked(orders: Orders) -> Orders:
            asked = Round(number=max((one.number for one in orders.rounds), default=0) + 1, lesson=lesson, step=id)
            return replace(orders, asked=Asked(round=asked), rounds=(*orders.rounds[1 - MOST_ROUNDS :], asked))

        self._order(asked)

    def ask_again(self, model: PageModel) -> None:
        """The question that was asked last, after it was talked about."""
        asked = self._require_asked()
        model.guided.go_to_step(asked.round.lesson, asked.round.step)
        self.ask(model)

    def reveal(self, model: PageModel) -> None:
        """What is true, and what all have answered, to all."""
        asked = self._require_asked()
        model.guided.go_to_step(asked.round.lesson, asked.round.step)
        if model.guided.course is not None:
            model.guided.course.reveal()
        self.answers.told = True
        self._order(lambda orders: replace(orders, asked=orders.asked and replace(orders.asked, revealed=True)))

    def tell(self) -> None:
        """Show what was answered here, before it is revealed; once more: no longer."""
        self._require_asked()
        self.answers.told = not self.answers.told

    def close(self, model: PageModel) -> None:
        """The question is over: all go on where they were."""
        self._require_asked()
        self.answers.told = False
        if model.guided.course is not None:
            model.guided.course.show_others(())
        self._order(lambda orders: replace(orders, asked=None))

    def save(self, done: Callable[[Rounds], None]) -> None:
        """All that was answered in this class, to be given to done() by another thread."""
        if not self.orders.rounds:
            raise ValueError("nothing was asked yet")
        self.member.collect(done)

    # What goes on by itself

    def follow(self, model: PageModel) -> None:
        """Let all follow what has changed here, and count what has come."""
        if self.leading:
            of = model.session.snapshot, model.view, model.player.speed, model.player.playing, model.guided.place
            if len(of) != len(self._of) or any(a is not b and a != b for a, b in zip(of, self._of)):
                self._of = of
                shown = shown_of(model)
                if shown != self._shown:
                    self._shown = shown
                    self._order(lambda orders: replace(orders, lead=orders.lead and shown))
        self._count(model)

    def view(self, now: float) -> ClassView:
        sure = now <= self._sure_until
        told, tally = self.answers.told, self.answers.tally
        of = self.heard, self.seen, self.sort, sure, told, tally, self.invites
        if self._view is None or any(a is not b and a != b for a, b in zip(of, self._view[0])):
            students = tuple(sorted(self.seen.students, key=lambda one: (*SORTS[self.sort](one), one.id)))
            present, shown = self.heard is not None, (self.sort, sure, told, tally)
            view = ClassView(self.leads, present, self.orders, students, *shown, self.seen.problem, self.invites)
            self._view = of, view
        return self._view[1]

    def _count(self, model: PageModel) -> None:
        """What was answered; all see it as soon as it is revealed."""
        asked = self.orders.asked
        if not self.answers.count(self.seen, asked, model.guided.course) or asked is None:
            return
        tally = self.answers.tally
        if asked.revealed and self.leads and asked.tally != tally:
            self._order(lambda orders: replace(orders, asked=orders.asked and replace(orders.asked, tally=tally)))

    def _require_asked(self) -> Asked:
        if self.orders.asked is None:
            raise ValueError("nothing is asked now")
        return self.orders.asked

    def _order(self, change: Callable[[Orders], Orders]) -> None:
        if not self.leads:
            raise ValueError("another of the lecturer's pages leads now; Take over brings that here")
        self.member.order(change)


def _next(before: Sent | Wanted | None) -> int:
    return 1 if before is None else before.number + 1


def _text_of(copy: Copy) -> str:
    if not copy.text:
        raise ValueError(f"this session cannot be copied: {copy.why or 'its page says nothing'}")
    return copy.text
