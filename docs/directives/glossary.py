"""The glossary, from the page's own file."""

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from viewimit.drawing.equations import mathml
from viewimit.drawing.glossary import glossary
from viewimit.drawing.svg import escape


class Glossary(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        found: list[nodes.Node] = []
        for key, entry in glossary().items():
            section = nodes.section(ids=[f"word-{key}"], names=[f"word-{key}"], classes=["word"])
            section += nodes.title("", f"{entry.symbol}: {entry.name}")
            section += nodes.paragraph("", entry.sentence)
            if entry.formula:
                section += nodes.raw("", f'<div class="equation">{mathml(entry.formula)}</div>', format="html")
            for level, words in (("Good", entry.good), ("Bad", entry.bad)):
                if words:
                    grade = f'<p><b class="{level.lower()}">{level}</b> {escape(words)}</p>'
                    section += nodes.raw("", grade, format="html")
            found.append(section)
        return found


def add_to(app: Sphinx) -> None:
    app.add_directive("page-glossary", Glossary)
