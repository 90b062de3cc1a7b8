"""The gallery: replays of docs/gallery.toml, each of a run that repeats itself to the last bit, and a list of them.

`python docs/gallery.py FOLDER` writes all; a documentation's build calls `build_gallery(folder)`.
"""

import argparse
import html
from pathlib import Path
from typing import Any

import msgspec

from viewimit import Session, Settings, replay
from viewimit.loop.settings import PAPER_FIELDS

HERE = Path(__file__).parent
INDEX = "index.fragment.html"


class Entry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """name: of the file; robot: a URDF beside the table, in place of a scene; motions: at most so many."""

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
            settings = msgspec.structs.replace(settings, scene=str(HERE / self.robot))
        session = Session(settings)
        session.run(self.motions)
        return session


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    replay: tuple[Entry, ...]


def entries(path: Path = HERE / "gallery.toml") -> tuple[Entry, ...]:
    return msgspec.toml.decode(path.read_bytes(), type=Table).replay


def build_gallery(folder: Path) -> list[Path]:
    """Write each replay, and INDEX, a list of them with titles and captions → all files. folder: made if need be; links
    in the list are relative to it. Raises OSError."""
    folder.mkdir(parents=True, exist_ok=True)
    written, items = [], []
    for entry in entries():
        session, path = entry.run(), folder / f"{entry.name}.html"
        size = replay(session, entry.title).save(path)
        written.append(path)
        items.append(_item(entry, session, size))
    index = folder / INDEX
    index.write_text(f'<ul class="gallery">\n{"".join(items)}</ul>\n', "utf-8")
    return [*written, index]


def _item(entry: Entry, session: Session, size: int) -> str:
    motions = session.snapshot.motion
    return (
        f'<li><a href="{entry.name}.html">{html.escape(entry.title)}</a>'
        f"<p>{html.escape(entry.caption)}</p><small>{motions} motions, {size / 1e6:.2f} MB</small></li>\n"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write the gallery's replays.")
    parser.add_argument("folder", type=Path)
    for path in build_gallery(parser.parse_args().folder):
        print(f"{path}  {path.stat().st_size / 1e6:.2f} MB")
