"""Tables of what was measured, from docs/figures.toml."""

import json
from pathlib import Path
from typing import Any

import msgspec
from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

FILE = Path(__file__).parents[1] / "figures.toml"


class Figure(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """what was measured, what was found, by which commands, and the settings of each; none of a command that takes
    none. day: of the code, "" for that of the others."""

    what: str
    found: str
    commands: list[str]
    settings: list[dict[str, Any]] = []
    day: str = ""


def figures() -> list[Figure]:
    return msgspec.toml.decode(FILE.read_bytes(), type=dict[str, list[Figure]])["figure"]


class Measured(SphinxDirective):
    """All figures, with their commands and, folded, those commands' settings."""

    def run(self) -> list[nodes.Node]:
        rows = ["| what | found | command |", "|---|---|---|"]
        for figure in figures():
            commands = "<br>".join(f"`{command}`" for command in figure.commands)
            day = f" ({figure.day})" if figure.day else ""
            rows.append(f"| {figure.what} | {figure.found}{day} | {commands} |")
        place = nodes.container(classes=["measured"])
        self.state.nested_parse(StringList(rows, str(FILE)), 0, place)
        settings = {command: found for figure in figures() for command, found in zip(figure.commands, figure.settings)}
        lines = "\n".join(
            f"{command}\n    {json.dumps(found, ensure_ascii=False)}" for command, found in settings.items()
        )
        folded = nodes.literal_block(lines, lines, classes=["wrapped"])
        folded["language"] = "text"
        opened = nodes.raw("", "<details><summary>All settings of these commands</summary>", format="html")
        return [place, opened, folded, nodes.raw("", "</details>", format="html")]


def add_to(app: Sphinx) -> None:
    app.add_directive("measured", Measured)
