"""The format of a lesson file: an ordered list of steps, each of which asks before it reveals. `msgspec` checks names
and types; checks.py checks the rest."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Any

import msgspec
from msgspec import Meta

from viewimit.loop.settings import PAPER_FIELDS, Settings

MAX_WORDS = 60  # of a step's text
SCENE_FIELDS = ("head", "demonstrator", "learner", "points")  # of a scene file, that a step may change
FIELDS: dict[str, Any] = {"frozen": True, "kw_only": True, "forbid_unknown_fields": True}
Positive = Annotated[float, Meta(gt=0)]
Rounds = Annotated[int, Meta(ge=1, le=20)]
_BRACES = re.compile(r"\{([^{}]*)\}")


class Figure(msgspec.Struct, **FIELDS):
    """A drawing of a step, with its layers before and after the answer."""

    figure: str  # of figures/layers.toml
    show: tuple[str, ...] = ()  # layers, from the beginning
    reveal: tuple[str, ...] = ()  # layers that the answer adds
    hide: tuple[str, ...] = ()  # layers that the answer removes


class Option(msgspec.Struct, **FIELDS):
    """One answer to choose."""

    text: str
    because: str  # the reply to it
    right: bool = False
    belief: str = ""  # tag of the misconception behind it


class Choice(msgspec.Struct, tag="choice", tag_field="kind", **FIELDS):
    """Two to four answers. Wrong ones are beliefs that people really hold."""

    question: str
    answers: Annotated[tuple[Option, ...], Meta(min_length=2, max_length=4)]
    right: str | None = None  # a measure: the number of the right answer, from 1, where it is computed


class Elsewhere(msgspec.Struct, **FIELDS):
    """A place or a line other than the truth, and the reply to a click near it. It comes before `close` and `far`."""

    truth: str  # a measure: a point or a line of the figure
    near: Positive  # in the figure's unit
    because: str
    belief: str = ""


class Place(msgspec.Struct, tag="place", tag_field="kind", **FIELDS):
    """A click in one of the step's main figures."""

    question: str
    figure: str
    truth: str  # a measure: a point or a line of that figure
    near: Positive  # in the figure's unit: a click within it is close
    close: str
    far: str
    line: str | None = None  # a measure: a far click is on the right way if it is below `near`
    on_line: str | None = None  # the reply to such a click
    elsewhere: tuple[Elsewhere, ...] = ()  # other replies; the first that fits is given


class Number(msgspec.Struct, tag="number", tag_field="kind", **FIELDS):
    """A number on a scale."""

    question: str
    unit: str
    low: float
    high: float
    truth: str  # a measure
    close: str
    far: str
    step: float | None = None
    factor: Annotated[float, Meta(gt=1)] | None = None  # a guess at most so many times too large or small is close
    within: Positive | None = None  # or one that differs by this at most
    less: str | None = None  # the reply to a guess that is too small, instead of `far`
    logarithmic: bool = False


class Do(msgspec.Struct, tag="do", tag_field="kind", **FIELDS):
    """A goal to reach with the step's sliders: a measure below or above a number."""

    question: str
    measure: str
    below: float | None = None
    above: float | None = None
    counted: bool = False  # steps are counted, and can begin again


class Pose(msgspec.Struct, tag="pose", tag_field="kind", **FIELDS):
    """A posture of the ghost arm, set with the sliders `guess 1` and `guess 2`."""

    question: str
    truth: str  # a measure: a posture
    near: Positive  # degrees
    close: str
    far: str


class Predict(msgspec.Struct, tag="predict", tag_field="kind", **FIELDS):
    """Rounds of two parts: set the knobs and click where a point will go, then turn. Knobs act on the turn only."""

    question: str
    figure: str
    measure: str  # what a turn brings nearer to the goal
    below: float  # the goal
    times: Rounds = 8  # rounds at most
    counted: bool = True


class Bet(msgspec.Struct, tag="bet", tag_field="kind", **FIELDS):
    """How sure somebody is that a claim holds: 0 to 100 %, in steps of 5."""

    question: str
    truth: str  # a measure: 1 if the claim holds, else 0
    times: Rounds = 1  # rounds, each with the next of the step's records


Ask = Choice | Place | Number | Do | Pose | Predict | Bet


class Slider(msgspec.Struct, **FIELDS):
    """What a slider turns, by its name. `demo 1`, `own 1`, `guess 1`, … are joints of the demonstrator, the learner and
    the ghost arm. A field of `Settings` sets that field. `distance`, `camera distance` and `baseline` move the eyes.
    Other names are for the step's figures."""

    name: str
    label: str
    low: float
    high: float
    start: float
    step: Positive = 1.0
    unit: str | None = None  # None shows no number
    logarithmic: bool = False


class Headline(msgspec.Struct, **FIELDS):
    """A number that a reveal shows in large."""

    measure: str
    label: str
    note: str = ""


class Step(msgspec.Struct, **FIELDS):
    """One screen: a text, figures, and a question. Words in braces are measures."""

    id: str
    title: str
    text: str  # at most MAX_WORDS words, **bold**
    say: str  # the sentence that one can say afterwards
    ask: Ask
    settings: dict[str, Any] = {}  # fields of `Settings` that differ from the lesson's
    scene: dict[str, Any] = {}  # fields of a scene file that differ, of SCENE_FIELDS
    chosen: int | None = None  # a body point, whose lines are drawn
    main: tuple[Figure, ...] = ()  # large figures
    side: tuple[Figure, ...] = ()
    sliders: Annotated[tuple[Slider, ...], Meta(max_length=3)] = ()
    race: tuple[str, ...] = ()  # servos that run from the same start
    play: Positive | None = None  # seconds that the animation of the reveal takes
    meets: bool = False  # the reveal brings the learner to the demonstrator's posture
    carry: str | None = None  # the id of an earlier step whose state and path continue here
    randomise: bool = False  # postures are sampled at random
    headline: Headline | None = None
    after: str = ""


class Lesson(msgspec.Struct, **FIELDS):
    """A lesson file. minutes: the time it takes; settings: fields of `Settings` for all steps."""

    title: str
    short: str  # its name in a list
    about: str  # one sentence
    minutes: int
    step: Annotated[tuple[Step, ...], Meta(min_length=1, max_length=60)]
    afterwards: str = ""  # what one can say then, one sentence
    settings: dict[str, Any] = {}
    questions: bool = False  # asks the eight questions before and after


class Item(msgspec.Struct, **FIELDS):
    """One of the eight questions, asked before and after in the same words."""

    id: str
    text: str
    answers: Annotated[tuple[Option, ...], Meta(min_length=4, max_length=4)]
    step: str  # lesson/step that explains it


class Questions(msgspec.Struct, **FIELDS):
    """The file of the questions."""

    item: Annotated[tuple[Item, ...], Meta(min_length=8, max_length=8)]


def settings_of(lesson: Lesson, step: Step, **changes: Any) -> Settings:
    """Return a step's settings: the paper's, changed by the lesson, the step and `changes`. Raises ValueError for a
    value that a setting cannot have; the message names the setting."""
    fields = {**lesson.settings, **step.settings, **changes}
    return msgspec.convert({**PAPER_FIELDS, **fields}, Settings)


def figures_of(step: Step) -> tuple[Figure, ...]:
    """Return a step's figures, the large ones first."""
    return (*step.main, *step.side)


def measures_in(words: str) -> list[str]:
    """Return the measures that stand in braces."""
    return _BRACES.findall(words)


def texts_with_measures(step: Step) -> list[tuple[str, str]]:
    """Return (field, words) of all words of a step in which measures may stand."""
    ask, headline = step.ask, step.headline
    found = [(f".{name}", getattr(step, name)) for name in ("text", "after", "say")]
    found += [(f".headline.{name}", getattr(headline, name)) for name in ("label", "note") if headline is not None]
    for name in ("answers", "elsewhere"):
        found += [(f".ask.{name}[{k}].because", one.because) for k, one in enumerate(getattr(ask, name, ()))]
    said = {name: getattr(ask, name, None) for name in ("question", "close", "far", "less", "on_line")}
    return found + [(f".ask.{name}", words) for name, words in said.items() if words]


def measures_of(step: Step) -> Mapping[str, str]:
    """Return all measures that a step names, each with the field that names it first."""
    ask, headline = step.ask, step.headline
    named = [(getattr(ask, name, None), f".ask.{name}") for name in ("truth", "measure", "right", "line")]
    named += [(one.truth, f".ask.elsewhere[{k}].truth") for k, one in enumerate(getattr(ask, "elsewhere", ()))]
    named += [] if headline is None else [(headline.measure, ".headline.measure")]
    named += [(name, field) for field, words in texts_with_measures(step) for name in measures_in(words)]
    found: dict[str, str] = {}
    for name, field in named:
        if name is not None:
            found.setdefault(name, field)
    return found
