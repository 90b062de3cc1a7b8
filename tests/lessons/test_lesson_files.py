"""A lesson's file: what is wrong in it is said by file, line and field before anybody is taught, and nothing that it
may hold does harm."""

import os
import re

import pytest
from viewimit.app.lessons.figures import FIGURES
from viewimit.app.lessons.source import MOST_BYTES, load, own, shipped
from viewimit.app.lessons.step_session import StepSession
from viewimit.app.lessons.trial import faults_in_session

from viewimit.loop.settings import Settings
from viewimit.loop.simulated_robot import complete

GOOD = """\
title = "Mine"
short = "Mine"
about = "A lesson of one step."
minutes = 1

[[step]]
id = "where"
title = "Where"
text = "Two arms stand before one pair of eyes."
say = "E is {E}."
main = [{ figure = "L", show = ["own points"] }]
chosen = 8
sliders = [{ name = "own 1", label = "Shoulder", low = 0, high = 90, start = 25 }]
"""
CHOICE = """\
[step.ask]
kind = "choice"
question = "Which?"
answers = [
  { text = "this", because = "yes", right = true },
  { text = "that", because = "no" },
]
"""
PLACE = """\
[step.ask]
kind = "place"
question = "Where?"
figure = "L"
truth = "recovered in L"
near = 12
close = "near"
far = "far"
"""
NUMBER = """\
[step.ask]
kind = "number"
question = "How many?"
unit = " px"
low = 1
high = 10
truth = "E"
within = 1
close = "near"
far = "far"
"""
DO = """\
[step.ask]
kind = "do"
question = "Bring E down."
measure = "E"
below = 3
"""


def changed(text: str, old: str, new: str) -> str:
    assert text.count(old) == 1
    return text.replace(old, new)


def step(old: str, new: str) -> str:
    return changed(GOOD, old, new)


SIXTY = " ".join(["word"] * 61)
FAULTS = {  # a file, the line, the field as it is named, and what is said of it
    "unknown field": (step('id = "where"', 'id = "where"\ncolour = "red"'), 6, "step[0]", "`colour`"),
    "wrong type": (step("minutes = 1", 'minutes = "one"'), 4, "minutes", "`int`"),
    "missing field": (step('title = "Where"\n', ""), 6, "step[0]", "`title`"),
    "infinite": (step("start = 25", "start = inf"), 13, "step[0].sliders[0].start", "finite"),
    "no number": (GOOD + changed(PLACE, "near = 12", "near = nan"), 19, "step[0].ask.near", "finite"),
    "unknown figure": (step('"L"', '"M"'), 11, "step[0].main[0].figure", "no figure 'M'; there are l, "),
    "unknown layer": (step('"own points"', '"owned"'), 11, "step[0].main[0].show", "no layer of L 'owned'; there are"),
    "unknown measure": (step("{E}", "{F}"), 10, "step[0].say", "no measure 'F'; there are"),
    "half a brace": (step("{E}", "{E"), 10, "step[0].say", "brace"),
    "unknown work": (GOOD + 'works = ["dig"]\n', 14, "step[0].works", "no work 'dig'; there are"),
    "unknown servo": (GOOD + 'race = ["snail"]\n', 14, "step[0].race", "no servo 'snail'; there are gradient"),
    "unseen race": (GOOD + 'race = ["broyden"]\n', 14, "step[0].race", "for a figure that shows it"),
    "unknown step": (GOOD + 'carry = "first"\n', 14, "step[0].carry", "no step 'first' before this one"),
    "itself": (GOOD + 'carry = "where"\n', 14, "step[0].carry", "no step 'where' before this one"),
    "unknown setting": (GOOD + "settings = { speed = 3 }\n", 14, "step[0].settings", "`speed`"),
    "setting out of bounds": (GOOD + "settings = { noise_px = -1.0 }\n", 14, "step[0].settings", "noise_px"),
    "pictures": (GOOD + 'settings = { sensor = "rendered" }\n', 14, "step[0].settings.sensor", "points"),
    "unknown scene": (GOOD + 'settings = { scene = "moon" }\n', 14, "step[0].settings", "moon"),
    "posture of another arm": (GOOD + "settings = { start_deg = [1, 2, 3] }\n", 14, "step[0].settings", "2 angles"),
    "unknown point": (step("chosen = 8", "chosen = 80"), 12, "step[0].chosen", "no point 80; there are 10"),
    "unknown joint": (step('"own 1"', '"own 3"'), 13, "step[0].sliders[0].name", "no joint 3"),
    "slider of a setting": (step('"own 1"', '"noise_px"'), 13, "step[0].sliders[0]", "noise_px"),
    "slider upside down": (step("high = 90", "high = -90"), 13, "step[0].sliders[0].low", "less than high"),
    "slider off its scale": (step("start = 25", "start = 95"), 13, "step[0].sliders[0].start", "from low to high"),
    "slider without zero": (
        step("start = 25", "start = 25, logarithmic = true"), 13, "step[0].sliders[0].low", "above 0",
    ),
    "two right": (GOOD + changed(CHOICE, '"no"', '"no", right = true'), 17, "step[0].ask.answers", "not 2"),
    "none right": (GOOD + changed(CHOICE, ", right = true", ""), 17, "step[0].ask.answers", "not 0"),
    "right twice told": (GOOD + CHOICE + 'right = "E"\n', 17, "step[0].ask.answers", "none may have"),
    "right by no measure": (
        GOOD + changed(CHOICE, ", right = true", "") + 'right = "G"\n', 21, "step[0].ask.right", "no measure 'G'",
    ),
    "one answer": (GOOD + re.sub(r"  \{ text = \"that.*\n", "", CHOICE), 17, "step[0].ask.answers", "two to four"),
    "unknown kind": (GOOD + changed(CHOICE, '"choice"', '"riddle"'), 15, "step[0].ask.kind", "'riddle'"),
    "missing in a choice": (GOOD + changed(CHOICE, ', because = "no"', ""), 17, "step[0].ask.answers[1]", "`because`"),
    "missing in a place": (GOOD + changed(PLACE, "near = 12\n", ""), 14, "step[0].ask", "`near`"),
    "missing in a number": (GOOD + changed(NUMBER, "high = 10\n", ""), 14, "step[0].ask", "`high`"),
    "missing in a do": (GOOD + changed(DO, "below = 3\n", ""), 14, "step[0].ask", "below or above"),
    "both ways": (GOOD + DO + "above = 3\n", 14, "step[0].ask", "below or above"),
    "nothing to do it by": (re.sub("sliders.*\n", "", GOOD) + DO, 13, "step[0].ask", "needs sliders"),
    "number upside down": (GOOD + changed(NUMBER, "low = 1\n", "low = 11\n"), 18, "step[0].ask.low", "less than high"),
    "numbers without end": (GOOD + NUMBER + "step = 1e-9\n", 24, "step[0].ask.step", "at most 40"),
    "no tolerance": (GOOD + changed(NUMBER, "within = 1\n", ""), 14, "step[0].ask", "factor or within"),
    "place of no figure": (GOOD + changed(PLACE, '"L"', '"R"'), 17, "step[0].ask.figure", "none of the step's main"),
    "place in a formula": (
        changed(GOOD + PLACE, '"L"\ntruth', '"formula"\ntruth').replace('"L", show = ["own points"]', '"formula"'),
        17, "step[0].ask.figure", "nothing can be marked in 'formula'",
    ),
    "place that is a number": (
        GOOD + changed(PLACE, '"recovered in L"', '"E"'), 18, "step[0].ask.truth", "'E' is no place",
    ),
    "number that is a place": (step("{E}", "{recovered in L}"), 10, "step[0].say", "'recovered in L' is no number"),
    "too many words": (step("Two arms stand before one pair of eyes.", SIXTY), 9, "step[0].text", "61 words"),
    "too quick": (
        step("Two arms stand before one pair of eyes.", "A.") + f'after = "{" ".join(["word"] * 400)}"\n', 4, "minutes",
        "it takes 2",
    ),
    "same id": (GOOD + GOOD[GOOD.index("[[step]]") :], 15, "step[1].id", "'where' is another step's"),
    "id of a page": (step('"where"', '"a\\"><script>"'), 7, "step[0].id", "small letters"),
    "no step": (GOOD[: GOOD.index("[[step]]")], 1, None, "`step`"),
    "no steps": (GOOD[: GOOD.index("[[step]]")] + "step = []\n", 1, None, "a lesson needs a [[step]]"),
    "empty": ("", 1, None, "`title`"),
    "unequal answers": (
        GOOD + '[[question]]\nbefore = "a"\nafter = "b"\nanswers = ["a", "b"]\nanswers_after = ["a"]\n',
        18, "question[0].answers_after", "as many answers",
    ),
}  # fmt: skip


@pytest.mark.parametrize("asked", ["", CHOICE, PLACE, NUMBER, DO], ids=["none", "choice", "place", "number", "do"])
def test_what_is_right_is_taken(tmp_path, asked):
    path = tmp_path / "mine.toml"
    path.write_text(GOOD + asked)
    assert load(path, tried=True).step[0].id == "where"


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_named_by_file_line_and_field(tmp_path, fault):
    text, line, field, said = FAULTS[fault]
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(ValueError) as error:
        load(path, tried=True)
    told = str(error.value)
    assert told.startswith(f"{path}, line {line}: {'' if field is None else f'{field}: '}"), told
    assert said in told and "\n" not in told


@pytest.mark.parametrize(
    "data, said",
    [
        (b'title = "a"\nshort =\n', r"line 2, column"),
        (b'title = "a"\nshort = "\xff"\n', r", line 2: is not written in UTF-8"),
        (b"a = " + b"[" * 20_000, r"brackets within brackets"),
        (b"minutes = " + b"9" * 5000, r"integer|digits"),
        (b"#" * (MOST_BYTES + 1), r"larger than 200 kB"),
    ],
    ids=["broken", "not UTF-8", "deep", "endless number", "large"],
)
def test_what_is_no_lesson_is_said_in_a_line(tmp_path, data, said):
    path = tmp_path / "mine.toml"
    path.write_bytes(data)
    with pytest.raises(ValueError, match=said) as error:
        load(path)
    assert str(error.value).startswith(str(path)) and len(str(error.value)) < 300


def test_what_never_ends_is_not_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    for path in (tmp_path / "pipe.toml", tmp_path, "/dev/zero"):
        with pytest.raises(ValueError, match="is no file"):
            load(type(tmp_path)(path))


def test_the_names_of_own_lessons_tell_their_content(tmp_path):
    paths = [tmp_path / name for name in ("mine.toml", "Übung 3, näher.toml")]
    for path in paths:
        path.write_text(GOOD)
    first = list(own(paths))
    assert len(first) == 2 and all(re.fullmatch(r"[-\w]{1,30}", name, re.ASCII) for name in first)
    paths[0].write_text(step("Two arms", "Both arms"))
    again = list(own(paths))
    assert again[0] != first[0] and again[1] == first[1]


def test_a_fault_ends_the_command_before_anything_is_served(ask, tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(step('"L"', '"M"'))
    status, out, said = ask("serve", "--lesson", path)
    assert (status, out) == (2, "")
    assert said == (
        f"viewimit serve: --lesson: {path}, line 11: step[0].main[0].figure: no figure 'M'; there are "
        f"{', '.join(FIGURES)}\n"
    )
    status, out, said = ask("serve", "--lesson", tmp_path / "missing.toml")
    assert (status, out, said.count("\n")) == (2, "", 1) and "missing.toml: No such file" in said


@pytest.mark.parametrize("name", shipped())
def test_a_shipped_lesson_stands_the_trial_of_others(name):
    assert list(faults_in_session(shipped()[name])) == []


def test_what_a_lesson_leaves_open_is_the_papers():
    at_work, step = StepSession(), shipped()["tour"].step[0]
    at_work.begin(step, {"points": 16}, {}, None, 1)
    assert at_work.session.settings == complete(Settings.paper(points=16))
