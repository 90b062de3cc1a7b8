"""What the browser is given as it is: the page's stylesheet, complete with the drawings' and the font, and its script,
which names for keys, screen readers and the stylesheet what viser leaves without a name. Markup is
beside the drawings.

`_("…")` in the script marks a text, as in Python, and so does `content:"…"` in the stylesheet, where it holds words:
both are sent with these texts in the language of the process.
"""

import json
import re
from pathlib import Path

from viewimit.drawing.theme import DRAWING_CSS, WORDS_CSS, font_faces, variables
from viewimit.language import _

PAGE_CSS, CONTROLS_CSS, LAYOUT_CSS = (
    Path(__file__).with_name(f"{name}.css").read_text("utf-8") for name in ("page", "controls", "layout")
)

SCRIPTS = ("limits.js", "session.js", "page.js")
MARKED = re.compile(r'(?<![\w.$])_\(("(?:[^"\\]|\\.)*")\)')
CONTENT = re.compile(r'(?<=content:")[^"]*[A-Za-z]{2}[^"]*(?=")')


def translated(script: str) -> str:
    """Replace the marked texts of a script by their translations."""
    return MARKED.sub(lambda found: json.dumps(_(json.loads(found[1]))).replace("</", "<\\/"), script)


PAGE_JS = translated("".join(Path(__file__).with_name(name).read_text("utf-8") for name in SCRIPTS))


def stylesheet() -> str:
    """All of the page's CSS, for both colour schemes."""
    schemes = f':root{{{variables(False)}}}:root[data-mantine-color-scheme="dark"]{{{variables(True)}}}'
    css = "\n".join((schemes, font_faces(), WORDS_CSS, PAGE_CSS, CONTROLS_CSS, LAYOUT_CSS, DRAWING_CSS))
    return CONTENT.sub(lambda found: _(found[0]).replace('"', r"\""), css)
