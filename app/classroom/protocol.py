"""Messages of a class as JSON text, each an object with a `kind`: what browsers send, and what the server tells them.
Messages of browsers are untrusted. Their types, sizes and ranges are checked before anything acts on them."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta, Raw, Struct

MAX_MESSAGE_BYTES = 16_000
MAX_NAME = 24  # characters
MAX_VALUES = 60  # numbers of one answer
MAX_PATH = 80  # numbers of a path: two joints, 40 postures
MAX_CODE = 100  # characters of a lecturer's code
FIELDS: dict[str, Any] = {"frozen": True, "forbid_unknown_fields": True, "tag_field": "kind", "omit_defaults": True}

Token = Annotated[str, Meta(pattern="^[0-9a-f]{32}$")]
Word = Annotated[str, Meta(min_length=1, max_length=60, pattern=r"^[\w .-]+$")]  # name of a lesson or a step
Real = Annotated[float, Meta(ge=-1e9, le=1e9)]  # excludes NaN
Count = Annotated[int, Meta(ge=0, le=1_000_000)]
Pair = tuple[Real, Real]
Path = Annotated[tuple[Real, ...], Meta(max_length=MAX_PATH)]
Phase = Literal["own", "before", "after"]


class Given(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """An answer, in the unit of its question. Exactly one field is set."""

    choice: Annotated[int, Meta(ge=0, le=20)] | None = None  # index in the lesson's file
    number: Real | None = None
    place: Pair | None = None
    posture: Pair | None = None  # degrees
    values: Annotated[tuple[Real, ...], Meta(max_length=MAX_VALUES)] | None = None

    def __post_init__(self) -> None:
        if sum(value is not None for value in (self.choice, self.number, self.place, self.posture, self.values)) != 1:
            raise ValueError("an answer has exactly one of its fields")


# What a student's browser sends


class Hello(Struct, tag="hello", **FIELDS):
    """The first message of every connection. session: of a lecturer after a login."""

    token: Token
    name: Annotated[str, Meta(max_length=MAX_NAME)] = ""
    linked: bool = True
    session: Token | None = None


class Self(Struct, tag="self", **FIELDS):
    """A changed name, or whether a person's answers may be linked to each other."""

    name: Annotated[str, Meta(max_length=MAX_NAME)] = ""
    linked: bool = True


class At(Struct, tag="at", **FIELDS):
    """Where a student is, and what the arm of that step has done. E in px², off in degrees, paths in radians."""

    lesson: Word
    step: Word
    number: Count = 0  # of the step, from 1
    count: Count = 0  # steps of the lesson
    answered: bool = False
    motions: Count = 0
    E: Annotated[float, Meta(ge=0, le=1e12)] | None = None
    off: Annotated[float, Meta(ge=0, le=1e4)] | None = None
    path: Path = ()
    demonstrator: Pair | None = None


class Answer(Struct, tag="answer", **FIELDS):
    """To the lecturer's question if `round` is its number, else at the student's own pace. seq: repeated in the reply.
    lesson: "questions" for the eight questions, whose steps are their names. right: what a page thinks, which does not
    count; pages no longer say it."""

    seq: Count
    lesson: Word
    step: Word
    answer: Given
    round: Count = 0
    phase: Phase = "own"
    right: bool | None = None
    sure: bool | None = None
    seconds: Annotated[float, Meta(ge=0, le=1e6)] | None = None


class Copy(Struct, tag="copy", **FIELDS):
    """A student's screen, which a lecturer's page has requested. state: as the lesson's page writes it."""

    number: Count
    state: Raw


class Login(Struct, tag="login", **FIELDS):
    """What somebody typed as the lecturer's code."""

    code: Annotated[str, Meta(max_length=MAX_CODE)]


# What a lecturer's browser sends besides


class Order(Struct, tag="do", **FIELDS):
    """An order without details."""

    what: Literal[
        "logout",  # in this browser
        "take",  # this page leads from now on, not another of the lecturer's
        "close",  # the question is over, and students go on where they were
        "reset",  # all start their step again
        "export",  # all answers as CSV
        "gain",  # what the class has learned, by the eight questions
        "new",  # the answers are deleted, and a new class begins
    ]


class Switch(Struct, tag="switch", **FIELDS):
    """All follow the lecturer's screen, or no longer; their controls are locked; the truth is hidden on all screens."""

    what: Literal["lead", "frozen", "hidden"]
    on: bool


class NewCode(Struct, tag="code", **FIELDS):
    """Another lecturer's code, which ends the sessions of all other browsers."""

    code: Annotated[str, Meta(min_length=8, max_length=MAX_CODE)]


class Ask(Struct, tag="ask", **FIELDS):
    """A step's question to all; if it was asked before, once more. phase: of the eight questions; seed: of the
    step's random start, so that all have the same."""

    lesson: Word
    step: Word
    phase: Phase = "own"
    seed: Count = 1


class Reveal(Struct, tag="reveal", **FIELDS):
    """The truth and the answers, for everybody. truth, near: as `votes.is_right` takes them."""

    truth: Annotated[tuple[Path, ...], Meta(max_length=200)] = ()
    near: Real | None = None


class State(Struct, tag="state", **FIELDS):
    """The lecturer's screen. once: for all, though nobody is led."""

    state: Raw
    once: bool = False


class Gather(Struct, tag="gather", **FIELDS):
    """All go to a step, and from there at their own pace."""

    lesson: Word
    step: Word
    seed: Count = 1


class Request(Struct, tag="request", **FIELDS):
    """A copy of the screen of the person at that place of the class."""

    place: Count


class Invite(Struct, tag="invite", **FIELDS):
    """A QR code of what students type: this address, or the one that the server knows for others."""

    address: Annotated[str, Meta(max_length=300)] = ""


FromStudent = Hello | Self | At | Answer | Copy | Login
FromLecturer = Order | Switch | NewCode | Ask | Reveal | State | Gather | Request | Invite
Message = FromStudent | FromLecturer
ORDERS = FromLecturer.__args__
_decoder = msgspec.json.Decoder(Message)


class Rejected(ValueError):
    """A message that no page of the class sends; the connection is closed."""


def decode(text: str | bytes | None) -> Message:
    """Return a browser's message. Raises Rejected if it is binary, too long, not JSON, or no message of a class."""
    if not isinstance(text, str):
        raise Rejected("a binary message")
    if len(text) > MAX_MESSAGE_BYTES:
        raise Rejected(f"a message of {len(text)} characters")
    try:
        return _decoder.decode(text)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise Rejected(f"no message of a class: {str(error)[:120]}") from None


# What the server sends


class Tally(Struct, frozen=True):
    """What a round was answered. counts: of each choice; values: all other answers, sorted; right: None where no
    answer is right or wrong."""

    total: int
    counts: tuple[int, ...] = ()
    values: tuple[tuple[float, ...], ...] = ()
    right: int | None = None


class Moved(Struct, frozen=True):
    """How many persons went from right to right, wrong to right, right to wrong, wrong to wrong."""

    right: int
    gained: int
    lost: int
    wrong: int


class Asked(Struct, frozen=True):
    """The lecturer's question. times: how often it was asked; the results are there once it is revealed, and the number
    of answers that they leave out."""

    round: int
    lesson: str
    step: str
    phase: Phase = "own"
    times: int = 1
    revealed: bool = False
    results: Results | None = None
    seed: int = 1
    left_out: int = 0


class Results(Struct, frozen=True):
    """Rounds of one question: now, the one before and, from the third on, the first."""

    now: Tally
    before: Tally | None = None
    first: Tally | None = None
    moved: Moved | None = None  # from the round before
    moved_since_first: Moved | None = None


class Place(Struct, frozen=True):
    """A step at which all were gathered. number: of the gathering."""

    number: int
    lesson: str
    step: str
    seed: int = 1


class Orders(Struct, frozen=True, tag="orders", tag_field="kind"):
    """All orders of the lecturer that hold now."""

    asked: Asked | None = None
    lead: bool = False
    gather: Place | None = None
    frozen: bool = False
    hidden: bool = False
    reset: int = 0


def encode(kind: str, **fields: Any) -> str:
    """Return a message of the server as text."""
    return msgspec.json.encode({"kind": kind, **fields}).decode()
