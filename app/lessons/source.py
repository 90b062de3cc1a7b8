"""Lessons from their files: the shipped ones in their order, or a lecturer's own.

Each is checked whole, so that a fault is told by file, line and field before anybody is taught.
"""

import re
from functools import cache
from pathlib import Path

import msgspec
import numpy as np
from viewimit.assets import ROOT

from viewimit.servo import SERVOS
from viewimit.settings import Settings

from .dealing import HEAD, deal
from .figures import FIGURES
from .format import MOST_WORDS, Choice, Do, Lesson, Number, Place, Pose, Select, Step
from .measures import MEASURES, named_in
from .works import WORKS

FOLDER = ROOT / "lessons"
_HEAD = re.compile(r"^\s*\[+\s*([^\]]+?)\s*\]+\s*(#.*)?$")
_PATH = re.compile(r"\.?([A-Za-z_]\w*)|\[(\d+)\]")


@cache
def shipped() -> dict[str, Lesson]:
    """By the names of their files, in order."""
    return {path.stem.split("-", 1)[1]: load(path) for path in sorted(FOLDER.glob("*.toml"))}


def load(path: Path) -> Lesson:
    """Raises ValueError that names file, line and field; OSError for a file that cannot be read."""
    text = path.read_text("utf-8")
    try:
        fields = msgspec.toml.decode(text.encode())
    except msgspec.DecodeError as error:
        raise ValueError(f"{path}: {error}") from None
    try:
        lesson = msgspec.convert(fields, Lesson)
    except msgspec.ValidationError as error:
        what, _, where = str(error).partition(" - at `$")
        raise ValueError(_located(path, text, where.rstrip("`"), what)) from None
    for where, what in _faults(lesson):
        raise ValueError(_located(path, text, where, what))
    return lesson


def _located(path: Path, text: str, where: str, what: str) -> str:
    line, field = line_of(text, where), where.lstrip(".")
    return f"{path}, line {line}: {field + ': ' if field else ''}{what}"


def line_of(text: str, where: str) -> int:
    """The line, from 1, of a field such as .step[2].ask.kind, or of the nearest table that it is missing in."""
    keys = [name or int(number) for name, number in _PATH.findall(where)]
    best, depth = 1, 0
    counts: dict[tuple, int] = {}
    here: list = []
    for k, line in enumerate(text.splitlines(), 1):
        head = _HEAD.match(line)
        if head:
            here = _table(head[1], line.lstrip().startswith("[["), counts)
            found = here
        elif re.match(r"^\s*[A-Za-z_][\w-]*\s*=", line):
            found = [*here, line.split("=", 1)[0].strip()]
        else:
            continue
        same = next((i for i, (a, b) in enumerate(zip(found, keys)) if a != b), min(len(found), len(keys)))
        if same == len(found) and same > depth:
            best, depth = k, same
    return best


def _table(name: str, is_array: bool, counts: dict[tuple, int]) -> list:
    """Keys of a table's head, arrays of tables counted."""
    keys: list = []
    parts = [part.strip().strip('"') for part in name.split(".")]
    for i, part in enumerate(parts):
        keys.append(part)
        if is_array and i == len(parts) - 1:
            counts[tuple(keys)] = counts.get(tuple(keys), -1) + 1
        if tuple(keys) in counts:
            keys.append(counts[tuple(keys)])
    return keys


def _faults(lesson: Lesson):
    """(field, what is wrong) of what types cannot tell."""
    ids: set[str] = set()
    if not lesson.step:
        yield "", "a lesson needs a [[step]]"
    for k, question in enumerate(lesson.question):
        if not len(question.answers) == len(question.answers_after) >= 2:
            yield f".question[{k}].answers_after", "needs as many answers as before, two or more"
    for k, step in enumerate(lesson.step):
        at = f".step[{k}]"
        for where, what in _faults_of_step(step, ids, {**lesson.settings, **step.settings}):
            yield at + where, what
        ids.add(step.id)


def _faults_of_step(step: Step, before: set[str], settings: dict):
    if step.id in before:
        yield ".id", f"{step.id!r} is another step's"
    words = len(re.sub(r"[*{}]", "", step.text).split())
    if words > MOST_WORDS:
        yield ".text", f"{words} words; at most {MOST_WORDS} are read"
    fault = _unsettled(settings)
    if fault:
        yield ".settings", fault
        return
    for place in ("main", "side"):
        for i, figure in enumerate(getattr(step, place)):
            if figure.figure not in FIGURES:
                yield f".{place}[{i}].figure", f"no figure {figure.figure!r}; there are {', '.join(FIGURES)}"
                continue
            layers = FIGURES[figure.figure].layers
            for name in ("show", "reveal", "hide"):
                unknown = set(getattr(figure, name)) - set(layers)
                if unknown:
                    yield f".{place}[{i}].{name}", f"no layer {min(unknown)!r}; there are {', '.join(layers)}"
    if step.carry is not None and step.carry not in before:
        yield ".carry", f"no step {step.carry!r} before this one"
    for work in step.works:
        if work not in WORKS:
            yield ".works", f"no work {work!r}; there are {', '.join(WORKS)}"
    for servo in step.race:
        if servo not in SERVOS:
            yield ".race", f"no servo {servo!r}; there are {', '.join(SERVOS)}"
    for name, said in (("say", step.say), ("after", step.after), ("text", step.text)):
        for measure in named_in(said):
            if measure not in MEASURES:
                yield f".{name}", f"no measure {measure!r}; there are {', '.join(MEASURES)}"
    if step.told is not None:
        for measure in (step.told.measure, *named_in(step.told.note)):
            if measure not in MEASURES:
                yield ".told", f"no measure {measure!r}; there are {', '.join(MEASURES)}"
    for slider in step.sliders:
        if not slider.low <= slider.start <= slider.high:
            yield ".sliders", f"{slider.name}: start must be from low to high"
    yield from _faults_of_deal(step, settings)
    yield from _faults_of_ask(step, settings)


def _faults_of_deal(step: Step, settings: dict):
    if step.dealt and not step.deal:
        yield ".dealt", "is dealt with the start only: add deal = true"
    for i, one in enumerate(step.dealt):
        if not (one.low <= one.high and one.step > 0):
            yield f".dealt[{i}].low", f"must be at most high, {one.high:g}, and step more than 0"
            return
        if one.name in HEAD:
            continue
        fault = _unsettled({**settings, one.name: one.low}) or _unsettled({**settings, one.name: one.high})
        if fault:
            yield f".dealt[{i}].name", f"{fault}; of the head there are {', '.join(HEAD)}"
            return
    if step.dealt:
        try:
            deal(step.dealt, msgspec.convert(settings, Settings), 1)
        except ValueError as error:
            yield ".dealt", str(error)


def _unsettled(settings: dict) -> str:
    """What is wrong with settings; nothing for those that can be."""
    try:
        msgspec.convert(settings, Settings)
    except (msgspec.ValidationError, ValueError) as error:
        return str(error)
    return ""


def _faults_of_ask(step: Step, settings: dict):
    ask = step.ask
    if isinstance(ask, Select):
        if not ask.fields:
            yield ".ask.fields", "needs a [[step.ask.fields]]"
        for i, field in enumerate(ask.fields):
            if len(field.values) < 2:
                yield f".ask.fields[{i}].values", f"two or more are needed, not {len(field.values)}"
            for value in field.values:
                fault = _unsettled({**settings, field.name: value.value})
                if fault:
                    yield f".ask.fields[{i}]", fault
    if isinstance(ask, Choice):
        if not 2 <= len(ask.answers) <= 4:
            yield ".ask.answers", f"two to four are needed, not {len(ask.answers)}"
        right = sum(answer.right for answer in ask.answers)
        if (ask.right is None) != (right == 1):
            yield ".ask.answers", "one of them must be right = true, or `right` a measure that tells which"
    known = [getattr(ask, name) for name in ("truth", "measure", "right", "line") if getattr(ask, name, None)]
    for measure in known:
        if measure not in MEASURES:
            yield ".ask", f"no measure {measure!r}; there are {', '.join(MEASURES)}"
    if isinstance(ask, Place) and ask.figure not in {figure.figure for figure in step.main}:
        yield ".ask.figure", f"{ask.figure!r} is none of the step's main figures"
    if isinstance(ask, Do) and (ask.below is None) == (ask.above is None):
        yield ".ask", "needs below or above"
    if isinstance(ask, Number) and not ask.low < ask.high:
        yield ".ask.low", f"must be less than high, {ask.high:g}"
    if isinstance(ask, Number) and (ask.factor is None) == (ask.within is None):
        yield ".ask", "needs factor or within"
    if isinstance(ask, Pose) and not np.isfinite(ask.near):
        yield ".ask.near", "must be a number of degrees"
