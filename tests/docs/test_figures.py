"""Every published figure has the command that measures it, with that command's settings, in docs/figures.toml."""

import importlib.util
import re
import shlex
from pathlib import Path

import msgspec
import pytest

from viewimit.commands import cli
from viewimit.commands.options import settings_from

try:
    import tomllib
except ModuleNotFoundError:  # Python 3.10
    import tomli as tomllib

ROOT = Path(__file__).parents[2]
FIGURES = tomllib.loads((ROOT / "docs/figures.toml").read_text("utf-8"))["figure"]
COMMANDS = [
    (command, settings)
    for figure in FIGURES
    for command, settings in zip(
        figure["commands"], figure.get("settings", [{}] * len(figure["commands"])), strict=True
    )
]
OF_A_RUN = {"reproduce"}  # commands whose figures depend on all that `Settings` has
HOW_TOLD = {"command", "run", "json"}


def plain(value):
    return list(value) if isinstance(value, tuple) else str(value) if isinstance(value, Path) else value


@pytest.mark.parametrize("command, settings", COMMANDS, ids=[command[:60] for command, _ in COMMANDS])
def test_a_figure_names_a_command_that_exists_and_its_settings(command, settings):
    """A default that changes changes the figure: then it has to be measured anew. An option that is new does not."""
    program, *words = shlex.split(command)
    if program == "python":
        module = words[1] if words[0] == "-m" else None
        assert importlib.util.find_spec(module) if module else (ROOT / words[0]).is_file()
        return
    assert program == "viewimit"
    if "--dynamics" in words:
        pytest.importorskip("pybullet")
    args = cli.parser_of(words[0]).parse_args(cli.attached(words))
    meant = {name: plain(value) for name, value in vars(args).items() if name not in HOW_TOLD}
    if words[0] in OF_A_RUN:
        meant |= msgspec.to_builtins(settings_from(args))
    assert settings and settings == {name: meant.get(name) for name in settings}
    given = {word[2:].partition("=")[0].replace("-", "_") for word in words if word.startswith("--")}
    assert {"points" if name == "n_points" else name for name in given} <= settings.keys()


def test_a_figure_that_is_published_elsewhere_is_one_of_them():
    known = {command for figure in FIGURES for command in figure["commands"]}
    table = (ROOT / "README.md").read_text("utf-8").partition("## Measured")[2].partition("\n## ")[0]
    commands = set(re.findall(r"\| `((?:viewimit|python) [^`]+)`", table))
    assert commands <= known and (commands or not table)
    assert all(figure["what"] and figure["found"] for figure in FIGURES)
