"""Writes locale/viewimit.pot: all texts that people see, from which translators start.

    python -m viewimit.assets.build_catalog

Run it again after any change of a text. It needs Babel, of the group `test`.
"""

import io
import sys
from collections.abc import Iterator
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.extract import extract_from_file
from babel.messages.pofile import write_po
from viewimit.assets import ROOT

from viewimit.drawing import glossary
from viewimit.language import DOMAIN

CODE = ROOT.parent
FOLDERS = ("viewimit", "app")
EXTRACTORS = {".py": "python", ".js": "javascript"}
CHANGING = ("POT-Creation-Date", "PO-Revision-Date", "Generated-By")  # of the header, at each run or by Babel's version


def sources() -> list[Path]:
    """Return the files that may hold marked texts."""
    found = (path for folder in FOLDERS for path in (CODE / folder).rglob("*"))
    return sorted(path for path in found if path.suffix in EXTRACTORS)


def texts() -> Iterator[tuple[Path, int, str | tuple[str, ...]]]:
    """Return the file, line and text of every place; of a text with a plural, both forms."""
    for path in sources():
        for line, text, _comments, _context in extract_from_file(EXTRACTORS[path.suffix], path):
            yield path, line, text
    for entry in glossary.load().values():
        for text in glossary.texts(entry):
            yield glossary.FILE, 0, text


def catalog() -> Catalog:
    """Collect all texts, in the order of their files."""
    made = Catalog(domain=DOMAIN, project="viewimit", copyright_holder="The viewimit authors", fuzzy=False)
    made.header_comment = "# Texts of viewimit, written by build_catalog.py."
    for path, line, text in texts():
        made.add(text, locations=[(path.relative_to(CODE).as_posix(), line)])
    return made


def template() -> str:
    """Write the catalog as a file; without dates and lines, so that it changes with the texts alone."""
    file = io.BytesIO()
    write_po(file, catalog(), width=0, include_lineno=False)
    kept = (line for line in file.getvalue().decode().splitlines(keepends=True) if not _changes(line))
    return "".join(kept)


def _changes(line: str) -> bool:
    return line.startswith(tuple(f'"{field}' for field in CHANGING))


def main() -> int:
    path = ROOT / "locale" / f"{DOMAIN}.pot"
    path.parent.mkdir(exist_ok=True)
    path.write_text(template(), "utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
