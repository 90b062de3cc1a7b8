"""The page on lessons says what there is, and its example is a lesson."""

import re
from pathlib import Path

import pytest
from viewimit.app.lessons.format import Choice, Do, Lesson, Number, Place, Pose, Select, Step
from viewimit.app.lessons.source import load
from walking import answer, begun, unfilled, words

PAGE = Path(__file__).parents[2].joinpath("docs", "lessons.md").read_text("utf-8")
EXAMPLE = re.search(r"```toml\n(.*?)```", PAGE, re.S)[1]
KINDS = {"choice": Choice, "place": Place, "number": Number, "do": Do, "pose": Pose, "select": Select}


def section(title):
    return re.split(r"^## ", PAGE.split(f"\n## {title}\n")[1], flags=re.M)[0]


def named(text):
    """What a text has in code."""
    return set(re.findall(r"`([a-z_]+)(?: = [^`]*)?`", text))


def test_the_example_is_short_and_can_be_walked(tmp_path):
    assert len(EXAMPLE.splitlines()) <= 11
    path = tmp_path / "mine.toml"
    path.write_text(EXAMPLE, "utf-8")
    course = begun(load(path, tried=True))
    assert "Who is in L?" in words(course)
    answer(course, rightly=False)
    assert "That one is in l." in words(course) and not unfilled(words(course))
    assert re.search(r"E is now [\d.]+ px²\.", words(course))


@pytest.mark.parametrize("title, struct", [("A lesson", Lesson), ("A step", Step)])
def test_every_field_is_named_and_none_that_is_not(title, struct):
    rows = re.findall(r"^\| (`.*?) \|", section(title), re.M)
    assert set().union(*map(named, rows)) == set(struct.__struct_fields__)


def test_every_kind_of_question_is_named_with_its_fields():
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*?) \|", section("What can be asked"), re.M))
    assert rows.keys() == KINDS.keys()
    inside = {"text", "because", "name", "label", "values", "value"}  # of answers, and of fields
    for kind, struct in KINDS.items():
        assert named(rows[kind]) - inside == set(struct.__struct_fields__) - {"question"}


def test_the_fault_that_it_shows_is_said_so(tmp_path):
    shown = re.search(r"(line \d+: .*?), …", PAGE)[1]
    path = tmp_path / "mine.toml"
    path.write_text(EXAMPLE.replace('show = ["own points"]', 'show = ["owned"]'), "utf-8")
    with pytest.raises(ValueError) as error:
        load(path)
    assert shown in str(error.value)
