"""Examples are executed when they are read, and what is shown of them is what they gave. One that fails ends the build.

All of a page's examples go on from each other, in one namespace and one empty folder.
"""

import ast
import contextlib
import io
import os
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.util.docutils import SphinxDirective, SphinxRole

from viewimit.commands.cli import main

EXAMPLES = Path(__file__).parents[2] / "examples"
NOTHING = object()


class Workspace:
    """Where the examples of one page are executed."""

    def __init__(self) -> None:
        self._made = tempfile.TemporaryDirectory()
        self.folder = Path(self._made.name)
        self.module = ModuleType("example")
        self.imported = set(sys.modules)

    @contextlib.contextmanager
    def entered(self) -> Iterator[None]:
        """In its folder, from which it can import, as from examples/."""
        before, path, out = Path.cwd(), list(sys.path), sys.modules.get("example")
        os.chdir(self.folder)
        sys.path[:0] = [str(self.folder), str(EXAMPLES)]
        sys.modules["example"] = self.module
        try:
            yield
        finally:
            os.chdir(before)
            sys.path[:] = path
            if out is None:
                del sys.modules["example"]

    def close(self) -> None:
        """What its own files defined is forgotten with them."""
        for name in set(sys.modules) - self.imported:
            if str(getattr(sys.modules[name], "__file__", "")).startswith(str(self.folder)):
                del sys.modules[name]
        self._made.cleanup()


workspaces: dict[str, Workspace] = {}  # by page


def workspace(page: str) -> Workspace:
    if page not in workspaces:
        workspaces[page] = Workspace()
    return workspaces[page]


def execute(code: str, where: Workspace, name: str) -> tuple[str, Any]:
    """What it printed, and the value of its last line, NOTHING if that is no expression. name: for tracebacks."""
    tree = ast.parse(code, name)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    value: Any = NOTHING
    with where.entered(), contextlib.redirect_stdout(io.StringIO()) as out:
        exec(compile(tree, name, "exec"), vars(where.module))
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), name, "eval"), vars(where.module))
    return out.getvalue(), NOTHING if value is None else value


def shown(printed: str, value: Any) -> list[nodes.Node]:
    """Nodes of what an example gave."""
    found: list[nodes.Node] = []
    svg, html = getattr(value, "_repr_svg_", None), getattr(value, "_repr_html_", None)  # what notebooks ask for, too
    if value is not NOTHING and svg is None and html is None:
        printed += f"{value!r}\n"
    if printed:
        found.append(literal(printed.rstrip("\n"), "text", "output"))
    if svg is not None:
        found.append(nodes.raw("", f'<div class="drawn">{_alone(svg())}</div>', format="html"))
    elif html is not None:
        found.append(nodes.raw("", f'<div class="table-wrapper">{html()}</div>', format="html"))
    return found


def _alone(svg: str) -> str:
    """In a tree of its own, so that its stylesheet holds for nothing else."""
    fitted = "svg{width:100%!important;height:auto!important}"
    return f'<div class="alone"><template shadowrootmode="open"><style>{fitted}</style>{svg}</template></div>'


def literal(text: str, language: str, *classes: str) -> nodes.literal_block:
    block = nodes.literal_block(text, text, classes=list(classes))
    block["language"] = language
    return block


class Python(SphinxDirective):
    """Python. With :hidden: only what it gives is shown."""

    has_content = True
    option_spec = {"hidden": directives.flag}

    def run(self) -> list[nodes.Node]:
        code = "\n".join(self.content)
        where = f"{self.env.docname}, line {self.lineno}"
        try:
            found = shown(*execute(code, workspace(self.env.docname), where))
        except Exception as error:
            raise ExtensionError(f"{where}: an example fails: {error!r}") from error
        return found if "hidden" in self.options else [literal(code, "python"), *found]


class Value(SphinxRole):
    """The value of a Python expression, which knows what the page's examples have done, as text of a sentence."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        where = f"{self.env.docname}, line {self.lineno}"
        try:
            _, value = execute(self.text, workspace(self.env.docname), where)
        except Exception as error:
            raise ExtensionError(f"{where}: {self.text} fails: {error!r}") from error
        return [nodes.Text(str(value))], []


class Console(SphinxDirective):
    """Lines that begin with `$ viewimit`, which know what the page's Python has done, or with `$ python FILE`, which
    do not; what they print is added. :status: is the last one's, 0 unless it is given; messages are shown where it is
    not 0. :short: shows so many characters of an output at most."""

    has_content = True
    option_spec = {"status": directives.nonnegative_int, "short": directives.positive_int}

    def run(self) -> list[nodes.Node]:
        printed, place = [], workspace(self.env.docname)
        commands = [line for line in self.content if line.strip()]
        for k, line in enumerate(commands):
            where = f"{self.env.docname}, line {self.lineno}: {line}"
            prompt, program, *words = shlex.split(line)
            if prompt != "$" or program not in self.PROGRAMS:
                raise ExtensionError(f"{where}: not a line of `$ viewimit …` or `$ python …`")
            status, out, err = self.PROGRAMS[program](words, place)
            expected = self.options.get("status", 0) if k == len(commands) - 1 else 0
            if status != expected:
                raise ExtensionError(f"{where}: ends with status {status}, not {expected}: {err}")
            output = (out + (err if status else "")).rstrip("\n")
            most = self.options.get("short", len(output))
            printed += [line, *([output[:most] + ("…" if len(output) > most else "")] if output else [])]
        return [literal("\n".join(printed), "console", "console")]

    @staticmethod
    def _viewimit(words: list[str], place: Workspace) -> tuple[int, str, str]:
        with (
            place.entered(),
            contextlib.redirect_stdout(io.StringIO()) as out,
            contextlib.redirect_stderr(io.StringIO()) as err,
        ):
            try:
                status = main(words)
            except SystemExit as ended:  # argparse
                status = int(ended.code or 0)
        return status, out.getvalue(), err.getvalue()

    @staticmethod
    def _python(words: list[str], place: Workspace) -> tuple[int, str, str]:
        ran = subprocess.run([sys.executable, *words], cwd=place.folder, capture_output=True, text=True)
        return ran.returncode, ran.stdout, ran.stderr

    PROGRAMS = {"viewimit": _viewimit, "python": _python}


class File(SphinxDirective):
    """A file of the page's folder, shown with its name. :from: copies one of the repository in its place, unseen."""

    required_arguments = 1
    has_content = True
    option_spec = {"from": directives.unchanged, "language": directives.unchanged}

    def run(self) -> list[nodes.Node]:
        name, content = self.arguments[0], "\n".join(self.content) + "\n"
        path = workspace(self.env.docname).folder / name
        if "from" in self.options:
            path.write_bytes((Path(self.env.app.srcdir).parent / self.options["from"]).read_bytes())
            return []
        path.write_text(content, "utf-8")
        block = literal(content.rstrip("\n"), self.options.get("language", path.suffix.removeprefix(".") or "text"))
        wrapped = nodes.container("", literal_block=True, classes=["literal-block-wrapper"])
        wrapped += [nodes.caption(name, name), block]
        return [wrapped]


def _close(app: Sphinx, error: Exception | None) -> None:
    while workspaces:
        workspaces.popitem()[1].close()


def add_to(app: Sphinx) -> None:
    app.add_directive("run-python", Python)
    app.add_role("value", Value())
    app.add_directive("run-console", Console)
    app.add_directive("file", File)
    app.connect("build-finished", _close)
