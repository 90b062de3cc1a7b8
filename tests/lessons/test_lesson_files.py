"""A lesson file: each fault is named with file, line and field, and with the names that exist; shipped ones have none,
and the example of the documentation is one."""

import re
from pathlib import Path

import pytest
from viewimit.app.lab.lessons import checks, source

from viewimit.commands.cli import main

LESSON = """title = "One"
short = "One"
about = "About."
minutes = 1

[[step]]
id = "first"
title = "First"
text = "A text with **bold** words."
say = "E is {E}."
chosen = 2
main = [{ figure = "L", show = ["own points"], reveal = ["arrows"] }]
[step.ask]
kind = "choice"
question = "Which?"
[[step.ask.answers]]
text = "This"
because = "It is this one."
right = true
[[step.ask.answers]]
text = "That"
because = "It is not that one."
"""
SLIDERS = 'sliders = [{ name = "own 1", label = "Shoulder", low = 0, high = 90, start = 20 }]\nchosen = 2'
PLACE = (
    'kind = "place"\nquestion = "Where?"\nfigure = "L"\ntruth = "recovered in L"\nnear = 5\nclose = "a"\nfar = "b"\n'
)
NUMBER = 'kind = "number"\nquestion = "How far?"\nunit = "°"\nlow = 1\nhigh = 9\ntruth = "E"\nclose = "a"\nfar = "b"\n'

PREDICT = 'kind = "predict"\nquestion = "?"\nfigure = "L"\nmeasure = "E"\nbelow = 2\n'


def ask(text: str) -> str:
    return LESSON.partition("[step.ask]\n")[0] + f"[step.ask]\n{text}"


FAULTS = {  # a file, the line, the field, a part of what is said
    "no figure": (LESSON.replace('"L", show', '"M", show'), 12, "step[0].main[0].figure", "there are 1, 2, l, r, L"),
    "no layer": (LESSON.replace('["arrows"]', '["arows"]'), 12, "step[0].main[0].reveal", "there are own points"),
    "nothing to look at": (LESSON.replace("main = [", "side = ["), 6, "step[0].main", "needs a figure"),
    "no measure": (LESSON.replace("{E}", "{F}"), 10, "step[0].say", "no measure 'F'; there are "),
    "no partner": (LESSON.replace("{E}", "{E"), 10, "step[0].say", "brace without its partner"),
    "no setting": (LESSON.replace("chosen = 2", "settings = { noise = 1 }"), 11, "step[0].settings", "noise"),
    "no such field": (LESSON.replace("chosen = 2", "chosn = 2"), 6, "step[0]", "`chosn`; there are id, title, text"),
    "no field of a lesson": (LESSON.replace("about =", "abut ="), 1, "", "`abut`; there are title, short, about"),
    "a type": (LESSON.replace("minutes = 1", 'minutes = "1"'), 4, "minutes", "Expected `int`, got `str`"),
    "no time to read": (LESSON.replace("minutes = 1", "minutes = 0"), 4, "minutes", "it takes 1"),
    "no number": (LESSON.replace("chosen = 2", "play = inf"), 11, "step[0].play", "must be a finite number"),
    "an id": (LESSON.replace('id = "first"', 'id = "1st"'), 7, "step[0].id", "small letters"),
    "too long": (LESSON.replace("A text", "word " * 60), 9, "step[0].text", "at most 60 are read"),
    "carry": (LESSON.replace("chosen = 2", 'carry = "none"'), 11, "step[0].carry", "no step 'none' before this one"),
    "race": (LESSON.replace("chosen = 2", 'race = ["fast"]'), 11, "step[0].race", "no servo 'fast'; there are "),
    "scene": (LESSON.replace("chosen = 2", "scene = { title = 'x' }"), 11, "step[0].scene", "there are head, demo"),
    "two right": (LESSON.replace('not that one."', 'not that one."\nright = true'), 16, "step[0].ask.answers", "not 2"),
    "no kind": (LESSON.replace('"choice"', '"chose"'), 14, "step[0].ask.kind", "there are choice, place, number"),
    "not in a main figure": (
        ask(PLACE.replace('"L"', '"R"')), 16, "step[0].ask.figure", "none of the step's main figures, L"
    ),
    "no measure of a place": (ask(PLACE.replace("recovered in", "in")), 17, "step[0].ask.truth", "no measure 'in L'"),
    "near nothing": (ask(PLACE.replace("near = 5", "near = 0")), 18, "step[0].ask.near", "`float` > 0"),
    "a line alone": (ask(PLACE + 'line = "E"\n'), 13, "step[0].ask", "line and on_line need each other"),
    "elsewhere": (
        ask(PLACE + '[[step.ask.elsewhere]]\ntruth = "x"\nnear = 1\nbecause = "c"\n'),
        22, "step[0].ask.elsewhere[0].truth", "no measure 'x'",
    ),
    "no closeness": (ask(NUMBER), 13, "step[0].ask", "needs factor or within"),
    "upside down": (ask(NUMBER + "factor = 2\n").replace("low = 1", "low = 10"), 17, "step[0].ask.low", "than high"),
    "nothing to do it with": (
        ask('kind = "do"\nquestion = "Do it."\nmeasure = "E"\nbelow = 3\n'), 13, "step[0].ask", "do needs sliders"
    ),
    "no ghost arm": (
        ask('kind = "pose"\nquestion = "?"\ntruth = "the demonstrator\'s posture"\nnear = 8\nclose = "a"\nfar = "b"\n'),
        6, "step[0].sliders", "guess 1 and guess 2",
    ),
    "no knobs": (
        ask(PREDICT).replace("chosen = 2", SLIDERS),
        11, "step[0].sliders", "knob 1 and knob 2",
    ),
    "too many bets": (
        ask('kind = "bet"\nquestion = "?"\ntruth = "within 1°"\ntimes = 99\n'), 17, "step[0].ask.times", "`int` <= 20"
    ),
    "a slider": (
        LESSON.replace("chosen = 2", SLIDERS).replace("start = 20", "start = 99"),
        11, "step[0].sliders[0].start", "must be from low to high, 0 to 90",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", [name for name in FAULTS if FAULTS[name][1]])
def test_a_fault_is_named_with_its_line_and_field(name, tmp_path):
    text, line, field, said = FAULTS[name]
    path = tmp_path / "mine.toml"
    path.write_text(text, "utf-8")
    with pytest.raises(ValueError) as caught:
        source.load(path)
    what = str(caught.value)
    assert what.startswith(f"{path}, line {line}: {field}{': ' if field else ''}"), what
    assert said in what, what


@pytest.mark.parametrize(
    ("changed", "field", "said"),
    [
        (LESSON.replace("chosen = 2", "chosen = 10"), "step[0].chosen", "no point 10; there are 10, counted from 0"),
        (LESSON.replace("chosen = 2", SLIDERS.replace("own 1", "own 3")), "step[0].sliders[0].name", "no joint 3"),
        (LESSON.replace("chosen = 2", 'settings = { scene = "nowhere" }'), "step[0].settings", "nowhere"),
    ],
)
def test_what_a_scene_does_not_have_is_named_before_anybody_is_taught(changed, field, said, tmp_path, capsys):
    path = tmp_path / "mine.toml"
    path.write_text(changed, "utf-8")
    assert main(["lab", "--lesson", str(path), "--out", str(tmp_path / "mine.html")]) == 2
    told = capsys.readouterr().err
    assert told.startswith(f"viewimit lab: --lesson: {path}, line 11: {field}: ") and said in told


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"title = ", "mine.toml: "),
        (b'title = "One"\nshort = "\xff"', "line 2: is not in UTF-8"),
        (b"a" * 200_001, "is larger than 200 kB"),
        (b"a = " + b"[" * 20_000, "mine.toml"),
    ],
)
def test_a_file_that_is_no_lesson_is_refused(data, said, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_bytes(data)
    with pytest.raises(ValueError, match="mine.toml") as caught:
        source.load(path)
    assert said in str(caught.value)


@pytest.mark.parametrize("name", source.shipped())
def test_a_shipped_lesson_has_no_fault_in_its_scenes_either(name):
    assert not list(checks.faults_in_scenes(source.shipped()[name]))


def test_the_example_of_the_documentation_is_a_lesson_and_its_fault_is_named_as_the_page_shows_it(tmp_path):
    documented = (Path(__file__).parents[2] / "docs" / "teach" / "lesson-format.md").read_text("utf-8")
    (example,) = re.findall(r"```toml\n(.*?)```", documented, re.S)
    path = tmp_path / "mine.toml"
    path.write_text(example, "utf-8")
    assert source.load(path, tried=True).step[0].id == "whose"
    path.write_text(example.replace('["own points"]', '["owned"]'), "utf-8")
    with pytest.raises(ValueError) as caught:
        source.load(path)
    shown = "mine.toml, line 10: step[0].main[0].show: no layer of L 'owned'; there are own points"
    assert shown in str(caught.value) and shown in documented
