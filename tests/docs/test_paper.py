"""The short paper's tables are what the commands beside them print, and its algorithm is the one of the code."""

import json
import re
import shlex
from pathlib import Path

import pytest

from viewimit.commands import cli
from viewimit.experiments.bench import GROUPS
from viewimit.experiments.bench.engine import chosen
from viewimit.servo.trust_region import PHASES
from viewimit.servo.trust_region.state import Phase

DOCS = Path(__file__).parents[2] / "docs"
PAPER = (DOCS / "paper.md").read_text("utf-8")
MEASURED = {path.stem: json.loads(path.read_text("utf-8")) for path in sorted((DOCS / "measured").glob("*.json"))}
COMMANDS = [line.strip("`") for line in re.findall(r"`viewimit bench [^`]+`|^viewimit bench .+$", PAPER, re.M)]
PRINTING = [command for command in COMMANDS if "--json" in command]
CHOSEN_LATER = {"points"}  # by the scene, if it is not given


def options_of(command):
    """What a command would print as its options."""
    args = vars(cli.parser_of("bench").parse_args(cli.attached(shlex.split(command)[1:])))
    plain = lambda value: list(value) if isinstance(value, tuple) else value
    return {name: plain(value) for name, value in args.items() if name not in {"command", "run", "json"}}


def is_of(printed, command):
    """Whether this command prints it, with today's defaults."""
    given = options_of(command)
    same = given.keys() == printed["options"].keys()
    return same and all(
        value == printed["options"][name] or (name in CHOSEN_LATER and value is None) for name, value in given.items()
    )


@pytest.mark.parametrize("command", PRINTING)
def test_a_command_of_the_paper_has_printed_one_table(command):
    """A default or an option that changes changes the table: then it has to be measured again."""
    assert sum(is_of(printed, command) for printed in MEASURED.values()) == 1


@pytest.mark.parametrize("name", MEASURED)
def test_a_table_has_its_command_in_the_paper_and_the_cases_of_today(name):
    printed = MEASURED[name]
    assert sum(is_of(printed, command) for command in PRINTING) == 1
    options = printed["options"]
    rows, group = printed[options["benchmark"]], GROUPS[options["benchmark"]]
    measured = list(dict.fromkeys(row["case"] for row in rows))
    known = [case.name for case in chosen(group.cases, options["case"])]
    assert measured and set(measured) <= set(known)  # some are newer


def test_other_commands_of_the_paper_can_be_given():
    others = [command for command in COMMANDS if command not in PRINTING]
    assert {options_of(command)["benchmark"] for command in others} == {"compare"}


def test_the_algorithm_of_the_paper_has_the_phases_and_transitions_of_the_code():
    listing = PAPER.partition("## 4 The algorithm")[2].partition("\n## ")[0]
    found = re.findall(r"^\d\. \*\*([A-Z]+)\.\*\*.*?Next: (.+?)\.$", listing, re.M | re.S)
    assert [name for name, _ in found] == [phase.name for phase in Phase]
    for name, after in found:
        words = set(re.findall(r"[A-Z]{2,}|a motion", after))
        makes_motion = Phase[name] is not Phase.PLAN
        assert words == {one.name for one in PHASES[Phase[name]][1]} | ({"a motion"} if makes_motion else set())
