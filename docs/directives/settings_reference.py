"""The fields of `Settings`, with their usual values, from the class itself."""

import msgspec
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from viewimit.loop.settings import FIELDS, Settings


class SettingsTable(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        table = nodes.table(classes=["settings"])
        group = nodes.tgroup(cols=3)
        group += [nodes.colspec(colwidth=width) for width in (20, 15, 65)]
        head, body = nodes.thead(), nodes.tbody()
        head += _row("field", "default", "")
        for field in msgspec.structs.fields(Settings):
            body += _row(field.name, repr(field.default), FIELDS[field.name].description)
        group += [head, body]
        table += group
        return [table]


def _row(name: str, usual: str, said: str) -> nodes.row:
    row = nodes.row()
    for k, words in enumerate((name, usual, said)):
        inside = nodes.literal(words, words) if k < 2 and name != "field" else nodes.Text(words)
        row += nodes.entry("", nodes.paragraph("", "", inside))
    return row


def add_to(app: Sphinx) -> None:
    app.add_directive("settings-table", SettingsTable)
