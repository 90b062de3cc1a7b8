"""A session as one HTML file that needs no server, also for a notebook's cell.

It plays recorded drawings of the page beside a small WebGL view of its own, a tenth of the size of viser's client and
independent of viser's versions. The browser's modules become one script that needs no loader.
"""

import base64
import re
import zlib
from functools import cache
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import msgspec

from ...assets import ROOT
from ...loop.session import Session
from ..curves import paired_axis
from ..glossary import cards
from ..svg import count_motions
from ..theme import DRAWING_CSS, WORDS_CSS, font_faces, variables
from .citation import Citation, cite
from .panels import draw_panels, kept_motions, largest_residual
from .space import describe_space

SCRIPTS = ROOT.parent / "app" / "lab"  # beside assets/, in a clone and where it is installed
IMPORT = re.compile(r'^import (\{[^}]*\}) from "(\./|\.\./)([^"]+)";\n', re.M)
REEXPORT = re.compile(r'^export (\{[^}]*\}) from "(\./|\.\./)([^"]+)";\n', re.M)
EXPORT = re.compile(r"^export (?:async )?(?:const|let|function|class) (\w+)", re.M)


def bundle(entry: str) -> str:
    """Return ES modules as one script: each becomes a function that returns its exports, in the order of imports.

    Parameters
    ----------
    entry
        The module that is run last, a path in app/lab/.

    Notes
    -----
    Modules import by name, from relative paths, at the top: `import {a, b as c} from "./x.js";`. They export
    declarations, one name each, or names of other modules. No module imports in a circle.
    """
    parts: dict[Path, str] = {}
    at = lambda path: f"MODULES[{path.relative_to(SCRIPTS.resolve()).as_posix()!r}]"

    def add(path: Path) -> str:
        if path not in parts:
            text = re.sub(r"^ *(/\*\*.*?\*/|// .*?$)\n?", "", path.read_text("utf-8"), flags=re.M | re.S)
            names = EXPORT.findall(text)
            imported = lambda match: add((path.parent / match[2] / match[3]).resolve())
            text = IMPORT.sub(lambda match: f"const {match[1].replace(' as ', ': ')} = {imported(match)};\n", text)
            for match in REEXPORT.finditer(text):
                names += [name.strip() for name in match[1].strip("{}").split(",")]
            text = REEXPORT.sub(lambda match: f"const {match[1]} = {imported(match)};\n", text)
            text = re.sub(r"^export ", "", text, flags=re.M)
            module = f"{at(path)} = (() => {{\n{text}return {{{', '.join(names)}}};\n}})();"
            parts[path] = text if path == first else module
        return at(path)

    first = (SCRIPTS / entry).resolve()
    add(first)
    return '"use strict";\nconst MODULES = {};\n' + "\n".join(parts.values())


def packed(data: bytes) -> str:
    """Return bytes, compressed, as text that a script element holds."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


CELL_HEIGHT = 700  # px, in a notebook
HERE = Path(__file__).parent


class Replay:
    """A recorded session as an HTML page; a notebook shows it as the value of a cell.

    Parameters
    ----------
    html
        Text of the page.
    """

    def __init__(self, html: str):
        self.html = html

    def save(self, path: str | Path) -> int:
        """Write the page to a file.

        Parameters
        ----------
        path
            Of the file, by convention ending in .html.

        Returns
        -------
        int
            Bytes written.

        Raises
        ------
        OSError
            If the file cannot be written.
        """
        return Path(path).write_bytes(self.html.encode())

    def _repr_html_(self) -> str:
        style = f"width:100%;height:{CELL_HEIGHT}px;border:0;border-radius:8px"
        return f'<iframe title="Replay" style="{style}" srcdoc="{escape(self.html)}"></iframe>'


def replay(session: Session, title: str = "", chosen: int | None = None) -> Replay:
    """Record a session in a scene, with all motions of its history, as one HTML page.

    Parameters
    ----------
    session
        The session; it is not changed.
    title
        Title of the page; "" for the method's name.
    chosen
        The body point whose construction is drawn at first; None for the one with the largest residual.

    Returns
    -------
    Replay
        The page.

    Raises
    ------
    ValueError
        If the session has no scene, or the body no such point.
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
    run = {"motions": kept, "space": space, "axis": [left, right, end], "chosen": chosen}
    run["panels"] = msgspec.to_builtins(panels)
    return Replay(_page(title, cite(session), run, meshes))


def _page(title: str, citation: Citation, run: dict[str, Any], meshes: bytes) -> str:
    last = run["motions"][-1]
    return _template().substitute(
        title=escape(title or citation.title),
        conditions=escape(citation.conditions),
        motions=last,
        made=count_motions(last),
        software=escape(citation.software),
        repeated=_repeated(citation),
        line=escape(citation.repeated_by or citation.software),
        styles=_styles(),
        words=cards(),
        run=packed(msgspec.json.encode(run)),
        meshes=packed(meshes),
        script=_scripts(),
    )


def _repeated(citation: Citation) -> str:
    """Build the texts that repeat the session, each with a button that copies it."""
    parts = []
    for name, text in (("As a command", citation.command), ("In Python", citation.python)):
        if text is not None:
            parts.append(
                f'<h2>{name}</h2><button type="button" class="copy" aria-label="Copy: {name}">Copy</button>'
                f'<pre tabindex="0">{escape(text)}</pre>'
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
