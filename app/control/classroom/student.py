"""What a student's page does about the lecturer's orders."""

from dataclasses import dataclass
from typing import Any

from ...classroom.member import Heard, Member
from ...classroom.messages import Answer, Asked, Copy, Round, Shown, Summary, call_of
from ...sessions.link import written
from ..commands.links import show_view_of
from ..history.past import Left
from ..page_model import PageModel
from ..queue import CommandQueue
from .following import linked_of, only_steps, rest
from .role import Role
from .summaries import answer_of, summary_of

WHOLE_EVERY = 1.0  # s at least between two states that are followed from their beginning
LEADS = "The lecturer leads: this page follows until they let go."
FREEZES = "The lecturer has frozen the controls."
ASKS = "The lecturer has asked a question: this page waits for it to be closed."


@dataclass(frozen=True)
class Follow:
    """text: a link that is to be followed from its beginning; keep: Undo brings back what was there before."""

    text: str
    keep: bool


class Student(Role):
    """heard: what the lecturer wants; name: as typed. Of what was wanted before the page came, it does what goes on."""

    def __init__(self, member: Member, queue: CommandQueue):
        self.member, self.queue = member, queue
        self.name: str = ""
        self.heard: Heard | None = None
        self._done = 0, 0, 0  # numbers of what was wanted once: reset, sent, a copy
        self._asked: Round | None = None
        self._answer: Answer | None = None
        self._looked: tuple[Any, ...] = ()
        self._followed: str | None = None  # link from the beginning of which this page has followed
        self._at = -WHOLE_EVERY
        self._own: Left | None = None

    # What goes up

    def tell(self, model: PageModel) -> None:
        """To be called once a second at most."""
        self.member.tell(summary_of(model, self.member.id, self.name))
        course = model.guided.course
        if self._asked is not None and model.guided.asked and course is not None and not course.given.revealed:
            answer = answer_of(course)
            if answer is not None and answer != self._answer:
                self._answer = answer
                self.member.reply(call_of(self._asked), answer)

    @property
    def summary(self) -> Summary | None:
        return self.member.summary

    # What comes down

    @property
    def holds(self) -> str | None:
        if self.heard is None or not self.heard.present:
            return None
        if self._asked is not None:
            return ASKS
        return LEADS if self.heard.leads else FREEZES if self.heard.freezes else None

    @property
    def follows(self) -> bool:
        return self.heard is not None and self.heard.leads and self._asked is None

    @property
    def moves_along(self) -> bool:
        lead = None if self.heard is None else self.heard.orders.lead
        return self.follows and lead is not None and lead.playing

    @property
    def asked(self) -> Asked | None:
        return None if self.heard is None else self.heard.asked

    @property
    def own(self) -> Left | None:
        return self._own

    def call(self, name: str) -> None:
        self.name = name

    def take(self, model: PageModel, heard: Heard) -> Follow | None:
        """New orders. → a link that is to be followed."""
        before, self.heard, orders = self.heard, heard, heard.orders
        sent = 0 if orders.sent is None else orders.sent.number
        wanted = 0 if orders.wanted is None else orders.wanted.number
        done, self._done = self._done, (orders.reset, sent, wanted)
        follow = None
        if before is not None and not heard.first:
            if orders.reset > done[0]:
                model.guided.leave()
                model.undoable.reset()
            if orders.wanted is not None and wanted > done[2] and orders.wanted.student == self.member.id:
                self.member.reply(call_of(orders.wanted), _copy(model))
            if orders.sent is not None and sent > done[1]:
                follow = self._show(model, orders.sent.shown)
        led = before is not None and before.leads
        if heard.leads and not led:
            model.player.pause()
            self._own, self._looked, self._followed = model.past.present, (), None
        elif led and not heard.leads and self._own is not None:
            model.past.leave_here(self._own)
            self._own = None
        self._take_question(model, heard.asked)
        return follow

    def due(self, model: PageModel) -> bool:
        """Whether this page has to follow on: something has changed here or there."""
        if not self.follows or self.heard is None:
            return False
        looked = self.heard.orders.lead, model.session.snapshot, model.guided.course
        return not self._looked or any(a is not b for a, b in zip(looked, self._looked))

    def follow(self, model: PageModel, now: float) -> Follow | None:
        """Do what the lecturer's session did since. → a link, if it has to be followed from its beginning. Raises
        ValueError for what cannot be."""
        lead = None if self.heard is None else self.heard.orders.lead
        if lead is None or not self.follows:
            return None
        there = self._goes_on(model, lead, now)
        self._looked = lead, model.session.snapshot, model.guided.course
        if there or lead.text == self._followed:  # what led elsewhere once, will do so again
            return None
        if now - self._at < WHOLE_EVERY:
            self._looked = ()
            return None
        self._followed, self._at = lead.text, now
        return Follow(lead.text, False)

    def _goes_on(self, model: PageModel, lead: Shown, now: float) -> bool:
        """From what this page has done itself; False where that is not the way."""
        if lead.lesson is not None:
            model.guided.go_to(*lead.lesson)
            return True
        if model.guided.course is not None:
            model.guided.leave()
        linked = linked_of(lead.text, model.begun)
        try:
            done = model.session.script
        except ValueError:
            return False
        onwards, back = rest(done, linked.script), rest(linked.script, done)
        if onwards is not None:
            for action in onwards:
                model.undoable.do_along(action, linked.speed, now)
        elif back is not None and only_steps(back):
            model.player.scrub(lead.motion, now)
        if rest(model.session.script, linked.script) != ():
            return False
        show_view_of(model, linked)
        return True

    def _show(self, model: PageModel, shown: Shown) -> Follow | None:
        if shown.lesson is None:
            return Follow(shown.text, True)
        model.guided.go_to(*shown.lesson)
        return None

    def _take_question(self, model: PageModel, asked: Asked | None) -> None:
        if asked is None:
            if self._asked is not None:
                model.guided.end_question()
            self._asked = None
            return
        if asked.round != self._asked:
            self._asked, self._answer = asked.round, None
            model.guided.ask(asked.round.lesson, asked.round.step)
        course = model.guided.course
        if asked.revealed and model.guided.asked and course is not None:
            course.reveal(() if asked.tally is None else asked.tally.places)


def _copy(model: PageModel) -> Copy:
    try:
        return Copy(text=written(model.linked()))
    except ValueError as error:
        return Copy(why=str(error)[:200])
