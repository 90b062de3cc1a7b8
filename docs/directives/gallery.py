"""The gallery's replays, made by docs/gallery.py beside the pages; where that is not there, there is no such page."""

from importlib import import_module
from pathlib import Path

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.util.docutils import SphinxDirective

FOLDER, LIST = "gallery", "index.fragment.html"


class Gallery(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        folder = Path(self.env.app.outdir) / FOLDER
        import_module("gallery").build_gallery(folder)
        listed = (folder / LIST).read_text("utf-8").replace('href="', f'href="{FOLDER}/')
        (folder / LIST).unlink()
        return [nodes.raw("", listed, format="html")]


def _leave_out(app: Sphinx, config: Config) -> None:
    """Of all pages, and of the list that the first one has."""
    if not (Path(app.srcdir) / f"{FOLDER}.py").is_file():
        config.exclude_patterns.append(f"{FOLDER}.md")
        app.connect("source-read", _without_entry)


def _without_entry(app: Sphinx, page: str, source: list[str]) -> None:
    source[0] = source[0].replace(f"\n{FOLDER}\n", "\n") if page == "index" else source[0]


def add_to(app: Sphinx) -> None:
    app.add_directive("gallery", Gallery)
    app.connect("config-inited", _leave_out)
