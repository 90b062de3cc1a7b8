"""What all commands have in common: how they wait, whether they need the session to themselves, what they do."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from typing import Any, ClassVar


class Command:
    """An action, of which none is lost.

    moves: it moves, poses or looks, which takes long with camera images. commutes: it makes no difference whether it
    comes before or after any other, so that it need not wait. cancels: it ends the computation that others wait for.
    """

    moves: ClassVar[bool] = False
    commutes: ClassVar[bool] = False
    cancels: ClassVar[bool] = False

    @property
    def control(self) -> Hashable | None:
        """Of commands with the same control the newest is enough; None: each counts."""
        return None

    def opens_pictures(self, model: Any) -> bool:
        """Whether it asks for camera images."""
        return False

    def apply(self, model: Any, now: float) -> None:
        """Carry it out. model: `PageModel`, which imports what commands are made for; now: s. Raises ValueError."""
        raise NotImplementedError


class Value(Command):
    """A control's value."""

    @property
    def control(self) -> Hashable | None:
        return type(self).__qualname__


class OfView(Command):
    """What changes how the session is shown, and nothing of it."""

    commutes: ClassVar[bool] = True


@dataclass(frozen=True)
class Refused(Command):
    """What a browser sent cannot be. sender: the control that it came from; of one the newest is enough."""

    why: str
    sender: Hashable = None

    @property
    def control(self) -> Hashable | None:
        return None if self.sender is None else (Refused, self.sender)

    def apply(self, model: Any, now: float) -> None:
        raise ValueError(self.why)


@dataclass(frozen=True, eq=False)
class Arrival(Command):
    """What a worker has made, handed to whoever asked for it: take(made). kind: of one kind the newest is enough."""

    kind: Hashable
    take: Callable[[Any], None]
    made: Any

    @property
    def control(self) -> Hashable:
        return Arrival, self.kind

    def apply(self, model: Any, now: float) -> None:
        self.take(self.made)


@dataclass(frozen=True, eq=False)
class MovingArrival(Arrival):
    """One that moves the demonstrator."""

    moves: ClassVar[bool] = True


# What a person did and what workers have made, in order, until the page's loop takes it.

PENDING_LIMIT = 200  # actions that wait, per page
APART = 0.05  # s on average between two equal actions; a held key repeats itself that fast
Aside = Callable[[Callable[[], Any], Callable[[Any], None]], None]  # (make, take): make beside, then take what is made
HELD_UP = 0.2  # s by which a network may bring one late, so that several come at once


class CommandQueue:
    """Any thread puts, the scheduler takes. Of one control the newest value wins, unless an action lies between; an
    action that comes again and again is one, where no person is that fast.

    "Slider, then reset" and "reset, then slider" are two things; a hundred values of one dragged slider are one.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._lock, self._clock = threading.Lock(), clock
        self._waiting: list[Command] = []
        self._last: Command | None = None  # action that was put
        self._due = 0.0  # s, when the next one that equals it is

    def put(self, command: Command) -> None:
        with self._lock:
            full = len(self._waiting) >= PENDING_LIMIT
            if command.control is not None:
                self._drop_older(command, beyond_actions=full)
            elif full or self._repeats(command):
                return
            self._waiting.append(command)

    def put_back(self, commands: list[Command]) -> None:
        """What was taken and not carried out, before all that has come since."""
        with self._lock:
            self._waiting = commands + self._waiting

    def put_value(self, parse: Callable[[Any], Command], value: Any, sender: Hashable = None) -> None:
        """The command that a browser's value stands for: parse may raise ValueError. sender: the control it is of."""
        try:
            command = parse(value)
        except ValueError as refusal:
            command = Refused(str(refusal), sender)
        self.put(command)

    def taker(
        self, kind: Hashable, take: Callable[[Any], None], arrival: type[Arrival] = Arrival
    ) -> Callable[[Any], None]:
        """What a worker hands over from its own thread: take(made) follows in the page's time. kind: as `Arrival`."""
        return lambda made: self.put(arrival(kind, take, made))

    def on_value(self, widget: Any, parse: Callable[[Any], Command]) -> None:
        """A person's changes of a widget are put as what `parse` makes of them."""

        @widget.on_update
        async def _(event) -> None:
            if event.client_id is not None:  # None: the page itself wrote it
                self.put_value(parse, event.target.value, id(widget))

    def on_click(self, widget: Any, command: Command) -> None:
        @widget.on_click
        async def _(_event) -> None:
            self.put(command)

    def take(self) -> list[Command]:
        """All of it, in order."""
        with self._lock:
            taken, self._waiting = self._waiting, []
        return taken

    def take_what_need_not_wait(self, cancelling: bool = False) -> list[Command]:
        """While nothing may move: what comes before all that moves, and what commutes with it; the rest waits.

        cancelling: also what ends the computation that the rest waits for.
        """
        taken: list[Command] = []
        waiting: list[Command] = []
        blocked = False
        with self._lock:
            for command in self._waiting:
                passes = command.commutes or (cancelling and command.cancels)
                blocked = blocked or (command.moves and not passes)
                (waiting if blocked and not passes else taken).append(command)
            self._waiting = waiting
        return taken

    def _repeats(self, action: Command) -> bool:
        """Whether it is the action before it once more, and too soon."""
        now = self._clock()
        if action != self._last:
            self._last, self._due = action, now
        elif now < self._due - HELD_UP:
            return True
        self._due = max(self._due, now) + APART
        return False

    def _drop_older(self, command: Command, beyond_actions: bool) -> None:
        for k in reversed(range(len(self._waiting))):
            other = self._waiting[k]
            if other.control == command.control:
                del self._waiting[k]
                return
            if other.control is None and not beyond_actions:
                return
