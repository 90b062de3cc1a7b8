"""A session as one page that needs no server and asks nobody for anything: a file, or a notebook's cell.

It plays recorded drawings of the page beside a small WebGL view of its own: a tenth of the size of viser's client, and
nothing that a new version of viser could break.
"""

import html
from functools import cache
from pathlib import Path
from string import Template
from typing import Any

import msgspec

from ...loop.session import Session
from ..curves import paired_axis
from ..glossary import cards
from ..svg import count_motions
from ..theme import DRAWING_CSS, WORDS_CSS, font_faces, variables
from .bundle import bundle, packed
from .citation import Citation, cite
from .panels import draw_panels, kept_motions, largest_residual
from .space import describe_space

CELL_HEIGHT = 700  # px, in a notebook
HERE = Path(__file__).parent


class Replay:
    """html: the whole page. In a notebook it shows itself."""

    def __init__(self, page: str):
        self.html = page

    def save(self, path: str | Path) -> int:
        """As a file → its bytes. Raises OSError."""
        return Path(path).write_bytes(self.html.encode())

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{CELL_HEIGHT}px;border:0;border-radius:8px"
        return f'<iframe title="Replay" style="{style}" srcdoc="{html.escape(self.html)}"></iframe>'


def replay(session: Session, title: str = "", chosen: int | None = None) -> Replay:
    """All moments of a session in a scene that its history keeps, from the first on.

    title: in place of the method's name; chosen: a body point whose construction is drawn until another is chosen,
    None for the one with the largest residual. Raises ValueError without a scene, and for a point that there is not.
    """
    world, first = session.world, session.history[0]
    if chosen is None:
        chosen = largest_residual(first)
    elif not 0 <= chosen < len(world.body):
        raise ValueError(f"no point {chosen}; there are {len(world.body)}, from 0")
    kept = kept_motions(session.history)
    space, meshes = describe_space(session, kept)
    left, right, end = paired_axis(len(session.history) - 1)
    panels = draw_panels(session, kept, chosen)
    told = {"motions": kept, "space": space, "axis": [left, right, end], "chosen": chosen}
    told["panels"] = msgspec.to_builtins(panels)
    return Replay(_page(title, cite(session), told, meshes))


def _page(title: str, citation: Citation, told: dict[str, Any], meshes: bytes) -> str:
    last = told["motions"][-1]
    return _template().substitute(
        title=html.escape(title or citation.title),
        conditions=html.escape(citation.conditions),
        motions=last,
        made=count_motions(last),
        software=html.escape(citation.software),
        repeated=_repeated(citation),
        line=html.escape(citation.repeated_by or citation.software),
        styles=_styles(),
        words=cards(),
        run=packed(msgspec.json.encode(told)),
        meshes=packed(meshes),
        script=_scripts(),
    )


def _repeated(citation: Citation) -> str:
    """What repeats it, each with a button that copies it."""
    parts = []
    for name, text in (("As a command", citation.command), ("In Python", citation.python)):
        if text is not None:
            parts.append(
                f'<h2>{name}</h2><button type="button" class="copy" aria-label="Copy: {name}">Copy</button>'
                f'<pre tabindex="0">{html.escape(text)}</pre>'
            )
    return "".join(parts) or "<p>It goes on from what cannot be said in a few words.</p>"


@cache
def _template() -> Template:
    return Template(HERE.joinpath("replay.html").read_text("utf-8"))


@cache
def _styles() -> str:
    own = HERE.joinpath("replay.css").read_text("utf-8")
    schemes = f":root{{{variables(False)}}}:root[data-scheme=dark]{{{variables(True)}}}"
    return "\n".join((schemes, font_faces(), DRAWING_CSS, WORDS_CSS, own))


@cache
def _scripts() -> str:
    return bundle("view/replay.js")
