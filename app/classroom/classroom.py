"""The pages of one process in a class: what they tell goes to the board, what the lecturer wants of them comes back.

One thread talks to the store, a few times a second, however many pages there are; no page waits for it.
"""

import hashlib
import logging
import secrets
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import msgspec

from .board import LED_S, Board
from .messages import Answer, Copy, Orders, Roster, Round, Summary, call_of, decode, encode

PUBLISH_EVERY = 1.0  # s at least between two rosters of a process, and between two looks at all students
WHOLE_EVERY = 4.0  # s after which a roster is written again, whatever the store still has
M = TypeVar("M", Answer, Copy)
log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Heard:
    """The newest orders. present: whether the lecturer has given a sign of life lately; first: the page has heard none
    before."""

    orders: Orders
    present: bool
    first: bool = False

    @property
    def leads(self) -> bool:
        return self.present and self.orders.lead is not None

    @property
    def freezes(self) -> bool:
        return self.present and self.orders.frozen


@dataclass(frozen=True)
class Seen:
    """What the lecturer's page is told. students: all that are here; answers: to the question that goes on, by student,
    and earlier: to the same one when it was asked before; copy: of a session, as wanted; problem: why this is not all.
    """

    students: tuple[Summary, ...] = ()
    answers: Mapping[str, Answer] = field(default_factory=dict)
    earlier: Mapping[str, Answer] = field(default_factory=dict)
    copy: tuple[int, Copy] | None = None
    problem: str | None = None


NOBODY = Seen()
Rounds = tuple[tuple[Round, Mapping[str, Answer]], ...]


class Member:
    """One page. hear(heard): what the lecturer wants, when it changes; see(seen): for a lecturer's page, what there is
    of all; both are called from the thread that talks to the store."""

    def __init__(self, id: str, hear: Callable[[Heard], None], see: Callable[[Seen], None] | None = None):
        self.id, self.hear, self.see = id, hear, see
        self._classroom: Classroom | None = None
        self.summary: Summary | None = None
        self.heard: Heard | None = None
        self.seen: Seen | None = None
        self._replies: dict[str, bytes] = {}
        self.changes: list[Callable[[Orders], Orders]] = []
        self.collecting: Callable[[Rounds], None] | None = None

    def tell(self, summary: Summary) -> None:
        """What the page is; to be told once a second at most."""
        self.summary = summary

    def reply(self, call: str, message: Answer | Copy) -> None:
        self._replies[call] = encode(message)
        self._wake()

    def order(self, change: Callable[[Orders], Orders]) -> None:
        """What this page wants of the class, if it is the one that leads: made of the orders that stand then."""
        self.changes.append(change)
        self._wake()

    def take_over(self) -> None:
        """Lead from now on, whichever page did before."""
        self.order(_take_over)

    def collect(self, done: Callable[[Rounds], None]) -> None:
        """All that was answered, to be given to done() by that thread."""
        self.collecting = done
        self._wake()

    def take_replies(self) -> dict[str, bytes]:
        taken, self._replies = self._replies, {}
        return taken

    def put_back(self, replies: Mapping[str, bytes]) -> None:
        """What could not be told, unless something else is to be told by now."""
        self._replies = {**replies, **self._replies}

    def joined(self, classroom: "Classroom") -> None:
        self._classroom = classroom

    def _wake(self) -> None:
        if self._classroom is not None:
            self._classroom.wake()


class Classroom:
    """name: of the class, for its students' ids, from which nobody can tell their browsers' tokens."""

    def __init__(self, board: Board, name: str, clock: Callable[[], float] = time.monotonic):
        self._board, self._name, self._clock = board, name, clock
        self._process = secrets.token_hex(8)
        self._members: list[Member] = []
        self._lock = threading.Lock()
        self._changed = threading.Event()
        self._stopped = False
        self._published: bytes | None = None
        self._whole_at = self._published_at = self._looked_at = -float("inf")
        self._failing = False
        self._read = b"", Orders()
        self._thread = threading.Thread(target=self._run, name="viewimit-class", daemon=True)

    def start(self) -> None:
        self._board.watch(self.wake)
        self._thread.start()

    def stop(self) -> None:
        """Its students are gone."""
        self._stopped = True
        self.wake()
        if self._thread.is_alive():
            self._thread.join(2.0)
        try:
            self._board.leave(self._process)
        except OSError:
            pass  # the sign of life that is missing tells the same a little later
        self._board.close()

    def id_of(self, key: str | None) -> str:
        """Of a page by the key of its session, the same when it comes back; None: of one that is not kept."""
        if key is None:
            return secrets.token_hex(8)
        return hashlib.blake2b(key.encode(), key=self._name.encode()[:64], digest_size=8).hexdigest()

    def join(self, member: Member) -> None:
        member.joined(self)
        with self._lock:
            self._members.append(member)
        self.wake()

    def leave(self, member: Member) -> None:
        with self._lock:
            if member in self._members:
                self._members.remove(member)

    def wake(self) -> None:
        """Look now."""
        self._changed.set()

    def turn(self) -> None:
        """One look at the board."""
        with self._lock:
            members = list(self._members)
        now = self._clock()
        try:
            self._give_orders(members)
            self._hear(members)
            if now - self._published_at >= PUBLISH_EVERY:
                self._published_at = now
                self._publish(members, now)
            self._reply(members)
            lecturers = [member for member in members if member.see is not None]
            if lecturers and now - self._looked_at >= PUBLISH_EVERY:
                self._looked_at = now
                self._look(lecturers)
            self._collect(lecturers)
        except OSError as error:
            if not self._failing:  # one line until it answers again
                log.warning("the class does not meet: %s", error)
            self._failing = True
            for member in members:
                self._show(member, Seen(problem=str(error)))
            return
        self._failing = False

    def _run(self) -> None:
        while not self._stopped:
            self._changed.wait(self._board.look_every)
            self._changed.clear()
            if not self._stopped:
                self.turn()

    def _orders(self) -> tuple[int, Orders, bool]:
        number, data, age = self._board.orders()
        if data != self._read[0]:
            self._read = data, _read_orders(data)
        return number, self._read[1], age < LED_S

    def _give_orders(self, members: list[Member]) -> None:
        """What was asked for since, each a change of what then stands there."""
        for member in members:
            while member.changes:
                number, orders, present = self._orders()
                change = member.changes[0]
                if change is _take_over:
                    wanted = taken_over(orders, member.id, present)
                else:
                    wanted = change(orders) if orders.leader == member.id else orders
                if wanted == orders or self._board.order(number, encode(wanted)):
                    member.changes.pop(0)

    def _hear(self, members: list[Member]) -> None:
        number, orders, present = self._orders()
        for member in members:
            if present and orders.leader == member.id and self._clock() - self._published_at >= PUBLISH_EVERY:
                self._board.live(number)
            heard = member.heard
            if heard is None or heard.orders != orders or heard.present != present:
                member.heard = Heard(orders, present, first=heard is None)
                member.hear(member.heard)

    def _publish(self, members: list[Member], now: float) -> None:
        students = tuple(member.summary for member in members if member.see is None and member.summary is not None)
        data = encode(Roster(students=students))
        if data != self._published or now - self._whole_at >= WHOLE_EVERY:
            self._board.publish(self._process, data)
            self._published, self._whole_at = data, now
        else:
            self._board.publish(self._process, None)

    def _reply(self, members: list[Member]) -> None:
        calls: dict[str, dict[str, bytes]] = {}
        for member in members:
            for call, data in member.take_replies().items():
                calls.setdefault(call, {})[member.id] = data
        try:
            for call, replies in calls.items():
                self._board.reply(call, replies)
        except OSError:
            for member in members:
                member.put_back({call: replies[member.id] for call, replies in calls.items() if member.id in replies})
            raise

    def _look(self, lecturers: list[Member]) -> None:
        _, orders, _ = self._orders()
        students: dict[str, Summary] = {}
        for data in self._board.rosters():
            try:
                students |= {one.id: one for one in decode(Roster, data).students}
            except ValueError as error:
                log.warning("students of a process are not shown: %s", error)
        answers: Mapping[str, Answer] = {}
        earlier: Mapping[str, Answer] = {}
        if orders.asked is not None:
            answers = self._replies(Answer, orders.asked.round)
            before = earlier_round(orders)
            earlier = {} if before is None else self._replies(Answer, before)
        copy = None
        if orders.wanted is not None:
            found = _read_replies(Copy, self._board.replies(call_of(orders.wanted)))
            if orders.wanted.student in found:
                copy = orders.wanted.number, found[orders.wanted.student]
        seen = Seen(tuple(students.values()), answers, earlier, copy)
        for member in lecturers:
            self._show(member, seen)

    def _show(self, member: Member, seen: Seen) -> None:
        if member.see is not None and seen != member.seen:
            member.seen = seen
            member.see(seen)

    def _collect(self, lecturers: list[Member]) -> None:
        for member in lecturers:
            if member.collecting is not None:
                done, member.collecting = member.collecting, None
                _, orders, _ = self._orders()
                done(tuple((asked, self._replies(Answer, asked)) for asked in orders.rounds))

    def _replies(self, kind: type[M], asked: Round) -> dict[str, M]:
        return _read_replies(kind, self._board.replies(call_of(asked)))


def _take_over(orders: Orders) -> Orders:
    """Stands among changes for `taken_over`, which needs to know by whom."""
    return orders


def taken_over(orders: Orders, by: str, present: bool) -> Orders:
    """What another page had ordered goes on, unless that one had let go by its silence."""
    if present:
        return msgspec.structs.replace(orders, leader=by)
    return msgspec.structs.replace(orders, leader=by, lead=None, frozen=False)


def earlier_round(orders: Orders) -> Round | None:
    """When the same step was asked the last time before."""
    asked = orders.asked
    if asked is None:
        return None
    same = [
        one
        for one in orders.rounds
        if (one.lesson, one.step) == (asked.round.lesson, asked.round.step) and one.number < asked.round.number
    ]
    return same[-1] if same else None


def _read_orders(data: bytes) -> Orders:
    """None yet, or none of this version: nothing is wanted."""
    try:
        return decode(Orders, data) if data else Orders()
    except ValueError as error:
        log.warning("the lecturer's orders are not followed: %s", error)
        return Orders()


def _read_replies(kind: type[M], replies: Mapping[str, bytes]) -> dict[str, M]:
    """Those that are some."""
    found = {}
    for student, data in replies.items():
        try:
            found[student] = decode(kind, data)
        except ValueError:
            continue  # one page's nonsense is nobody's answer
    return found
