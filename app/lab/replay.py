"""A session as one HTML file that needs no server, also for a notebook's cell. It is the lab with a recorded run: the
same page and modules show the run's snapshots, and take over where the lab can compute the run's scene. The browser's
modules become one script that needs no loader."""

import base64
import hashlib
import os
import re
import zlib
from collections.abc import Sequence
from functools import cache
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import msgspec
from viewimit.assets import ROOT

from viewimit import __version__
from viewimit.drawing.export.citation import Citation, cite
from viewimit.drawing.export.panels import largest_residual
from viewimit.drawing.glossary import ask, cards
from viewimit.drawing.svg import count_motions
from viewimit.drawing.theme import DRAWING_CSS, WORDS_CSS, font_faces, variables
from viewimit.loop.session import Session

from .engine_scene import can_compute, describe_hulls, describe_world
from .recording import describe_method, kept_motions, record
from .space import Shapes, describe_robot, describe_stage

SCRIPTS = Path(__file__).parent
COMMENT = re.compile(r"^ *(?:/\*\*(?:(?!\*/).)*\*/|// [^\n]*)\n|/\*\*.*?\*/ ?| +// [^\n]*$", re.M | re.S)
IMPORT = re.compile(r'^import (\{[^}]*\}) from "(\./|\.\./)([^"]+)";\n', re.M)
JSON = re.compile(r'^import (\w+) from "([^"]+\.json)" with \{type: "json"\};\n', re.M)
REEXPORT = re.compile(r'^export (\{[^}]*\}) from "(\./|\.\./)([^"]+)";\n', re.M)
SCRIPT = re.compile(r"<script>(.*?)</script>", re.S)
EXPORT = re.compile(r"^export (?:async )?(?:const|let|function|class) (\w+)", re.M)


def bundle(entry: str) -> str:
    """Return ES modules as one script: each becomes a function that returns its exports, in the order of imports.
    entry: the module that is run last, a path in app/lab/. Modules import by name, from relative paths, at the top:
    `import {a, b as c} from "./x.js";`. They export declarations, one name each, or names of other modules; JSON files
    come by one name. No module imports in a circle."""
    parts: dict[Path, str] = {}
    at = lambda path: f"MODULES[{path.relative_to(SCRIPTS).as_posix()!r}]"

    def add(path: Path) -> str:
        if path not in parts:
            text = COMMENT.sub("", path.read_text("utf-8"))
            names = EXPORT.findall(text)
            text = JSON.sub(lambda match: f"const {match[1]} = {_json(path.parent / match[2])};\n", text)
            imported = lambda match: add(Path(os.path.normpath(path.parent / match[2] / match[3])))
            text = IMPORT.sub(lambda match: f"const {match[1].replace(' as ', ': ')} = {imported(match)};\n", text)
            for match in REEXPORT.finditer(text):
                names += [name.strip() for name in match[1].strip("{}").split(",")]
            text = REEXPORT.sub(lambda match: f"const {match[1]} = {imported(match)};\n", text)
            text = re.sub(r"^export ", "", text, flags=re.M)
            module = f"{at(path)} = (() => {{\n{text}return {{{', '.join(names)}}};\n}})();"
            parts[path] = text if path == first else module
        return at(path)

    first = SCRIPTS / entry
    add(first)
    return '"use strict";\nconst MODULES = {};\n' + "\n".join(parts.values())


def with_policy(page: str, *inserted: str) -> str:
    """Let a page's content policy, whose script-src is 'own', allow the page's scripts alone, which it names by their
    hashes. inserted: scripts that those insert."""
    digests = (hashlib.sha256(script.encode()).digest() for script in (*SCRIPT.findall(page), *inserted))
    names = " ".join(f"'sha256-{base64.b64encode(digest).decode()}'" for digest in digests)
    return page.replace("script-src 'own'", f"script-src {names}", 1)


def _json(path: Path) -> str:
    """Return a JSON file of assets/ without spaces. It lies beside app/, in a clone and where it is installed."""
    name = path.as_posix().rpartition("/assets/")[2]
    return msgspec.json.encode(msgspec.json.decode(ROOT.joinpath(name).read_bytes())).decode()


def packed(data: bytes) -> str:
    """Return bytes, compressed, as text that a script element holds."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


CELL_HEIGHT = 700  # px, in a notebook
SCENE = "replay"  # the name of its scene, and of what the lab begins with
TAKEN_OVER = "The run of this replay, gone on with in the lab."
ASKED = "own_views", "demo_views", "E", "largest_e", "condition", "points_seen", "transfer", "servo"
PLACES = (  # of lab.html that only the lab, or only replays fill
    "ways", "about", *(f"replay_{place}" for place in ("title", "nav", "said", "panel", "steps", "how", "map", "end")),
    *(f"ask_{key}" for key in ASKED),
)  # fmt: skip
STYLES = "view/lab.css", "view/ways.css", "challenge/joints.css", "challenge/challenge.css"


class Replay:
    """A recorded session as an HTML page. A notebook shows it as the value of a cell. html: its text"""

    def __init__(self, html: str):
        self.html = html

    def save(self, path: str | Path) -> int:
        """Write the page to a file. path: of the file, by convention ending in .html. Returns bytes written. Raises
        OSError if the file cannot be written."""
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
    kept, shapes, citation = kept_motions(session.history), Shapes(), cite(session)
    told = {"name": SCENE, "title": title or citation.title, "says": TAKEN_OVER, "scene": SCENE}
    taken_over = told | describe_method(first)["lab"]  # what the lab begins with where it goes on
    data = {
        "robot": describe_robot(world.scene.robot, shapes),
        "hulls": describe_hulls(world.scene.robot),
        "scenes": {SCENE: _scene(session, kept, shapes)},
        "presets": [taken_over] if can_compute(world.scene) else [],
        "run": record(session, kept, chosen),
        "words": cards(),
    }
    return Replay(_page(title, citation, data, shapes.packed))


def _scene(session: Session, kept: Sequence[int], shapes: Shapes) -> dict[str, Any]:
    """The session's scene for the lab, with the body points that it has now, begun where the session began."""
    world, history = session.world, session.history
    first, last = history[0], history[kept[-1]]
    ends = [posture for each in (first, last) for posture in (each.theta, each.theta_demo)]
    scene = describe_world(world, {str(len(world.body)): world.body})
    scene |= {"demonstrator": first.theta_demo.tolist(), "start": first.theta.tolist()}
    return scene | {"stage": describe_stage(world, shapes, ends)}


def _page(title: str, citation: Citation, data: dict[str, Any], meshes: bytes) -> str:
    last, title = data["run"]["snapshots"][-1]["motion"], title or citation.title
    explained = {f"ask_{key}": ask(key) for key in ASKED}
    told = {
        "title": escape(title),
        "conditions": escape(citation.conditions),
        "motions": last,
        "made": count_motions(last),
        "software": escape(citation.software),
        "repeated": _repeated(citation),
        "line": escape(citation.command or citation.software),
    }
    parts = {name: Template(text).substitute(told, **explained) for name, text in _parts().items()}
    more_styles = "\n".join((WORDS_CSS, SCRIPTS.joinpath("view", "replay.css").read_text("utf-8")))
    return lab_html(f"{title} · a viewimit replay", data, meshes, more_styles, **parts, **explained)


def lab_html(title: str, data: dict[str, Any], meshes: bytes, more_styles: str = "", **parts: str) -> str:
    """Write the lab's page as one file. title: of the window; data: what app/lab/view/main.js unpacks; meshes: bytes of
    those that the data describe; more_styles: CSS; parts: HTML by the places of lab.html, which else are empty."""
    page = Template(SCRIPTS.joinpath("view", "lab.html").read_text("utf-8"))
    filled = page.substitute(
        dict.fromkeys(PLACES, ""),
        title=escape(title),
        version=escape(__version__),
        styles="\n".join((styles(*STYLES), more_styles)),
        data=packed(msgspec.json.encode(data)),
        meshes=packed(meshes),
        script=packed(_script().encode()),
        **parts,
    )
    return with_policy(filled, _script())


@cache
def styles(*names: str) -> str:
    """Return the style sheet of a page: colours of both schemes, letters, drawings, and these files of app/lab/."""
    own = "\n".join(SCRIPTS.joinpath(name).read_text("utf-8") for name in names)
    schemes = f":root{{{variables(False)}}}:root[data-scheme=dark]{{{variables(True)}}}"
    return "\n".join((schemes, font_faces(), DRAWING_CSS, own))


def _repeated(citation: Citation) -> str:
    """Build the texts that repeat the session, each with a button that copies it."""
    parts = []
    for name, text in (("As a command", citation.command), ("In Python", citation.python)):
        if text is not None:
            button = f'<button type="button" class="copy" aria-label="Copy: {name}">Copy</button>'
            parts.append(f'<h2>{name}</h2>{button}<pre tabindex="0">{escape(text)}</pre>')
    return "".join(parts) or "<p>It goes on from what cannot be said in a few words.</p>"


@cache
def _parts() -> dict[str, str]:
    """HTML of a replay, by its place in lab.html."""
    text = SCRIPTS.joinpath("view", "replay.html").read_text("utf-8")
    return dict(re.findall(r"<!-- (\w+) -->\n(.*?)(?=<!-- |\Z)", text, re.S))


@cache
def _script() -> str:
    return bundle("view/main.js")
