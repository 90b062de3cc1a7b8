"""Notebooks as pages: they are read as Markdown whose Python is executed, as all examples are."""

import json

from sphinx.application import Sphinx

ENDING = ".ipynb"


def as_markdown(notebook: str) -> str:
    """notebook: the file's text; outputs in it are not looked at."""
    parts = []
    for cell in json.loads(notebook)["cells"]:
        source = "".join(cell["source"])
        parts.append(source if cell["cell_type"] == "markdown" else f"````{{run-python}}\n{source}\n````")
    return "\n\n".join(parts)


def _read(app: Sphinx, page: str, source: list[str]) -> None:
    if str(app.env.doc2path(page)).endswith(ENDING):
        origin = f"This page is a notebook, `docs/{page}{ENDING}`, as it ran when these pages were built."
        source[0] = f"{as_markdown(source[0])}\n\n---\n\n{origin}\n"


def add_to(app: Sphinx) -> None:
    app.connect("source-read", _read)
