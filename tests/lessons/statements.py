"""What each text of the lessons states, and how to check it.

A text of a step is a `DEFINITION` (it names, instructs or explains; no number, order or sign in it could be false), a
`REPORT` (it only reads out measures), or a table of quotes and checks. Digits stand in quotes only. A check is a
function that returns whether the quoted statement is true, computed from the state that the step shows.
"""

from collections.abc import Callable, Iterator, Mapping
from functools import cache

from viewimit.app.lab.lessons import facts, sign, step_data
from viewimit.app.lab.lessons.format import Bet, Choice, Item, Place, Select, Step
from viewimit.app.lab.lessons.situation import Situation
from viewimit.app.lab.lessons.source import questions, shipped

from viewimit.drawing.glossary import glossary

DEFINITION, REPORT = "definition", "report"
Check = Callable[[], object]
Entry = str | Mapping[str, Check] | Check
Statements = Mapping[str, Mapping[str, Entry]]


def step_named(key: str) -> Step:
    """The step of "lesson/step"."""
    lesson, step_id = key.split("/")
    return next(step for step in shipped()[lesson].step if step.id == step_id)


@cache
def state(key: str) -> Situation:
    """The fixed state of "lesson/step"."""
    return step_data.situation_of(shipped()[key.split("/")[0]], step_named(key))


@cache
def sampled(key: str) -> list[Situation]:
    """The sampled states of "lesson/step", as the page has them."""
    lesson, step = shipped()[key.split("/")[0]], step_named(key)
    origin = step if step.carry is None else next(other for other in lesson.step if other.id == step.carry)
    count = step_data.SCENE_SAMPLES if origin.randomised else step_data.SAMPLES
    return facts.sample_states(state(key), count, step_data.SAMPLE_SEED)


def fact(key: str, name: str) -> float:
    """A fact of the fixed state of "lesson/step"."""
    return float(facts.FACTS[name].of(state(key)))


def texts() -> Iterator[tuple[str, str, str]]:
    """Yield (key, field, text) of all lessons, the eight questions, the ten runs and the glossary."""
    for name, lesson in shipped().items():
        yield name, "about", lesson.about
        for step in lesson.step:
            for field, text in _texts_of(step):
                yield f"{name}/{step.id}", field, text
    for item in questions().item:
        for field, text in _texts_of_item(item):
            yield f"questions/{item.id}", field, text
    for k, run in enumerate(sign.signed_runs()):
        yield f"runs/{k + 1}", "name", run.name
        yield f"runs/{k + 1}", "because", run.because
    for word, entry in glossary().items():
        for field in ("sentence", "good", "bad"):
            if getattr(entry, field):
                yield f"glossary/{word}", field, getattr(entry, field)


def _texts_of(step: Step) -> Iterator[tuple[str, str]]:
    """All but names of things: labels of sliders, fields, values and headline numbers."""
    for field in ("title", "text", "after", "say"):
        if getattr(step, field):
            yield field, getattr(step, field)
    if step.headline is not None and step.headline.note:
        yield "note", step.headline.note
    ask = step.ask
    yield "question", ask.question
    for field in ("close", "far", "less", "on_line"):
        if getattr(ask, field, None):
            yield field, getattr(ask, field)
    if isinstance(ask, Choice):
        yield "answers", " / ".join(answer.text for answer in ask.answers)
        for k, answer in enumerate(ask.answers):
            yield f"because {k + 1}", answer.because
    if isinstance(ask, Place):
        for k, other in enumerate(ask.elsewhere):
            yield f"elsewhere {k + 1}", other.because
    if isinstance(ask, Select):
        for one in ask.fields:
            for value in one.values:
                yield f"says {value.value}", value.says
        yield "reason", ask.reason
        for k, reason in enumerate(ask.reasons):
            yield f"reason {k + 1}", reason.text
            yield f"because {k + 1}", reason.because
    assert isinstance(ask, Bet) or step.say


def _texts_of_item(item: Item) -> Iterator[tuple[str, str]]:
    yield "text", item.text
    yield "answers", " / ".join(answer.text for answer in item.answers)
    for k, answer in enumerate(item.answers):
        yield f"because {k + 1}", answer.because
