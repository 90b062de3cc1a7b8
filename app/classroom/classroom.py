"""The pages of one process in a class: what they tell goes to the board, what the lecturer wants of them comes back.

One thread talks to the store, a few times a second, however many pages there are; no page waits for it.
"""

import hashlib
import logging
import secrets
import threading
import time
from collections.abc import Callable

from .board import LED_S, Board
from .member import Heard, Member, Seen
from .messages import Orders, Roster, encode
from .orders import read_orders
from .overview import rounds_on, seen_on

PUBLISH_EVERY = 1.0  # s at least between two rosters of a process, and between two looks at all students
WHOLE_EVERY = 4.0  # s after which a roster is written again, whatever the store still has
log = logging.getLogger(__name__)


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
        member.joined(self.wake)
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
            self._read = data, read_orders(data)
        return number, self._read[1], age < LED_S

    def _give_orders(self, members: list[Member]) -> None:
        """What was asked for since, each a change of what then stands there."""
        for member in members:
            while member.changes:
                number, orders, present = self._orders()
                wanted = member.changes[0](orders, present)
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
        seen = seen_on(self._board, orders)
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
                done(rounds_on(self._board, orders))
