"""Docstrings as they are written here, plain text with `code` and indented blocks, for Sphinx's autodoc."""

import re

from sphinx.application import Sphinx

MARKUP = re.compile(r"([\\*|_])")


def as_markup(lines: list[str]) -> list[str]:
    """reStructuredText that shows just this."""
    made, block = [], False
    for line in lines:
        indented = line.startswith("    ")
        if indented and not block and made and not made[-1].strip():
            made += ["::", ""]
            block = True
        elif line.strip() and not indented:
            block = False
        made.append(line if block else _escaped(line))
    return made


def _escaped(line: str) -> str:
    """All but what stands in backticks, which is code."""
    parts = line.split("`")
    if len(parts) % 2 == 0:  # one without a partner, as in "a `Result`;" cut over two lines
        return MARKUP.sub(r"\\\1", line.replace("`", r"\`"))
    return "".join(f"``{part}``" if k % 2 and part else MARKUP.sub(r"\\\1", part) for k, part in enumerate(parts))


def _process(app: Sphinx, what: str, name: str, found: object, options: object, lines: list[str]) -> None:
    lines[:] = as_markup(lines)


def add_to(app: Sphinx) -> None:
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", _process)
