"""What can be wrong in a lesson that types do not tell: names that are none, numbers that contradict each other, no
answer that is right."""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from viewimit.servo import SERVOS

from .dealing import HEAD, deal
from .figures import FIGURES
from .format import (
    CHANGEABLE,
    MOST_WORDS,
    Choice,
    Do,
    Figure,
    Lesson,
    Number,
    Place,
    Pose,
    Select,
    Slider,
    Step,
    settings_of,
)
from .measures import MEASURES, named_in
from .reading import WORDS_A_MINUTE, reading_minutes
from .works import WORKS

GUESSED = ("guess 1", "guess 2")
MOST_STEPS, MOST_SLIDERS, MOST_NUMBERS = 60, 3, 40
ID = re.compile(r"[a-z][a-z0-9-]{0,30}")
Faults = Iterator[tuple[str, str]]  # the field, as .step[2].ask, and what is wrong


def faults(lesson: Lesson) -> Faults:
    if not 1 <= len(lesson.step) <= MOST_STEPS:
        yield "", f"a lesson needs a [[step]], and at most {MOST_STEPS}; it has {len(lesson.step)}"
    for k, question in enumerate(lesson.question):
        if not len(question.answers) == len(question.answers_after) >= 2:
            yield f".question[{k}].answers_after", "needs as many answers as before, two or more"
    ids: set[str] = set()
    for k, step in enumerate(lesson.step):
        for where, what in _of_step(step, ids, {**lesson.settings, **step.settings}):
            yield f".step[{k}]{where}", what
        ids.add(step.id)
    least = round(reading_minutes(lesson))
    if lesson.minutes < least:
        yield ".minutes", f"to read it takes {least}, at {WORDS_A_MINUTE} words a minute"


def _of_step(step: Step, before: set[str], settings: dict[str, Any]) -> Faults:
    if not ID.fullmatch(step.id):
        yield ".id", f"{step.id[:40]!r} must be of small letters, digits and hyphens, a letter first"
    if step.id in before:
        yield ".id", f"{step.id!r} is another step's"
    words = len(re.sub(r"[*{}]", "", step.text).split())
    if words > MOST_WORDS:
        yield ".text", f"{words} words; at most {MOST_WORDS} are read"
    try:
        if settings_of(settings).sensor != "projected":
            yield ".settings.sensor", "lessons look at points, not at pictures"
    except ValueError as error:
        yield ".settings", str(error)
    for name in step.scene:
        yield from _of_names(f".scene.{name}", (name,), "field that a step can change", dict.fromkeys(CHANGEABLE))
    for place in ("main", "side"):
        for i, figure in enumerate(getattr(step, place)):
            for where, what in _of_figure(figure):
                yield f".{place}[{i}]{where}", what
    if step.carry is not None and step.carry not in before:
        yield ".carry", f"no step {step.carry!r} before this one"
    yield from _of_names(".works", step.works, "work", WORKS)
    yield from _of_names(".race", step.race, "servo", SERVOS)
    if step.race and not any("races" in FIGURES[figure.figure].works for figure in (*step.main, *step.side)):
        if "races" not in step.works:
            yield ".race", "is run for a figure that shows it, or if works has 'races'"
    if step.play is not None and step.play <= 0:
        yield ".play", "must be above 0"
    yield from _of_sliders(step.sliders)
    yield from _of_deal(step, settings)
    yield from _of_ask(step)
    if isinstance(step.ask, Select):
        yield from _of_select(step.ask, settings)
    for where, said in _said(step):
        if re.search(r"[{}]", re.sub(r"\{[^{}]*\}", "", said)):
            yield where, "has a brace without its other; what stands in braces is a measure"
        yield from _of_names(where, named_in(said), "measure", MEASURES)


def _of_figure(figure: Figure) -> Faults:
    if figure.figure not in FIGURES:
        yield ".figure", _unknown("figure", figure.figure, FIGURES)
        return
    layers = dict.fromkeys(FIGURES[figure.figure].layers)
    for name in ("show", "reveal", "hide"):
        yield from _of_names(f".{name}", getattr(figure, name), f"layer of {figure.figure}", layers)


def _of_sliders(sliders: tuple[Slider, ...]) -> Faults:
    if len(sliders) > MOST_SLIDERS:
        yield ".sliders", f"{len(sliders)} are more than the {MOST_SLIDERS} that there is room for"
    for k, slider in enumerate(sliders):
        at = f".sliders[{k}]"
        if not slider.low < slider.high:
            yield f"{at}.low", f"must be less than high, {slider.high:g}"
        elif not slider.low <= slider.start <= slider.high:
            yield f"{at}.start", f"must be from low to high, {slider.low:g} to {slider.high:g}"
        if slider.step <= 0:
            yield f"{at}.step", "must be above 0"
        if slider.logarithmic and slider.low <= 0:
            yield f"{at}.low", "must be above 0 on a logarithmic scale"
        if slider.name in [other.name for other in sliders[:k]]:
            yield f"{at}.name", f"{slider.name!r} is another slider's"


def _of_deal(step: Step, settings: dict[str, Any]) -> Faults:
    if step.dealt and not step.deal:
        yield ".dealt", "is dealt with the start only: add deal = true"
    for k, one in enumerate(step.dealt):
        if not (one.low <= one.high and one.step > 0):
            yield f".dealt[{k}].low", f"must be at most high, {one.high:g}, and step more than 0"
            return
        if one.name in HEAD:
            continue
        why = _unsettled({**settings, one.name: one.low}) or _unsettled({**settings, one.name: one.high})
        if why:
            yield f".dealt[{k}].name", f"{why}; of the head there are {', '.join(HEAD)}"
            return
    if step.dealt and not _unsettled(settings):
        try:
            deal(step.dealt, settings_of(settings), 1)
        except ValueError as error:
            yield ".dealt", str(error)


def _of_select(ask: Select, settings: dict[str, Any]) -> Faults:
    if not ask.fields:
        yield ".ask.fields", "needs a [[step.ask.fields]]"
    for k, field in enumerate(ask.fields):
        if len(field.values) < 2:
            yield f".ask.fields[{k}].values", f"two or more are needed, not {len(field.values)}"
        for value in field.values:
            why = _unsettled({**settings, field.name: value.value})
            if why:
                yield f".ask.fields[{k}]", why


def _unsettled(settings: dict[str, Any]) -> str:
    """What is wrong with settings; nothing for those that can be."""
    try:
        settings_of(settings)
    except ValueError as error:
        return str(error)
    return ""


def _of_ask(step: Step) -> Faults:
    ask = step.ask
    for name in ("truth", "measure", "right", "line"):
        measure = getattr(ask, name, None)
        if measure is not None:
            yield from _of_names(f".ask.{name}", (measure,), "measure", MEASURES)
    if isinstance(ask, Choice):
        yield from _of_choice(ask)
    elif isinstance(ask, Place):
        if ask.figure not in {figure.figure for figure in step.main}:
            yield ".ask.figure", f"{ask.figure!r} is none of the step's main figures"
        elif ask.figure in FIGURES and FIGURES[ask.figure].unplace is None:
            yield ".ask.figure", f"nothing can be marked in {ask.figure!r}"
        if (ask.line is None) != (ask.on_line is None):
            yield ".ask", "line and on_line need each other"
    elif isinstance(ask, Number):
        yield from _of_number(ask)
    elif isinstance(ask, Do) and (ask.below is None) == (ask.above is None):
        yield ".ask", "needs below or above, one of them"
    if isinstance(ask, Do) and not step.sliders:
        yield ".ask", "do needs sliders in its step"
    if isinstance(ask, Pose) and [slider.name for slider in step.sliders] != [*GUESSED]:
        yield ".sliders", f"a pose is of two joints: it needs the sliders {' and '.join(GUESSED)}"
    elif not isinstance(ask, Pose) and any(slider.name.startswith("guess ") for slider in step.sliders):
        yield ".sliders", "a see-through arm is turned where its posture is asked for, by ask with kind = 'pose'"
    if isinstance(ask, Place | Pose) and ask.near <= 0:
        yield ".ask.near", "must be above 0"


def _of_choice(ask: Choice) -> Faults:
    if not 2 <= len(ask.answers) <= 4:
        yield ".ask.answers", f"two to four are needed, not {len(ask.answers)}"
    right = sum(answer.right for answer in ask.answers)
    if ask.right is None and right != 1:
        yield ".ask.answers", f"one of them must have right = true, not {right}; or `right` is a measure that tells it"
    if ask.right is not None and right:
        yield ".ask.answers", "none may have right = true where `right` is a measure that tells it"


def _of_number(ask: Number) -> Faults:
    if not ask.low < ask.high:
        yield ".ask.low", f"must be less than high, {ask.high:g}"
    elif ask.logarithmic and ask.low <= 0:
        yield ".ask.low", "must be above 0 on a logarithmic scale"
    elif ask.step is not None and not 0 < (ask.high - ask.low) / MOST_NUMBERS <= ask.step:
        yield ".ask.step", f"must be so large that there are at most {MOST_NUMBERS} numbers"
    if (ask.factor is None) == (ask.within is None):
        yield ".ask", "needs factor or within, one of them"
    elif ask.factor is not None and ask.factor <= 1:
        yield ".ask.factor", "must be above 1"
    elif ask.within is not None and ask.within <= 0:
        yield ".ask.within", "must be above 0"


def _said(step: Step) -> Faults:
    """(field, words) in which measures may stand."""
    for name in ("text", "after", "say"):
        yield f".{name}", getattr(step, name)
    if step.told is not None:
        yield ".told.measure", f"{{{step.told.measure}}}"
        yield ".told.note", step.told.note
    if isinstance(step.ask, Choice):
        for k, answer in enumerate(step.ask.answers):
            yield f".ask.answers[{k}].because", answer.because
    for name in ("close", "far", "less", "on_line"):
        words = getattr(step.ask, name, None)
        if words:
            yield f".ask.{name}", words


def _of_names(where: str, names, what: str, known: Mapping[str, object]) -> Faults:
    for name in names:
        if name not in known:
            yield where, _unknown(what, name, known)


def _unknown(what: str, name: str, known: Mapping[str, object]) -> str:
    return f"no {what} {name[:40]!r}; there are {', '.join(known) or 'none'}"
