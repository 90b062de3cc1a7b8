"""The drawings' stylesheet, in the colours of the site's light and dark scheme, and their font."""

import re
from collections.abc import Iterator
from pathlib import Path

from sphinx.application import Sphinx
from viewimit.assets import ROOT

from viewimit.drawing.theme import DRAWING_CSS, font_faces, variables

LESSON_CSS = ROOT.parent / "app" / "static" / "lesson.css"
SVG_PROPERTIES = {"fill", "stroke", "font", "text-anchor", "paint-order", "opacity"}
LESS = re.compile(r"/\*.*?\*/|@(?:media|supports)[^{]*\{(?:[^{}]*\{[^{}]*\})*\s*\}", re.DOTALL)  # comments, and cases
_RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")


def lesson_rules() -> Iterator[str]:
    """Of the lessons' stylesheet, what is said of lines, areas and words, and not of where things stand on the page."""
    plain = LESS.sub("", LESSON_CSS.read_text("utf-8"))
    for selectors, declarations in _RULE.findall(plain):
        names = {each.partition(":")[0].strip() for each in declarations.split(";") if each.strip()}
        if names and all(name.partition("-")[0] in SVG_PROPERTIES or name in SVG_PROPERTIES for name in names):
            yield f"{selectors.strip()}{{{declarations}}}"


def _write(app: Sphinx) -> None:
    dark = variables(True)
    sheet = (
        f"{font_faces()}\nbody{{{variables(False)}}}\nbody[data-theme=dark]{{{dark}}}\n"
        f"@media (prefers-color-scheme:dark){{body:not([data-theme=light]){{{dark}}}}}\n"
        f"{DRAWING_CSS}\n" + "\n".join(lesson_rules())
    )
    folder = Path(app.outdir) / "_static"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "drawings.css").write_text(sheet, "utf-8")


def add_to(app: Sphinx) -> None:
    app.connect("build-finished", lambda app, error: None if error else _write(app))
    app.add_css_file("drawings.css")
