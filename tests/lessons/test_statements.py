"""Every statement of every lesson is computed: a text without an entry fails, and so does a false one.

To add or change a text, give it an entry in `statements_of_*.py`: what it states, and how that follows from the state
that its step shows.
"""

import re

import pytest
import statements_of_failures
import statements_of_geometry
import statements_of_servoing
import statements_of_words
from statements import DEFINITION, REPORT, fact, sampled, state, step_named, texts
from viewimit.app.lab.lessons.facts import FACTS
from viewimit.app.lab.lessons.format import Choice, Number
from viewimit.app.lab.lessons.source import questions, shipped

MODULES = (statements_of_geometry, statements_of_failures, statements_of_servoing, statements_of_words)
STATEMENTS = {key: fields for module in MODULES for key, fields in module.STATEMENTS.items()}
TEXTS = {(key, field): text for key, field, text in texts()}
NAMES = re.compile(
    r"\*\*\w\*\*|\b(camera|picture|run|point|knob|Eqs?\.) \(?\*{0,2}\d\)?(\*{0,2} to \(\d\))?", re.IGNORECASE
)
CHECKS = [
    pytest.param(check, id=f"{key} {field}: {quote[:50]}")
    for key, fields in STATEMENTS.items()
    for field, entry in fields.items()
    if isinstance(entry, dict)
    for quote, check in entry.items()
]
CHOICES = [
    f"{name}/{step.id}" for name, lesson in shipped().items() for step in lesson.step if isinstance(step.ask, Choice)
] + [f"questions/{item.id}" for item in questions().item]
NUMBERS = [
    f"{name}/{step.id}"
    for name, lesson in shipped().items()
    for step in lesson.step
    if isinstance(step.ask, Number) and step.ask.truth in FACTS
]


def test_every_text_has_an_entry_and_every_entry_a_text():
    entries = {(key, field) for key, fields in STATEMENTS.items() for field in fields}
    missing = sorted(TEXTS.keys() - entries)
    assert not missing, f"texts without an entry: {missing}"
    assert not (gone := sorted(entries - TEXTS.keys())), f"entries without a text: {gone}"
    assert sum(len(module.STATEMENTS) for module in MODULES) == len(STATEMENTS)


@pytest.mark.parametrize(("key", "field"), sorted(TEXTS), ids=lambda part: part)
def test_an_entry_covers_its_text(key, field):
    """Numbers stand in quotes or braces, words in braces are not called definitions, and quotes are in the text."""
    text, entry = TEXTS[key, field], STATEMENTS[key][field]
    if field == "answers":
        assert callable(entry)
        return
    rest = text
    if isinstance(entry, dict):
        assert entry
        for quote in entry:
            assert quote in text, f"{quote!r} is no longer in {text!r}"
            rest = rest.replace(quote, "")
    else:
        assert entry in (DEFINITION, REPORT)
        assert (entry == REPORT) == ("{" in text)
    rest = NAMES.sub("", re.sub(r"\{[^}]*\}", "", rest))
    assert not re.search(r"\d", rest), f"no check of the number in {rest!r}"


@pytest.mark.parametrize("check", CHECKS)
def test_a_statement_is_true(check):
    assert check()


@pytest.mark.parametrize("key", CHOICES)
def test_the_right_answer_is_computed(key):
    """The entry of the answers says which one is right, from 0."""
    right = STATEMENTS[key]["answers"]()
    if key.startswith("questions/"):
        answers, measure = next(item for item in questions().item if item.id == key.split("/")[1]).answers, None
    else:
        answers, measure = step_named(key).ask.answers, step_named(key).ask.right
    if measure is None:
        assert [answer.right for answer in answers] == [k == right for k in range(len(answers))]
    elif measure in FACTS:
        assert fact(key, measure) == right + 1


@pytest.mark.parametrize("key", NUMBERS)
def test_a_number_that_is_asked_for_is_on_its_scale(key):
    ask = step_named(key).ask
    for situation in sampled(key) if step_named(key).randomise else [state(key)]:
        assert ask.low < float(FACTS[ask.truth].of(situation)) < ask.high
