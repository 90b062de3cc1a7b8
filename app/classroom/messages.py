"""What is told in a class, as bytes: students' summaries and answers on the way up, the lecturer's orders on the way
down. All of it is read as hostile input: sizes, types and ranges are bounded."""

from __future__ import annotations

from typing import Annotated, Any, Literal, TypeVar

import msgspec
from msgspec import Meta

from viewimit.drawing.export.panels import SHADES

from ..sessions.link import MOST_CHARS

MOST_STUDENTS = 400  # of a process
MOST_NAME = 24  # characters
MOST_PATH = 40  # postures of a summary
MOST_PLACES = 400  # of a tally
MOST_ROUNDS = 60  # that a class is asked
MOST_SUMMARY = 2_000  # bytes
MOST_ROSTER = MOST_STUDENTS * MOST_SUMMARY
MOST_ORDERS = 64_000
MOST_REPLY = MOST_CHARS + 500
# who needs help first: words of `ServoStatus`, and of the page
STATES = ("lost", "stopped", "no-progress", "unobservable", "moving", "paused", "ready", "settled", "arrived")

Id = Annotated[str, Meta(pattern="^[0-9a-f]{16}$")]
Text = Annotated[str, Meta(max_length=80)]
Count = Annotated[int, Meta(ge=0, le=1_000_000)]
Tenths = Annotated[int, Meta(ge=-36_000, le=36_000)]  # of a degree
Size = Annotated[float, Meta(ge=0, le=1e12)]
Real = Annotated[float, Meta(ge=-1e6, le=1e6)]  # NaN is not within
Pair = tuple[Real, Real]
FIELDS: dict[str, Any] = {"frozen": True, "kw_only": True, "forbid_unknown_fields": True, "omit_defaults": True}


class Summary(msgspec.Struct, **FIELDS):
    """Of one student's page. E: px², None where there is none; off: degrees, the truth, for viewers only; path: of two
    joints, postures one after the other, the last is now; demo: the demonstrator's; plane: low, high of the first and
    of the second joint; hills: of the landscape, row for row from the lowest posture, 0 valley … 255, "" without one;
    lesson: its name, screen and of how many, counted from 1."""

    id: Id
    name: Annotated[str, Meta(max_length=MOST_NAME)] = ""
    state: Literal[
        "lost", "stopped", "no-progress", "unobservable", "moving", "paused", "ready", "settled", "arrived"
    ] = "ready"  # fmt: skip
    E: Size | None = None
    off: Size | None = None
    motions: Count = 0
    path: Annotated[tuple[Tenths, ...], Meta(max_length=2 * MOST_PATH)] = ()
    demo: tuple[Tenths, Tenths] | None = None
    plane: tuple[Tenths, Tenths, Tenths, Tenths] | None = None
    hills: Annotated[bytes, Meta(max_length=SHADES[0] * SHADES[1])] = b""
    lesson: tuple[Text, Count, Count] | None = None


class Roster(msgspec.Struct, **FIELDS):
    """Of the students of one process."""

    students: Annotated[tuple[Summary, ...], Meta(max_length=MOST_STUDENTS)] = ()
    version: Literal[1] = 1


class Answer(msgspec.Struct, **FIELDS):
    """To a step's question, in its unit; one of the three."""

    choice: Annotated[int, Meta(ge=0, le=20)] | None = None
    number: Annotated[float, Meta(ge=-1e9, le=1e9)] | None = None
    place: Pair | None = None
    version: Literal[1] = 1


class Copy(msgspec.Struct, **FIELDS):
    """A link to what a student's page shows; why: it cannot be said."""

    text: Annotated[str, Meta(max_length=MOST_CHARS)] = ""
    why: Annotated[str, Meta(max_length=200)] = ""
    version: Literal[1] = 1


class Shown(msgspec.Struct, **FIELDS):
    """What the lecturer's page shows: a link, or in a lesson its name and screen. motion: of the link; playing: whether
    more are to come."""

    text: Annotated[str, Meta(max_length=MOST_CHARS)] = ""
    lesson: tuple[Text, Count] | None = None
    motion: Count = 0
    playing: bool = False


class Sent(msgspec.Struct, **FIELDS):
    """Once. number: of what is sent."""

    number: Count
    shown: Shown


class Wanted(msgspec.Struct, **FIELDS):
    """A copy of a student's session."""

    number: Count
    student: Id


class Round(msgspec.Struct, **FIELDS):
    """A question that was asked: of a step of a lesson."""

    number: Count
    lesson: Text
    step: Text


class Tally(msgspec.Struct, **FIELDS):
    """What a class has answered, nobody's name in it. counts: of each choice, or of each number on the scale; places:
    clicks or postures; right: how many, None where that is not known; moved: from right to right, wrong to right, right
    to wrong, wrong to wrong, of those who answered both times."""

    total: Count = 0
    counts: Annotated[tuple[Count, ...], Meta(max_length=400)] = ()
    places: Annotated[tuple[Pair, ...], Meta(max_length=MOST_PLACES)] = ()
    right: Count | None = None
    before: tuple[Count, ...] = ()
    right_before: Count | None = None
    total_before: Count = 0
    moved: tuple[Count, Count, Count, Count] | None = None


class Asked(msgspec.Struct, **FIELDS):
    """The question that goes on. tally: once it is revealed."""

    round: Round
    revealed: bool = False
    tally: Tally | None = None


class Orders(msgspec.Struct, **FIELDS):
    """All that the lecturer wants of the class now. leader: the page that gives them; reset: how often all were."""

    leader: Annotated[str, Meta(pattern="^([0-9a-f]{16})?$")] = ""
    lead: Shown | None = None
    frozen: bool = False
    sent: Sent | None = None
    reset: Count = 0
    wanted: Wanted | None = None
    asked: Asked | None = None
    rounds: Annotated[tuple[Round, ...], Meta(max_length=MOST_ROUNDS)] = ()
    version: Literal[1] = 1


M = TypeVar("M", Roster, Answer, Copy, Orders, Summary)
MOST_BYTES: dict[type, int] = {
    Roster: MOST_ROSTER,
    Answer: MOST_REPLY,
    Copy: MOST_REPLY,
    Orders: MOST_ORDERS,
    Summary: MOST_SUMMARY,
}
encode = msgspec.msgpack.Encoder().encode


def decode(kind: type[M], data: bytes) -> M:
    """Raises ValueError for what is none, of another version, or too large."""
    if len(data) > MOST_BYTES[kind]:
        raise ValueError(f"a {kind.__name__} of {len(data)} bytes")
    try:
        return msgspec.msgpack.decode(data, type=kind)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise ValueError(f"no {kind.__name__}: {str(error)[:120]}") from None


def call_of(asked: Round | Wanted) -> str:
    """Under which replies to it are kept."""
    return f"{'round' if isinstance(asked, Round) else 'copy'} {asked.number}"
