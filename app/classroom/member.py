"""One page in a class: what it wants of the others, and what it is told of them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from .messages import Answer, Asked, Copy, Orders, Round, Summary, encode
from .orders import taken_over


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

    @property
    def asked(self) -> Asked | None:
        """The question that goes on."""
        return self.orders.asked if self.present else None


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
Change = Callable[[Orders, bool], Orders]  # of the orders that stand, and whether who gave them is there


class Member:
    """One page. hear(heard): what the lecturer wants, when it changes; see(seen): for a lecturer's page, what there is
    of all; both are called from the thread that talks to the store."""

    def __init__(self, id: str, hear: Callable[[Heard], None], see: Callable[[Seen], None] | None = None):
        self.id, self.hear, self.see = id, hear, see
        self._wake: Callable[[], None] = lambda: None  # the thread that talks to the store
        self.summary: Summary | None = None
        self.heard: Heard | None = None
        self.seen: Seen | None = None
        self._replies: dict[str, bytes] = {}
        self.changes: list[Change] = []
        self.collecting: Callable[[Rounds], None] | None = None

    def tell(self, summary: Summary) -> None:
        """What the page is; to be told once a second at most."""
        self.summary = summary

    def reply(self, call: str, message: Answer | Copy) -> None:
        self._replies[call] = encode(message)
        self._wake()

    def order(self, change: Callable[[Orders], Orders]) -> None:
        """What this page wants of the class, if it is the one that leads: made of the orders that stand then."""
        self._change(lambda orders, present: change(orders) if orders.leader == self.id else orders)

    def take_over(self) -> None:
        """Lead from now on, whichever page did before."""
        self._change(lambda orders, present: taken_over(orders, self.id, present))

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

    def joined(self, wake: Callable[[], None]) -> None:
        """wake(): see to what it wants now."""
        self._wake = wake

    def _change(self, change: Change) -> None:
        self.changes.append(change)
        self._wake()
