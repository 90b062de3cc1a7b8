"""Docstrings of the code, plain text with `code`, indented blocks and numpydoc's sections, for autodoc and napoleon."""

import re
from typing import Any

from sphinx.application import Sphinx

SECTIONS = {  # those that napoleon turns into tables of fields
    "Parameters",
    "Returns",
    "Yields",
    "Raises",
    "Attributes",
    "Notes",
    "References",
    "Examples",
    "See Also",
}
RULE = re.compile("-{3,}")  # under the name of a section
MARKUP = re.compile(r"(\*\*[^*`]+\*\*)|([\\*|_])")  # bold text stays
BACK = re.compile(r'<a class="viewcode-back".*?</a>')


def as_markup(lines: list[str]) -> list[str]:
    """Rewrite a docstring as reStructuredText that shows its text as it stands, with numpydoc's sections untouched."""
    made, block, section = [], False, False
    for k, line in enumerate(lines):
        if RULE.fullmatch(line.strip()) and k and made[-1].strip():
            name = lines[k - 1].strip()
            section = name in SECTIONS
            made[-1:] = [name, line] if section else [f".. rubric:: {name}", ""]
            continue
        indented = line.startswith("    ") and not section
        if indented and not block and made and not made[-1].strip():
            made += ["::", ""]
            block = True
        elif line.strip() and not indented:
            block = False
        made.append(line if block else _escaped(line))
    return made


def _escaped(line: str) -> str:
    """Escape reStructuredText's markup, except in backticks, which is code."""
    parts = line.split("`")
    if len(parts) % 2 == 0:  # one without a partner, as in "a `Result`;" cut over two lines
        return _plain(line.replace("`", r"\`"))
    return "".join(f"``{part}``" if k % 2 and part else _plain(part) for k, part in enumerate(parts))


def _plain(text: str) -> str:
    return MARKUP.sub(lambda found: found[1] or "\\" + found[2], text)


def _process(app: Sphinx, what: str, name: str, found: object, options: object, lines: list[str]) -> None:
    lines[:] = as_markup(lines)


def _without_links_back(app: Sphinx, page: str, template: str, context: dict[str, Any], doctree: object) -> None:
    """Take out viewcode's links from source to reference: it names all objects of a module after the first one's."""
    if page.startswith("_modules/"):
        context["body"] = BACK.sub("", context["body"])


def add_to(app: Sphinx) -> None:
    app.setup_extension("sphinx.ext.autodoc")
    app.connect("autodoc-process-docstring", _process, priority=400)  # before napoleon
    app.setup_extension("sphinx.ext.napoleon")
    app.setup_extension("sphinx.ext.viewcode")
    app.connect("html-page-context", _without_links_back)
