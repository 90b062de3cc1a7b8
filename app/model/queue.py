"""What a visitor did and what workers have made, in order, until the page's loop takes it."""

import math
import threading
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass
from typing import Any

from ..jobs.threads import Worker

PENDING_LIMIT = 200  # actions that wait, per page
RunInBackground = Callable[[Callable[[], Any], Callable[[Any], None]], None]  # (make, take): take(make()), later


class Queued:
    """An entry of a page's queue: a user action, none of which is lost.

    moves: it moves, poses or observes, which takes long with camera images; order_independent: it may be applied before
    or after any other entry, so that it need not wait; cancels: it ends the computation that others wait for;
    coalesce_key: of entries with the same key the newest is enough, None: each counts.
    """

    moves: bool = False
    order_independent: bool = False
    cancels: bool = False
    coalesce_key: Hashable | None = None

    def needs_camera(self, model: Any) -> bool:
        """Return whether it asks for camera images."""
        return False

    def apply(self, model: Any, now: float) -> None:
        """Carry it out on a `PageModel` at a time, s. Raises ValueError, in words for the visitor."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Command:
    """A command of the page, as `commands.registry.command` declares it; panels, keys and links call it by its name.

    parsers: by parameter, what a browser's value stands for; each raises ValueError if it stands for none; takes_now:
    it is given the time, s, too; latest: calls that differ in their last argument alone are values of one control, of
    which the newest is enough; moves, order_independent, cancels: as of `Queued`; link: links of the drawings and the
    page's script may call it; camera: called as `function`, whether it will ask for camera images.
    """

    name: str
    function: Callable[..., None]
    parsers: tuple[Callable[[Any], Any], ...] = ()
    takes_now: bool = False
    latest: bool = False
    moves: bool = False
    order_independent: bool = False
    cancels: bool = False
    link: bool = False
    camera: Callable[..., bool] | None = None

    def __call__(self, *values: Any, sender: Hashable = None) -> "Call":
        """Parse a browser's values. Raises ValueError for values that no visitor could have chosen."""
        return Call(self, tuple(parse(value) for parse, value in zip(self.parsers, values, strict=True)), sender)


class Call(Queued):
    """A command with its arguments. sender: the control that it came from."""

    def __init__(self, command: Command, arguments: tuple[Any, ...], sender: Hashable = None):
        self.command, self.arguments, self.sender = command, arguments, sender
        self.moves, self.cancels = command.moves, command.cancels
        self.order_independent = command.order_independent
        self.coalesce_key = (command.name, *arguments[:-1]) if command.latest else None

    def needs_camera(self, model: Any) -> bool:
        return self.command.camera is not None and self.command.camera(model, *self.arguments)

    def apply(self, model: Any, now: float) -> None:
        times = {"now": now} if self.command.takes_now else {}
        self.command.function(model, *self.arguments, **times)


class Rejected(Queued):
    """An input that cannot be. sender: the control that it came from, of which the newest is enough."""

    def __init__(self, why: str, sender: Hashable = None):
        self.why, self.coalesce_key = why, None if sender is None else (Rejected, sender)

    def apply(self, model: Any, now: float) -> None:
        raise ValueError(self.why)


class JobResult(Queued):
    """What a worker has made, handed to the code that asked for it: take(made). Of one kind the newest is enough."""

    def __init__(self, kind: Hashable, take: Callable[[Any], None], made: Any, moves: bool = False):
        self.take, self.made, self.moves, self.coalesce_key = take, made, moves, (JobResult, kind)

    def apply(self, model: Any, now: float) -> None:
        self.take(self.made)


class CommandQueue:
    """Any thread puts, the scheduler takes. Of one control the newest value wins, unless an action lies between:
    "slider, then reset" and "reset, then slider" are two things; a hundred values of one dragged slider are one.

    commands: by name, those that may be called.
    """

    def __init__(self, commands: Mapping[str, Command]):
        self.commands = commands
        self._lock = threading.Lock()
        self._waiting: list[Queued] = []

    def put(self, entry: Queued) -> None:
        with self._lock:
            full = len(self._waiting) >= PENDING_LIMIT
            if entry.coalesce_key is not None:
                self._drop_older(entry, beyond_actions=full)
            elif full:
                return
            self._waiting.append(entry)

    def call(self, name: str, *values: Any, sender: Hashable = None) -> None:
        """Put a command with a browser's values, or its rejection. Raises KeyError for an unknown name."""
        command = self.commands[name]
        try:
            entry: Queued = command(*values, sender=sender)
        except ValueError as why:
            entry = Rejected(str(why), sender or name)
        self.put(entry)

    def put_back(self, entries: list[Queued]) -> None:
        """Put back entries that were taken and not applied, before newer ones."""
        with self._lock:
            self._waiting = entries + self._waiting

    def on_value(self, widget: Any, name: str, *first: Any) -> None:
        """Call a command with `first` and the value of a widget, whenever a person changes that."""
        self.commands[name]  # a name that is none fails as the page is built

        @widget.on_update
        async def call(event) -> None:
            if event.client_id is not None:  # None: the page itself wrote it
                self.call(name, *first, event.target.value, sender=id(widget))

    def on_click(self, widget: Any, name: str, *values: Any) -> None:
        """Call a command whenever a person presses a button."""
        call = self.commands[name](*values)

        @widget.on_click
        async def put(_event) -> None:
            self.put(call)

    def take(self) -> list[Queued]:
        """Take all of it, in order."""
        with self._lock:
            taken, self._waiting = self._waiting, []
        return taken

    def take_order_independent(self, cancelling: bool = False) -> list[Queued]:
        """While nothing may move: take the entries before the first that moves, and the order-independent ones.

        cancelling: also what ends the computation that the rest waits for.
        """
        taken: list[Queued] = []
        waiting: list[Queued] = []
        blocked = False
        with self._lock:
            for entry in self._waiting:
                passes = entry.order_independent or (cancelling and entry.cancels)
                blocked = blocked or (entry.moves and not passes)
                (waiting if blocked and not passes else taken).append(entry)
            self._waiting = waiting
        return taken

    def waiting_senders(self) -> set[Hashable]:
        """Return the controls whose newest values have not been applied."""
        with self._lock:
            return {entry.sender for entry in self._waiting if isinstance(entry, Call)}

    def _drop_older(self, entry: Queued, beyond_actions: bool) -> None:
        for k in reversed(range(len(self._waiting))):
            other = self._waiting[k]
            if other.coalesce_key == entry.coalesce_key:
                del self._waiting[k]
                return
            if other.coalesce_key is None and not beyond_actions:
                return


class Beside:
    """Makes for a page what takes long, in a worker's thread."""

    def __init__(self, page_id: int, worker: Worker, queue: CommandQueue):
        self._page_id, self._worker, self._queue = page_id, worker, queue

    def ask(self, kind: str, make: Callable[[], Any], take: Callable[[Any], None], moves: bool = False) -> None:
        """take(made, or why not) follows in the page's own time; of a kind the newest request is enough."""
        self._worker.ask(self._page_id, make, lambda made: self._queue.put(JobResult(kind, take, made, moves)), kind)


# What a browser sent for a parameter: anything may come


def number(value) -> float:
    """A finite number. Raises ValueError."""
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not math.isfinite(found):
        raise ValueError(f"{_quoted(value)} is not a number")
    return found


def choice(value, options: Mapping, refusal: str):
    """What an option stands for. Raises ValueError with the refusal, in which {value} stands for what came."""
    if not isinstance(value, str) or value not in options:
        raise ValueError(refusal.format(value=_quoted(value)))
    return options[value]


def named(value, entries: Mapping[str, Any], refusal: str) -> str:
    """The name of an entry of a registry, by its title. Raises ValueError, as `choice` does."""
    return choice(value, {entry.title: name for name, entry in entries.items()}, refusal)


def switch(value) -> bool:
    """Raises ValueError."""
    if not isinstance(value, bool):
        raise ValueError(f"{_quoted(value)} is neither on nor off")
    return value


def text(value: object) -> str:
    """Take any text. Raises ValueError."""
    if not isinstance(value, str):
        raise ValueError(f"{_quoted(value)} is not a text")
    return value


def one_of(options: Mapping[str, Any] | Callable[[], Mapping[str, Any]], refusal: str) -> Callable[[object], Any]:
    """Return a parser that takes a name of `options`, and returns the option. refusal: as of `choice`."""
    return lambda value: choice(value, options() if callable(options) else options, refusal)


def _quoted(value: object) -> str:
    """What came, or its beginning."""
    return repr(str(value)[:40])


def whole(value: object) -> int:
    """Return the nearest whole number. Raises ValueError."""
    return round(number(value))
