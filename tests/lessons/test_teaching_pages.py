"""The documentation for lecturers: its example is a lesson, its tables are complete, its commands and times exist."""

import re
from pathlib import Path

import pytest
from viewimit.app.lab.lessons import format as lesson_format
from viewimit.app.lab.lessons import source

from viewimit.commands.cli import COMMANDS

TEACH = Path(__file__).parents[2] / "docs" / "teach"
FORMAT = (TEACH / "lesson-format.md").read_text("utf-8")
LESSONS = source.shipped()


def test_the_example_is_a_lesson(tmp_path):
    (example,) = re.findall(r"```toml\n(.*?)```", FORMAT, re.S)
    path = tmp_path / "mine.toml"
    path.write_text(example, "utf-8")
    assert source.load(path, tried=True).step[0].id == "whose"


@pytest.mark.parametrize(
    "kind", [lesson_format.Lesson, lesson_format.Step, lesson_format.Slider, *lesson_format.Ask.__args__]
)
def test_every_field_is_documented(kind):
    for field in kind.__struct_fields__:
        assert f"`{field}`" in FORMAT, field
    tag = kind.__struct_config__.tag
    assert tag is None or f"| `{tag}` |" in FORMAT


def test_every_lesson_is_in_the_table_with_its_time():
    text = (TEACH / "class.md").read_text("utf-8")
    for lesson in LESSONS.values():
        assert f"| {lesson.title} | {lesson.minutes} |" in text


@pytest.mark.parametrize("page", ["class.md", "plans.md", "lesson-format.md"])
def test_commands_that_are_shown_exist(page):
    text = (TEACH / page).read_text("utf-8")
    code = "\n".join(re.findall(r"```sh\n.*?```|`viewimit [^`]*`", text, re.S))
    shown = re.findall(r"\bviewimit ([a-z]+)\b", code)
    assert set(shown) <= set(COMMANDS) and (shown or page == "plans.md")


def test_a_plan_fills_45_minutes_without_a_gap():
    text = (TEACH / "plans.md").read_text("utf-8")
    plans = re.split(r"^## Plan ", text, flags=re.M)[1:]
    assert len(plans) == 2
    for plan in plans:
        rows = re.findall(r"^\| (\d):(\d\d) \| (\d+) \|", plan, re.M)
        begins = [60 * int(hour) + int(minute) for hour, minute, _ in rows]
        lasts = [int(minutes) for *_, minutes in rows]
        assert begins == [sum(lasts[:k]) for k in range(len(lasts))] and sum(lasts) == 45


def test_a_fault_is_named_as_the_page_shows_it(tmp_path):
    example = re.findall(r"```toml\n(.*?)```", FORMAT, re.S)[0].replace('["own points"]', '["owned"]')
    path = tmp_path / "mine.toml"
    path.write_text(example, "utf-8")
    with pytest.raises(ValueError) as caught:
        source.load(path)
    shown = "mine.toml, line 10: step[0].main[0].show: no layer of L 'owned'; there are own points"
    assert shown in str(caught.value) and shown in FORMAT
