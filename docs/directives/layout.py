"""The folders of the source with all their files, each by the first sentence of its own description."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

ROOT = Path(__file__).parents[2]
PARTS = ("viewimit", "app", "studies")
SENTENCE = re.compile(r"(?<!Figs)(?<!Fig)(?<!Eqs)(?<!Eq)(?<!Sec)\.\s+(?=[A-Z])")  # where one ends
OPENING = re.compile(r"\s*/\*\*(.*?)\*/", re.DOTALL)  # the comment that begins a script


def description(path: Path) -> str:
    """Return the first sentence of a module's docstring, or of the comment that begins a script."""
    text = path.read_text("utf-8")
    if path.suffix == ".py":
        words = ast.get_docstring(ast.parse(text)) or ""
    else:
        found = OPENING.match(text)
        words = re.sub(r"^\s*\*", "", found[1], flags=re.MULTILINE) if found else ""
    paragraph = " ".join(words.strip().split("\n\n")[0].split())
    return SENTENCE.split(paragraph)[0].rstrip(":.").replace("|", r"\|")


def folders(part: Path) -> Iterator[Path]:
    """Yield a folder and those in it that hold source, in the order of their names."""
    if any(part.glob("*.py")) or any(part.glob("*.js")):
        yield part
    for inner in sorted(one for one in part.iterdir() if one.is_dir() and one.name != "__pycache__"):
        yield from folders(inner)


def rows(folder: Path) -> Iterator[str]:
    """Yield the lines of a folder: its heading, and a table of its files."""
    first = folder / "__init__.py"
    yield from (f"**`{folder.relative_to(ROOT).as_posix()}/`** {description(first) if first.exists() else ''}", "")
    files = sorted(one for one in folder.iterdir() if one.suffix in (".py", ".js") and one != first)
    if files:
        yield from ("| file | what |", "|---|---|")
        yield from (f"| `{one.name}` | {description(one)} |" for one in files)
        yield ""


class Layout(SphinxDirective):
    """All folders of the package, of the page and of the studies."""

    def run(self) -> list[nodes.Node]:
        place = nodes.container(classes=["layout"])
        lines = [line for part in PARTS for folder in folders(ROOT / part) for line in rows(folder)]
        self.state.nested_parse(StringList(lines, __file__), 0, place)
        return [place]


def add_to(app: Sphinx) -> None:
    app.add_directive("layout", Layout)
