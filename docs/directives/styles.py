"""The drawings' stylesheet, in the colours of the site's light and dark scheme, and their font."""

from pathlib import Path

from sphinx.application import Sphinx
from viewimit.app.ways import STYLES

from viewimit.drawing.theme import DRAWING_CSS, font_faces, variables


def _write(app: Sphinx) -> None:
    dark = variables(True)
    chosen, by_system = f"body[data-theme=dark]{{{dark}}}", f"body:not([data-theme=light]){{{dark}}}"
    on_screens = f"@media not print{{{chosen}@media (prefers-color-scheme:dark){{{by_system}}}}}"
    sheet = f"{font_faces()}\nbody{{{variables(False)}}}\n{on_screens}\n{DRAWING_CSS}\n{STYLES.read_text('utf-8')}"
    folder = Path(app.outdir) / "_static"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "drawings.css").write_text(sheet, "utf-8")


def add_to(app: Sphinx) -> None:
    app.connect("build-finished", lambda app, error: None if error else _write(app))
    app.add_css_file("drawings.css")
