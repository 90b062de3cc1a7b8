"""Commands of a page; and what its visitor did and workers have made, in order, until its loop takes it."""

import inspect
import math
import threading
import traceback
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

PENDING_LIMIT = 200  # actions that wait, per page
NOT_TAKEN = f"more than {PENDING_LIMIT} actions wait: what came after them is not done"
UNFINISHED = object()  # what a job returns that is to go on after those of other pages
RunInBackground = Callable[[Callable[[], Any], Callable[[Any], None]], None]  # (make, take): take(make()), later
Send = Callable[[str, bytes], None]  # (name, data): a file for the visitor
Function = TypeVar("Function", bound=Callable[..., None])


@dataclass(eq=False, kw_only=True)
class Entry:
    """An entry of a page's queue. apply(model, now): carries it out on a `PageModel` at a time, s; raises ValueError,
    in words for the visitor. moves: it moves, poses or observes, which takes long with camera images;
    order_independent: it may be applied before or after any other entry; cancels: it ends the computation that others
    wait for; coalesce_key: of entries with the same key the newest is enough, None: each counts; sender: the control
    that it came from; camera(model): whether it will ask for camera images; is_made: by a worker."""

    apply: Callable[[Any, float], None]
    moves: bool = False
    order_independent: bool = False
    cancels: bool = False
    coalesce_key: Hashable | None = None
    sender: Hashable = None
    camera: Callable[[Any], bool] = lambda model: False
    is_made: bool = False


@dataclass(frozen=True, eq=False)
class Command:
    """What a visitor can do; panels, keys and links call it by its name.

    parsers: by parameter, what a browser's value stands for; each raises ValueError if it stands for none; takes_now:
    it is given the time, s, too; latest: calls that differ in their last argument alone are values of one control, of
    which the newest is enough; moves, order_independent, cancels: as of `Entry`; link: links of the drawings and the
    page's script may call it; camera: called as `function`, whether it will ask for camera images.
    """

    name: str
    function: Callable[..., None]
    parsers: Sequence[Callable[[Any], Any]] = ()
    takes_now: bool = False
    latest: bool = False
    moves: bool = False
    order_independent: bool = False
    cancels: bool = False
    link: bool = False
    camera: Callable[..., bool] = lambda model, *arguments: False

    def __call__(self, *values: Any, sender: Hashable = None) -> Entry:
        """Parse a browser's values. Raises ValueError for values that no visitor could have chosen."""
        arguments = tuple(parse(value) for parse, value in zip(self.parsers, values, strict=True))
        return Entry(
            apply=lambda model, now: self.function(model, *arguments, **({"now": now} if self.takes_now else {})),
            coalesce_key=(self.name, *arguments[:-1]) if self.latest else None,
            sender=sender,
            camera=lambda model: self.camera(model, *arguments),
            moves=self.moves,
            order_independent=self.order_independent,
            cancels=self.cancels,
        )


COMMANDS: dict[str, Command] = {}


def add_command(name: str, function: Callable[..., None], *parsers: Callable[[Any], Any], **options: Any) -> None:
    """Add a command that is one line; `command` registers the others.

    options: fields of `Command`. Raises ValueError for a name that is taken, or another number of parsers than of
    parameters after the model.
    """
    if name in COMMANDS:
        raise ValueError(f"two commands named {name!r}")
    needed = len(_after_model(function))
    if len(parsers) != needed:
        raise ValueError(f"command {name!r}: {len(parsers)} parsers for {needed} parameters")
    timed = "now" in inspect.signature(function).parameters
    COMMANDS[name] = Command(name, function, parsers, timed, **options)


def _after_model(function: Callable) -> list[str]:
    """Return the parameters that a browser sends values for."""
    parameters = list(inspect.signature(function).parameters.values())[1:]
    return [one.name for one in parameters if one.kind is not one.KEYWORD_ONLY]


def command(name: str, **options: Any) -> Callable[[Function], Function]:
    """Register a function of the page's model and of typed parameters as a command.

    What a browser sends for a parameter is checked by its annotation: `int` and `float` take finite numbers, `bool` a
    checkbox, `str` any text, and `Annotated[T, parse]` what `parse` accepts, which raises ValueError, in words for the
    visitor, for all else. A keyword-only parameter `now` is given the time in seconds. options: as of `add_command`.
    Raises ValueError for another annotation.
    """

    def register(function: Function) -> Function:
        hints = get_type_hints(function, include_extras=True)
        parsers = (_parser(name, parameter, hints.get(parameter)) for parameter in _after_model(function))
        add_command(name, function, *parsers, **options)
        return function

    return register


def _parser(name: str, parameter: str, hint: Any) -> Callable[[Any], Any]:
    found = get_args(hint)[1] if get_origin(hint) is Annotated else PARSERS.get(hint)
    if found is None:
        raise ValueError(f"command {name!r}: {parameter} needs int, float, bool, str or Annotated[type, parse]")
    return found


class CommandQueue:
    """Any thread puts, the scheduler takes. Of one control the newest value wins, unless an action lies between:
    "slider, then reset" and "reset, then slider" are two things; a hundred values of one dragged slider are one.
    commands: by name, those that may be called."""

    def __init__(self, commands: Mapping[str, Command]):
        self.commands = commands
        self._lock = threading.Lock()
        self._waiting: list[Entry] = []

    def put(self, entry: Entry) -> None:
        """Put an entry; of too many actions the last one tells that it is not done."""
        with self._lock:
            full = len(self._waiting) >= PENDING_LIMIT
            if full and entry.coalesce_key is None:
                entry = _refusal(NOT_TAKEN, "queue")
            if entry.coalesce_key is not None:
                self._drop_older(entry, beyond_actions=full)
            self._waiting.append(entry)

    def call(self, name: str, *values: Any, sender: Hashable = None) -> None:
        """Put a command with a browser's values, or its rejection. Raises KeyError for an unknown name."""
        command = self.commands[name]
        try:
            self.put(command(*values, sender=sender))
        except ValueError as why:
            self.reject(str(why), sender or name)

    def reject(self, why: str, sender: Hashable) -> None:
        """Put what tells the visitor that an input cannot be; of a control the newest is enough."""
        self.put(_refusal(why, sender))

    def put_made(self, kind: Hashable, take: Callable[[Any], None], made: Any, **how: Any) -> None:
        """Put what a worker has made, for take(made); of a kind the newest is enough. how: as of `Entry`."""
        entry: dict[str, Any] = {"coalesce_key": ("made", kind), "is_made": True} | how
        self.put(Entry(apply=lambda model, now: take(made), **entry))

    def put_back(self, entries: list[Entry]) -> None:
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

    def take(self) -> list[Entry]:
        """Take all of it, in order."""
        with self._lock:
            taken, self._waiting = self._waiting, []
        return taken

    def take_order_independent(self, cancelling: bool = False) -> list[Entry]:
        """While nothing may move: take the entries before the first that moves, and the order-independent ones.
        cancelling: also what ends the computation that the rest waits for."""
        taken: list[Entry] = []
        waiting: list[Entry] = []
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
            return {entry.sender for entry in self._waiting}

    def _drop_older(self, entry: Entry, beyond_actions: bool) -> None:
        for k in reversed(range(len(self._waiting))):
            other = self._waiting[k]
            if other.coalesce_key == entry.coalesce_key:
                del self._waiting[k]
                return
            if other.coalesce_key is None and not beyond_actions:
                return


def _refusal(why: str, sender: Hashable) -> Entry:
    def refuse(model: Any, now: float) -> None:
        raise ValueError(why)

    return Entry(apply=refuse, coalesce_key=("rejected", sender))


class Worker:
    """Makes what takes a moment, in one thread. Of a kind a page's newest request counts, and pages take turns."""

    def __init__(self):
        self._requests: dict[tuple[CommandQueue, str], tuple] = {}
        self._changed = threading.Condition()
        threading.Thread(target=self._run, name="viewimit-worker", daemon=True).start()

    def ask(
        self, page: CommandQueue, kind: str, make: Callable[[], Any], take: Callable[[Any], None], **how: Any
    ) -> None:
        """take(made, or why not) follows in the page's own time. how: as of `Entry`."""
        with self._changed:
            self._requests[page, kind] = make, partial(page.put_made, kind, take, **how)
            self._changed.notify()

    def forget(self, page: CommandQueue) -> None:
        with self._changed:
            for key in [key for key in self._requests if key[0] is page]:
                del self._requests[key]

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._requests:
                    self._changed.wait()
                key = next(iter(self._requests))
                make, put = self._requests.pop(key)
            try:
                made = make()
            except Exception as error:  # one page's fault must not end the others' work; its page says so
                if not isinstance(error, ValueError):  # which is an answer
                    traceback.print_exc()
                made = error
            if made is UNFINISHED:
                with self._changed:
                    self._requests.setdefault(key, (make, put))
            else:
                put(made)


# What a browser sent for a parameter: anything may come. Each parser raises ValueError.


def number(value: Any) -> float:
    """A finite number."""
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not math.isfinite(found):
        raise ValueError(f"{_quoted(value)} is not a number")
    return found


def whole(value: object) -> int:
    """The nearest whole number."""
    return round(number(value))


def switch(value: object) -> bool:
    """Of a checkbox."""
    if not isinstance(value, bool):
        raise ValueError(f"{_quoted(value)} is neither on nor off")
    return value


def text(value: object) -> str:
    """Any text."""
    if not isinstance(value, str):
        raise ValueError(f"{_quoted(value)} is not a text")
    return value


def one_of(options: Any, refusal: str) -> Callable[[object], Any]:
    """Return a parser that takes a name of `options`, and returns what it stands for, or itself. options: a mapping,
    names, or a function that returns one of both; refusal: {value} stands for what came."""

    def parse(value: object) -> Any:
        names = options() if callable(options) else options
        if not isinstance(value, str) or value not in names:
            raise ValueError(refusal.format(value=_quoted(value)))
        return names[value] if isinstance(names, Mapping) else value

    return parse


def titled(entries: Mapping[str, Any], what: str) -> Callable[[object], Any]:
    """Return a parser that takes the title of an entry of a registry, and returns its name."""
    return one_of(lambda: {entry.title: name for name, entry in entries.items()}, f"there is no {what} {{value}}")


PARSERS: dict[type, Callable[[Any], Any]] = {int: whole, float: number, bool: switch, str: text}


def _quoted(value: object) -> str:
    """What came, or its beginning."""
    return repr(str(value)[:40])
