"""Docstrings as they are written here, plain text with `code`, indented blocks and numpydoc's sections, for autodoc."""

import re

from sphinx.application import Sphinx

RULE = re.compile("-{4,}")  # under the name of a section, whose items are a definition list as they stand
MARKUP = re.compile(r"([\\*|_])")


def as_markup(lines: list[str]) -> list[str]:
    """reStructuredText that shows just this."""
    made, block, section = [], False, False
    for k, line in enumerate(lines):
        if RULE.fullmatch(line):
            made[-1:], section = [f".. rubric:: {lines[k - 1]}", ""], True
            continue
        indented = line.startswith("    ")
        if indented and not block and made and not made[-1].strip():
            made += ["::", ""]
            block = True
        elif line.strip() and not indented:
            block = False
        if section and not indented:  # an item, with or without a definition under it
            made.append("")
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
