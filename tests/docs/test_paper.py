"""The short paper's tables are what the commands beside them print, with today's defaults."""

import json
import re
import shlex
from pathlib import Path

from viewimit.commands import cli

DOCS = Path(__file__).parents[2] / "docs"
PAPER = (DOCS / "paper.md").read_text("utf-8")
COMMANDS = [line.strip("`") for line in re.findall(r"`viewimit bench [^`]+`|^viewimit bench .+$", PAPER, re.M)]
CHOSEN_LATER = {"points"}  # by the scene, if it is not given


def options_of(command):
    """What a command would print as its options."""
    args = vars(cli.parser_of("bench").parse_args(cli.attached(shlex.split(command)[1:])))
    plain = lambda value: list(value) if isinstance(value, tuple) else value
    return {name: plain(value) for name, value in args.items() if name not in {"command", "run", "json"}}


def is_of(printed, given):
    """Whether a command with these options prints it."""
    same = given.keys() == printed["options"].keys()
    return same and all(
        value == printed["options"][name] or (name in CHOSEN_LATER and value is None) for name, value in given.items()
    )


def test_each_table_was_printed_by_one_command_of_the_paper():
    """A default or an option that changes changes the table: then it has to be measured again."""
    printing = {command: options_of(command) for command in COMMANDS if "--json" in command}
    measured = {path.stem: json.loads(path.read_text("utf-8")) for path in (DOCS / "measured").glob("*.json")}
    of = {command: [name for name in measured if is_of(measured[name], given)] for command, given in printing.items()}
    assert sorted(sum(of.values(), [])) == sorted(measured) and all(len(names) == 1 for names in of.values()), of
    assert {options_of(command)["benchmark"] for command in COMMANDS if command not in printing} == {"compare"}
