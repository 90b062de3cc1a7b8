"""What types do not check in a lesson: unknown names, numbers that contradict each other, questions without an answer.
Each check yields faults as (field, message), with the field as .step[2].ask."""

import re
from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from pathlib import Path

import msgspec

from viewimit.loop.settings import Settings
from viewimit.sensing.files import parse_toml
from viewimit.servo import SERVOS

from . import format as form
from .situation import Situation

HERE = Path(__file__).parent
GUESS_SLIDERS = ("guess 1", "guess 2")
KNOB_SLIDERS = ("knob 1", "knob 2")
MAX_NUMBERS = 40
WORDS_PER_MINUTE = 200
SECONDS_TO_ACT = 20  # of each round of a step: to look, to think, to click
ID = re.compile(r"[a-z][a-z0-9-]{0,30}")
Faults = Iterator[tuple[str, str]]


class FigureKind(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A figure that steps can name."""

    layers: tuple[str, ...]
    placeable: bool = False  # a click in it gives a place


@cache
def figure_kinds() -> Mapping[str, FigureKind]:
    """Return the figures of the lab by name."""
    table = parse_toml(HERE.joinpath("figures", "layers.toml").read_bytes())
    return msgspec.convert(table, dict[str, FigureKind])


@cache
def measure_table() -> Mapping[str, Mapping[str, str]]:
    """Return the units of all measures that steps can name, by where they are computed: "browser" or "library"."""
    return parse_toml(HERE.joinpath("measures.toml").read_bytes())


@cache
def measure_units() -> Mapping[str, str]:
    """Return the unit of each measure."""
    return {**measure_table()["browser"], **measure_table()["library"]}


def faults(lesson: form.Lesson) -> Faults:
    """Yield the faults of a lesson, without its scenes."""
    ids: set[str] = set()
    for k, step in enumerate(lesson.step):
        yield from _at(f".step[{k}]", _of_step(lesson, step, ids))
        ids.add(step.id)
    least = max(1, round(least_minutes(lesson)))
    if lesson.minutes < least:
        why = f"it takes {least}: {WORDS_PER_MINUTE} words a minute, and {SECONDS_TO_ACT} s for each step"
        yield ".minutes", why


def faults_in_scenes(lesson: form.Lesson) -> Faults:
    """Yield joints, points and settings that the scenes of a lesson do not have. This loads them."""
    for k, step in enumerate(lesson.step):
        yield from _at(f".step[{k}]", _of_scene(lesson, step))


def _at(place: str, found: Faults) -> Faults:
    return ((f"{place}{where}", what) for where, what in found)


def faults_of_questions(questions: form.Questions, lessons: Mapping[str, form.Lesson]) -> Faults:
    """Yield the faults of the eight questions."""
    for k, item in enumerate(questions.item):
        yield from _at(f".item[{k}]", _of_item(item, lessons))
    if len({item.id for item in questions.item}) < len(questions.item):
        yield ".item", "two questions have the same id"


def _of_item(item: form.Item, lessons: Mapping[str, form.Lesson]) -> Faults:
    right = sum(answer.right for answer in item.answers)
    if right != 1:
        yield ".answers", f"needs one right answer; it has {right}"
    for k, answer in enumerate(item.answers):
        if bool(answer.belief) == answer.right:
            yield f".answers[{k}].belief", "each wrong answer has the tag of its belief, the right one has none"
        yield from _known(f".answers[{k}].because", form.measures_in(answer.because), "measure", measure_units())
    name, _, step = item.step.partition("/")
    yield from _known(".step", (name,), "lesson", lessons)
    if name in lessons:
        yield from _known(".step", (step,), f"step of {name}", [one.id for one in lessons[name].step])


def least_minutes(lesson: form.Lesson) -> float:
    """Return the time in which a fast reader can take a lesson: reading, and acting on each step."""
    words = sum(len(text.split()) for step in lesson.step for text in _read(step))
    rounds = sum(getattr(step.ask, "times", 1) for step in lesson.step)
    return words / WORDS_PER_MINUTE + rounds * SECONDS_TO_ACT / 60


def _read(step: form.Step) -> Iterator[str]:
    """The texts that a reader reads; of the replies to a question, the longest."""
    ask = step.ask
    yield from (step.title, step.text, step.after, step.say, ask.question, *(slider.label for slider in step.sliders))
    if step.headline is not None:
        yield from (step.headline.label, step.headline.note)
    replies: list[str] = []
    if isinstance(ask, form.Choice):
        yield from (answer.text for answer in ask.answers)
        replies = [answer.because for answer in ask.answers]
    elif isinstance(ask, form.Place | form.Number | form.Pose):
        replies = [ask.close, ask.far]
    yield max(replies, key=lambda text: len(text.split()), default="")


def _of_step(lesson: form.Lesson, step: form.Step, before: set[str]) -> Faults:
    if not ID.fullmatch(step.id):
        yield ".id", f"{step.id[:40]!r} must be of small letters, digits and hyphens, a letter first"
    if step.id in before:
        yield ".id", f"another step is called {step.id!r}"
    words = len(re.sub(r"[*{}]", "", step.text).split())
    if words > form.MAX_WORDS:
        yield ".text", f"{words} words; at most {form.MAX_WORDS} are read"
    try:
        if form.settings_of(lesson, step).sensor != "projected":
            yield ".settings.sensor", "lessons are about image points: it must be 'projected'"
    except ValueError as error:
        yield ".settings", str(error)
        return
    yield from _known(".scene", step.scene, "field that a step can change", form.SCENE_FIELDS)
    if not step.main:
        yield ".main", "a step needs a figure to look at"
    for place, figures in (("main", step.main), ("side", step.side)):
        for i, figure in enumerate(figures):
            yield from _at(f".{place}[{i}]", _of_figure(figure))
    if step.carry is not None and step.carry not in before:
        yield ".carry", f"no step {step.carry!r} before this one; there are {', '.join(sorted(before)) or 'none'}"
    yield from _known(".race", step.race, "servo", SERVOS)
    yield from _of_sliders(step.sliders)
    yield from _of_ask(step)
    for where, said in form.texts_with_measures(step):
        if re.search(r"[{}]", re.sub(r"\{[^{}]*\}", "", said)):
            yield where, "has a brace without its partner; a measure stands in braces"
    for name, where in form.measures_of(step).items():
        yield from _known(where, (name,), "measure", measure_units())


def _of_figure(figure: form.Figure) -> Faults:
    yield from _known(".figure", (figure.figure,), "figure", figure_kinds())
    if (kind := figure_kinds().get(figure.figure)) is not None:
        for name in ("show", "reveal", "hide"):
            yield from _known(f".{name}", getattr(figure, name), f"layer of {figure.figure}", kind.layers)


def _of_sliders(sliders: tuple[form.Slider, ...]) -> Faults:
    for k, slider in enumerate(sliders):
        at = f".sliders[{k}]"
        if not slider.low < slider.high:
            yield f"{at}.low", f"must be less than high, {slider.high:g}"
        elif not slider.low <= slider.start <= slider.high:
            yield f"{at}.start", f"must be from low to high, {slider.low:g} to {slider.high:g}"
        if slider.logarithmic and slider.low <= 0:
            yield f"{at}.low", "must be above 0 on a logarithmic scale"
        if slider.name in [other.name for other in sliders[:k]]:
            yield f"{at}.name", f"another slider is called {slider.name!r}"


def _of_ask(step: form.Step) -> Faults:
    ask = step.ask
    names = tuple(slider.name for slider in step.sliders)
    if isinstance(ask, form.Choice):
        right = sum(answer.right for answer in ask.answers)
        if ask.right is None and right != 1:
            yield ".ask.answers", f"one of them must have right = true, not {right}; or `right` names a measure"
        elif ask.right is not None and right:
            yield ".ask.answers", "none may have right = true where `right` names a measure"
    elif isinstance(ask, form.Place):
        yield from _of_asking_figure(step, ask.figure)
        if (ask.line is None) != (ask.on_line is None):
            yield ".ask", "line and on_line need each other"
    elif isinstance(ask, form.Number):
        yield from _of_number(ask)
    elif isinstance(ask, form.Do):
        if (ask.below is None) == (ask.above is None):
            yield ".ask", "needs below or above, one of them"
        if not step.sliders:
            yield ".ask", "do needs sliders in its step"
    elif isinstance(ask, form.Predict):
        yield from _of_asking_figure(step, ask.figure)
        if names != KNOB_SLIDERS:
            yield ".sliders", f"predict turns two knobs: it needs the sliders {' and '.join(KNOB_SLIDERS)}"
    elif isinstance(ask, form.Pose) and names != GUESS_SLIDERS:
        yield ".sliders", f"a pose has two joints: it needs the sliders {' and '.join(GUESS_SLIDERS)}"
    if not isinstance(ask, form.Pose) and any(name.startswith("guess ") for name in names):
        yield ".sliders", "the ghost arm is turned where its posture is asked for, with kind = 'pose'"


def _of_asking_figure(step: form.Step, name: str) -> Faults:
    main = [figure.figure for figure in step.main]
    if name not in main:
        yield ".ask.figure", f"{name!r} is none of the step's main figures, {', '.join(main)}"
    elif name in figure_kinds() and not figure_kinds()[name].placeable:
        able = [figure for figure, kind in figure_kinds().items() if kind.placeable]
        yield ".ask.figure", f"nothing can be marked in {name!r}, only in {', '.join(able)}"


def _of_number(ask: form.Number) -> Faults:
    if not ask.low < ask.high:
        yield ".ask.low", f"must be less than high, {ask.high:g}"
    elif ask.logarithmic and ask.low <= 0:
        yield ".ask.low", "must be above 0 on a logarithmic scale"
    elif ask.step is not None and not 0 < (ask.high - ask.low) / MAX_NUMBERS <= ask.step:
        yield ".ask.step", f"must be so large that there are at most {MAX_NUMBERS} numbers"
    if (ask.factor is None) == (ask.within is None):
        yield ".ask", "needs factor or within, one of them"


def _of_scene(lesson: form.Lesson, step: form.Step) -> Faults:
    situation = Situation(form.settings_of(lesson, step), step.scene)
    try:
        joints, points = len(situation.start.theta), len(situation.world.body)
    except (ValueError, OSError) as error:
        yield ".scene" if step.scene else ".settings", str(error)
        return
    if joints != 2:
        yield ".settings", f"the lab shows arms with two moving joints, not {joints}"
    if step.chosen is not None and not 0 <= step.chosen < points:
        yield ".chosen", f"no point {step.chosen}; there are {points}, counted from 0"
    for k, slider in enumerate(step.sliders):
        kind, _, number = slider.name.partition(" ")
        if kind in ("own", "demo", "guess") and number.isdigit() and not 1 <= int(number) <= joints:
            yield f".sliders[{k}].name", f"no joint {number} among those that move; there are {joints}, from 1"
        if slider.name in Settings.__struct_fields__:
            for end in (slider.low, slider.high):
                try:
                    form.settings_of(lesson, step, **{slider.name: end})
                except ValueError as error:
                    yield f".sliders[{k}]", str(error)


def _known(where: str, names: Iterable[str], what: str, known: Iterable[str]) -> Faults:
    for name in names:
        if name not in known:
            yield where, f"no {what} {name[:60]!r}; there are {', '.join(known) or 'none'}"
