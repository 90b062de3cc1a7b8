"""The gallery: replays of docs/gallery.toml, each of a run that repeats itself to the last bit, with their pictures."""

import html
import shutil
from pathlib import Path
from typing import Any

import msgspec
from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from viewimit import Session, Settings, replay
from viewimit.loop.settings import PAPER_FIELDS

DOCS = Path(__file__).parents[1]
FOLDER = "gallery"  # beside the pages; in docs/, of the pictures that `python docs/pictures.py gallery` makes


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """name: of the file; robot: a URDF beside the table, instead of a scene; motions: the largest number of steps."""

    name: str
    title: str
    caption: str
    settings: dict[str, Any]
    motions: int
    robot: str | None = None

    def run(self) -> Session:
        """Raises ValueError for settings that cannot be."""
        settings = msgspec.convert({**PAPER_FIELDS, **self.settings}, Settings)
        if self.robot is not None:
            settings = msgspec.structs.replace(settings, scene=str(DOCS / self.robot))
        session = Session(settings)
        session.run(self.motions)
        return session


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    replay: tuple[Entry, ...]


def entries() -> tuple[Entry, ...]:
    return msgspec.toml.decode((DOCS / "gallery.toml").read_bytes(), type=Table).replay


def build_gallery(folder: Path) -> str:
    """Write each replay and its picture into a folder, made if need be → HTML of the list, with links to files of that
    folder. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    items = []
    for entry in entries():
        session = entry.run()
        size = replay(session, entry.title).save(folder / f"{entry.name}.html")
        picture = DOCS / FOLDER / f"{entry.name}.webp"
        if picture.is_file():
            shutil.copy(picture, folder)
        items.append(_item(entry, session, size))
    return f'<ul class="gallery">\n{"".join(items)}</ul>\n'


def _item(entry: Entry, session: Session, size: int) -> str:
    title, motions = html.escape(entry.title), session.snapshot.motion
    image = f'<img src="{FOLDER}/{entry.name}.webp" alt="" width="640" height="400" loading="lazy">'
    return (
        f'<li><a href="{FOLDER}/{entry.name}.html">{image}<b>{title}</b></a>'
        f"<p>{html.escape(entry.caption)}</p><small>{motions} steps, {size / 1e6:.2f} MB</small></li>\n"
    )


class Gallery(SphinxDirective):
    def run(self) -> list[nodes.Node]:
        return [nodes.raw("", build_gallery(Path(self.env.app.outdir) / FOLDER), format="html")]


class Replay(SphinxDirective):
    """One replay of the gallery, in a frame of its own: `replay NAME`."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Raises an error that names the replays, for an unknown name."""
        found = {entry.name: entry for entry in entries()}
        entry = found.get(self.arguments[0])
        if entry is None:
            raise self.error(f"no replay {self.arguments[0]}: there are {', '.join(found)}")
        frame = f'<iframe class="replay" src="{FOLDER}/{entry.name}.html" title="{html.escape(entry.title)}"></iframe>'
        return [nodes.raw("", frame, format="html")]


def add_to(app: Sphinx) -> None:
    app.add_directive("gallery", Gallery)
    app.add_directive("replay", Replay)
