"""Every published figure has the command that measures it, with that command's settings, in docs/figures.toml."""

import importlib.util
import shlex
from pathlib import Path

import msgspec

from viewimit.commands import cli
from viewimit.options import settings_from

ROOT = Path(__file__).parents[2]
FIGURES = msgspec.toml.decode((ROOT / "docs/figures.toml").read_bytes())["figure"]
OF_A_RUN = {"reproduce"}  # commands whose figures depend on all that `Settings` has
HOW_TOLD = {"command", "run", "json"}


def test_each_figure_names_commands_that_exist_and_their_settings_of_today():
    """A default that changes changes the figure: then it has to be measured anew. An option that is new does not."""
    for figure in FIGURES:
        assert figure["what"] and figure["found"] and figure["commands"]
        for command, settings in zip(figure["commands"], figure.get("settings", [{}] * 9)):
            program, *words = shlex.split(command)
            if program == "python":
                assert importlib.util.find_spec(words[1]) if words[0] == "-m" else (ROOT / words[0]).is_file(), command
            elif "--dynamics" not in words or importlib.util.find_spec("pybullet"):
                holds(command, words, settings)


def holds(command, words, settings):
    args = cli.parser_of(words[0]).parse_args(cli.attached(words))
    meant = {name: plain(value) for name, value in vars(args).items() if name not in HOW_TOLD}
    if words[0] in OF_A_RUN:
        meant |= msgspec.to_builtins(settings_from(args))
    assert settings and settings == {name: meant.get(name) for name in settings}, command
    given = {word[2:].partition("=")[0].replace("-", "_") for word in words if word.startswith("--")}
    assert {"points" if name == "n_points" else name for name in given} <= settings.keys(), command


def plain(value):
    return list(value) if isinstance(value, tuple) else str(value) if isinstance(value, Path) else value
