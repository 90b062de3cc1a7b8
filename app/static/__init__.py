"""What the browser is given as it is: the page's stylesheet, complete with the drawings' and the font, and its script,
which names for keys, screen readers and the stylesheet what viser leaves without a name. Markup is beside the
drawings."""

from pathlib import Path

from viewimit.drawing.theme import DRAWING_CSS, WORDS_CSS, font_faces, variables

from ..ways import STYLES

STATIC = Path(__file__).parent
PAGE_CSS, CONTROLS_CSS, LAYOUT_CSS = (
    STATIC.joinpath(f"{name}.css").read_text("utf-8") for name in ("page", "controls", "layout")
)
SCRIPTS = ("limits.js", "session.js", "page.js")
PAGE_JS = "".join(STATIC.joinpath(name).read_text("utf-8") for name in SCRIPTS)


def stylesheet() -> str:
    """All of the page's CSS, for both colour schemes."""
    schemes = f':root{{{variables(False)}}}:root[data-mantine-color-scheme="dark"]{{{variables(True)}}}'
    return "\n".join(
        (schemes, font_faces(), WORDS_CSS, PAGE_CSS, CONTROLS_CSS, LAYOUT_CSS, STYLES.read_text("utf-8"), DRAWING_CSS)
    )
