"""What a visitor wished for, and the motions that are due, carried out turn by turn: at once, or beside the scheduler.

What looks with pictures takes long, and would hold up everybody's pages.
"""

from collections.abc import Callable, Container

from viewimit.session import Session

from ..jobs.camera_images import CameraLost
from ..jobs.session_eyes import RemoteEyes
from ..panels.laboratory import Laboratory
from .inbox import Inbox
from .player import Pace
from .shedding import Load
from .turns import Turns
from .visitor import Visitor

BESIDE = 0.2  # s a turn beside the scheduler for motions as fast as it computes


class Wishes:
    """tick(now) ends a turn, begins the next, or does meanwhile what need not wait.

    duel_wishes: names of those that move or look; refuse(why, now): a wish cannot be; forgive(): a fault is over;
    announce_pictures(now): the first pictures are about to be waited for.
    """

    def __init__(
        self,
        inbox: Inbox,
        session: Session,
        pace: Pace,
        turns: Turns,
        load: Load,
        visitor: Visitor,
        duel_wishes: Container[str],
        laboratory: Laboratory,
        refuse: Callable[[str, float], None],
        forgive: Callable[[], None],
        announce_pictures: Callable[[float], None],
    ):
        self._inbox, self._session, self._pace, self._turns, self._load = inbox, session, pace, turns, load
        self._visitor, self._duel_wishes, self._laboratory = visitor, duel_wishes, laboratory
        self._refuse, self._forgive, self._announce_pictures = refuse, forgive, announce_pictures
        self._asked_at = 0.0

    def tick(self, now: float) -> None:
        self._end_turn(now)
        if self._turns.busy:
            self._act_meanwhile(now)
        else:
            self._take_turn(now)

    def _take_turn(self, now: float) -> None:
        """Carry out what the visitor did and make the motions that are due: beside the scheduler if that takes
        pictures, at once if not."""
        wishes = self._wishes(now)
        opens = any(self._takes_pictures(*wish[1:3]) for wish in wishes)
        if not opens and self._session.settings.camera == "points":
            self._carry_out(wishes, now, self._load.step_budget)
            return
        for wish in wishes:
            if not self._moves(wish[1]):
                self._allow(now, *wish)
        moving = [wish for wish in wishes if self._moves(wish[1])]
        self._asked_at = now
        if opens:
            self._announce_pictures(now)
        if moving or self._laboratory.poses:
            self._turns.begin(lambda: self._carry_out(moving, now), alone=True)
            return
        self._laboratory.tick()
        if self._pace.due(now):
            self._turns.begin(lambda: self._pace.advance(now, lambda: BESIDE), alone=False)

    def _carry_out(self, wishes: list[tuple], now: float, budget: Callable[[], float] = lambda: 0.0) -> None:
        for wish in wishes:
            self._allow(now, *wish)
        self._laboratory.tick()
        self._pace.advance(now, budget)
        if isinstance(self._session.eyes, RemoteEyes):
            self._session.eyes.retake(self._session.snapshot)

    def _act_meanwhile(self, now: float) -> None:
        """What need not wait for the turn that goes on."""
        if self._turns.alone:
            return
        for carry_out, what, *value in self._wishes(now, lambda name: name == "play" or not self._moves(name)):
            if what == "play":
                self._pace.toggle()
            else:
                self._allow(now, carry_out, what, *value)

    def _end_turn(self, now: float) -> None:
        try:
            if self._turns.end():
                self._pace.seen_from(now, self._asked_at)
        except CameraLost as lost:
            self._visitor.leave_pictures()
            self._refuse(f"{lost}: back to projected points.", now)

    def _wishes(self, now: float, wanted: Callable[[str], bool] = lambda name: True) -> list[tuple]:
        """What carries it out, its name, and its arguments."""
        values, actions = self._inbox.take(wanted)
        return [(self._visitor.set, *item) for item in values.items()] + [
            (self._visitor.act, action, now) for action in actions
        ]

    def _moves(self, name: str) -> bool:
        return (
            name == "resume" or self._visitor.moves(name) or name in self._duel_wishes or self._laboratory.moves(name)
        )

    def _takes_pictures(self, name: str, value) -> bool:
        return name == "resume" or self._visitor.takes_pictures(name, value)

    def _allow(self, now: float, carry_out: Callable, what: str, *value) -> None:
        """Carry out one wish of the visitor; one that cannot be is said, and the others go on."""
        try:
            carry_out(what, *value)
            if what == "reset":
                self._forgive()
        except ValueError as refusal:
            self._refuse(str(refusal), now)
