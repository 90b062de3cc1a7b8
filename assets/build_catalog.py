"""Writes locale/viewimit.pot: all texts that people see, from which translators start.

    python -m viewimit.assets.build_catalog

Run it again after any change of a text. It needs Babel, of the group `test`.
"""

import argparse
import ast
import io
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from babel.messages.catalog import Catalog
from babel.messages.pofile import write_po
from viewimit.app.static import CONTENT, MARKED, SCRIPTS
from viewimit.assets import ROOT

from viewimit.drawing import glossary
from viewimit.language import DOMAIN

CODE = ROOT.parent
FOLDERS = ("viewimit", "app")
STYLES = ("app/static", "viewimit/drawing/styles")
MARKS = {"_": 1, "ngettext": 2}  # functions, and how many texts each takes
CHANGING = ("POT-Creation-Date", "PO-Revision-Date", "Generated-By")  # of the header, at each run or by Babel's version


def sources() -> list[Path]:
    """Return the files of Python code that may hold marked texts."""
    return sorted(path for folder in FOLDERS for path in (CODE / folder).rglob("*.py"))


def texts() -> Iterator[tuple[Path, str | tuple[str, ...]]]:
    """Yield the file and text of every place; of a text with a plural, both forms."""
    for path in sources():
        for text in sorted(marked(path.read_text("utf-8")), key=str):
            yield path, text
    for name in SCRIPTS:
        path = CODE / "app" / "static" / name
        for literal in MARKED.findall(path.read_text("utf-8")):
            yield path, json.loads(literal)
    for folder in STYLES:
        for path in sorted((CODE / folder).glob("*.css")):
            for text in CONTENT.findall(path.read_text("utf-8")):
                yield path, text
    for entry in glossary.load().values():
        for text in glossary.texts(entry):
            yield glossary.FILE, text


def marked(code: str) -> Iterator[str | tuple[str, ...]]:
    """Yield the texts that Python code marks, also in f-strings, where Babel finds none."""
    calls = (node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Call))
    found = [(call, call.func.id) for call in calls if isinstance(call.func, ast.Name) and call.func.id in MARKS]
    for call, name in found:
        forms = [text.value for text in call.args[: MARKS[name]] if isinstance(text, ast.Constant)]
        if forms:
            yield forms[0] if len(forms) == 1 else tuple(forms)


def catalog() -> Catalog:
    """Collect all texts, in the order of their files."""
    made = Catalog(domain=DOMAIN, project="viewimit", copyright_holder="The viewimit authors", fuzzy=False)
    made.header_comment = "# Texts of viewimit, written by build_catalog.py."
    for path, text in texts():
        made.add(text, locations=[(path.relative_to(CODE).as_posix(), 0)])
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
    argparse.ArgumentParser(description=__doc__).parse_args()
    path = ROOT / "locale" / f"{DOMAIN}.pot"
    path.parent.mkdir(exist_ok=True)
    path.write_text(template(), "utf-8", newline="\n")
    print(f"{len(catalog())} texts in {path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
