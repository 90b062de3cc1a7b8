"""The article's live figures: each stands in its page as a still, and a script puts the live one in its place."""

from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.docutils import SphinxDirective
from viewimit.app.lab.article.page import FIGURES, script, styles

STILLS = Path(__file__).parents[1] / "stills"  # python docs/pictures.py stills
SCRIPT, STYLES = "article.js", "article.css"
LAB_STATES = {  # where the lab shows the same
    "crossing": "preset=paper&demo=45,-90&start=45,-90",
    "assumption": "preset=paper&demo=45,-90&start=25,-45",
    "bowl": "preset=paper&demo=45,-90&start=25,-45",
    "servo": "preset=paper&demo=45,-90&start=25,-45",
    "points": "preset=four&demo=45,-90&start=25,-45",
}


def still(name: str) -> str:
    """HTML of a figure's still."""
    return (STILLS / f"{name}.html").read_text("utf-8")


def figure(name: str) -> str:
    """HTML of a figure's place, with its still in it."""
    return f'<div class="live" data-live="{name}" id="figure-{name}"><div class="still">{still(name)}</div></div>'


class Live(SphinxDirective):
    """A live figure by its name; the words below it are its caption."""

    required_arguments = 1
    has_content = True

    def run(self) -> list[nodes.Node]:
        name = self.arguments[0]
        if name not in FIGURES:
            raise ExtensionError(f"{self.env.docname}, line {self.lineno}: no live figure {name!r}")
        shown = nodes.container("", classes=["figure", "figure-live"])
        shown += nodes.raw("", figure(name), format="html")
        words = nodes.container("", classes=["words"])
        self.state.nested_parse(self.content, self.content_offset, words)
        if name in LAB_STATES:
            link = f'<p><a class="open" href="../index.html#{LAB_STATES[name]}">Open the lab in this state</a></p>'
            words += nodes.raw("", link, format="html")
        shown += words
        self.env.metadata[self.env.docname]["live"] = "yes"
        return [shown]


def _load(app: Sphinx, page: str, template: str, context: dict, doctree: nodes.document | None) -> None:
    """Only pages with figures load the script."""
    if app.env.metadata.get(page, {}).get("live"):
        app.add_js_file(SCRIPT, loading_method="defer")
        app.add_css_file(STYLES)


def _write(app: Sphinx, error: Exception | None) -> None:
    if error is None:
        folder = Path(app.outdir) / "_static"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / SCRIPT).write_text(script(), "utf-8")
        (folder / STYLES).write_text(styles(), "utf-8")


def add_to(app: Sphinx) -> None:
    app.add_directive("live", Live)
    app.connect("html-page-context", _load)
    app.connect("build-finished", _write)
