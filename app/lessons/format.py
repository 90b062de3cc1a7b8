"""What a lesson is, as its file has it: an ordered list of steps, each of which asks before it shows."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec

from viewimit.loop.settings import PAPER_FIELDS, Settings
from viewimit.sensing.renamed import current_settings

MOST_WORDS = 60  # of a step's text
CHANGEABLE = ("head", "demonstrator", "learner", "points")  # of a scene, in a step
FIELDS: dict[str, Any] = {"frozen": True, "kw_only": True, "forbid_unknown_fields": True}


def settings_of(fields: Mapping[str, Any]) -> Settings:
    """Of a lesson: the paper's, but for these fields. Raises ValueError that names the one that cannot be."""
    return msgspec.convert({**PAPER_FIELDS, **current_settings(fields)}, Settings)


class Figure(msgspec.Struct, **FIELDS):
    """A drawing of a step. figure: of `FIGURES`; show: its layers, of those that it names; reveal: what is shown
    besides once the step has been answered; hide: what is not shown any more then."""

    figure: str
    show: tuple[str, ...] = ()
    reveal: tuple[str, ...] = ()
    hide: tuple[str, ...] = ()


class Option(msgspec.Struct, **FIELDS):
    """One answer of a choice. because: what is said to whoever chose it."""

    text: str
    because: str
    right: bool = False


class Choice(msgspec.Struct, tag="choice", tag_field="kind", **FIELDS):
    """Two to four answers, wrong ones that people really believe. right: a measure that says by its number which
    answer is right, from 1, where that is computed and not written."""

    question: str
    answers: tuple[Option, ...]
    right: str | None = None


class Place(msgspec.Struct, tag="place", tag_field="kind", **FIELDS):
    """A click in one of the step's figures. truth: a measure that is a place of it; near: in its unit, within which a
    click is called close; close, far: what is said then; line: a measure by which it was on the right way though far,
    below `near`, and on_line what is said then."""

    question: str
    figure: str
    truth: str
    near: float
    close: str
    far: str
    line: str | None = None
    on_line: str | None = None


class Number(msgspec.Struct, tag="number", tag_field="kind", **FIELDS):
    """A number on a scale. truth: a measure; factor: within which a guess is close, or within: by how much it may
    differ; less: what is said in place of `far` to whoever guessed too little; logarithmic: the scale."""

    question: str
    unit: str
    low: float
    high: float
    truth: str
    close: str
    far: str
    step: float | None = None
    factor: float | None = None
    within: float | None = None
    less: str | None = None
    logarithmic: bool = False


class Do(msgspec.Struct, tag="do", tag_field="kind", **FIELDS):
    """Something to be reached by the step's sliders or buttons: a measure below or above a number. counted: the
    sliders' motions count, and begin anew at will."""

    question: str
    measure: str
    below: float | None = None
    above: float | None = None
    counted: bool = False


class Pose(msgspec.Struct, tag="pose", tag_field="kind", **FIELDS):
    """A posture of a see-through arm, set by two sliders, `guess 1` and `guess 2`. truth: a measure that is a posture;
    near: degrees."""

    question: str
    truth: str
    near: float
    close: str
    far: str


class Value(msgspec.Struct, **FIELDS):
    """One that a field may have. text: its words."""

    value: str | bool | int | float
    text: str


class Field(msgspec.Struct, **FIELDS):
    """Of `Settings`, by name, and the values to select from."""

    name: str
    label: str
    values: tuple[Value, ...]


class Select(msgspec.Struct, tag="select", tag_field="kind", **FIELDS):
    """Fields of `Settings`, a value of each to be selected: with these the step's works are made."""

    question: str
    fields: tuple[Field, ...]


Ask = Choice | Place | Number | Do | Pose | Select


class Slider(msgspec.Struct, **FIELDS):
    """name: what figures and measures know it by: `demo 1`, `own 1`, `guess 1` … are joints, of the demonstrator, the
    learner and a see-through arm, by their place among those that move; that of a field of `Settings` sets it, and
    those of `scenes.SLIDERS` move the eyes. unit: behind its number, None for no number at all."""

    name: str
    label: str
    low: float
    high: float
    start: float
    step: float = 1.0
    unit: str | None = None
    logarithmic: bool = False


class Range(msgspec.Struct, **FIELDS):
    """What is dealt at random with the start, evenly from low to high in steps. name: a field of `Settings`, or
    `head distance`, `head baseline`, m, `head toe-in`, degrees."""

    name: str
    low: float
    high: float
    step: float


class Said(msgspec.Struct, **FIELDS):
    """What a reveal tells in large: a measure, the words that name it, and a note below. What stands in braces, in any
    words of a step, is a measure that is computed."""

    measure: str
    label: str
    note: str = ""


class Question(msgspec.Struct, **FIELDS):
    """Asked before the first step, and again in other words after the last. answers: texts, the first of which is
    right; they are shown in another order."""

    before: str
    after: str
    answers: tuple[str, ...]
    answers_after: tuple[str, ...]


class Step(msgspec.Struct, **FIELDS):
    """id: by which other steps know it; text: at most MOST_WORDS words, **bold**, the first sentence plain; settings:
    fields of `Settings` by name, the rest as the lesson has them; scene: what is different in it, by fields of a scene
    file, of CHANGEABLE; chosen: a body point, with its rays in the scene;
    main, side: figures, large and small; nothing else is shown, and nothing is in reach but what is asked and sliders:
    what can be turned; works: what is computed for it beside what its figures show; race: servos that are run from the
    same start; play: what has motions is shown motion for motion once it is revealed, so many a second; meets: the
    reveal brings the learner to the demonstrator's posture; deal: the learner's start is dealt at random, by a seed;
    dealt: and what else is; carry: the id of the step whose start and path go on here; ask: what is asked, nothing for
    a step that only shows; told, after: what the reveal tells; say: the sentence that one should be able to say now."""

    id: str
    title: str
    text: str
    say: str
    settings: dict[str, Any] = {}
    scene: dict[str, Any] = {}
    chosen: int | None = None
    main: tuple[Figure, ...] = ()
    side: tuple[Figure, ...] = ()
    sliders: tuple[Slider, ...] = ()
    works: tuple[str, ...] = ()
    race: tuple[str, ...] = ()
    play: float | None = None
    meets: bool = False
    carry: str | None = None
    deal: bool = False
    dealt: tuple[Range, ...] = ()
    ask: Ask | None = None
    told: Said | None = None
    after: str = ""


class Lesson(msgspec.Struct, **FIELDS):
    """title, short: in the list of lessons, and over its steps; about: one sentence; minutes: that it takes; settings:
    fields of `Settings` by name, of all steps but for what each has of its own."""

    title: str
    short: str
    about: str
    minutes: int
    step: tuple[Step, ...]
    settings: dict[str, Any] = {}
    question: tuple[Question, ...] = ()
