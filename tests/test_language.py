"""Texts that people see are translated: no name hides gettext's `_`, and the catalog of texts is complete."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SOURCES = sorted(path for folder in ("viewimit", "app") for path in (ROOT / folder).rglob("*.py"))
OF_DATA = (ROOT / "viewimit" / "drawing" / "glossary.py", ROOT / "app" / "static" / "__init__.py")
TRANSLATED = [path for path in SOURCES if "language import" in path.read_text("utf-8")]


@pytest.mark.parametrize("path", TRANSLATED, ids=lambda path: path.stem)
def test_nothing_hides_the_translator(path):
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        assigned = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id == "_"
        defined = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name == "_"
        assert not assigned and not defined, node.lineno
        assert not (isinstance(node, ast.arg) and node.arg == "_"), node.lineno


@pytest.mark.parametrize("path", TRANSLATED, ids=lambda path: path.stem)
def test_marked_texts_are_literals(path):
    """What is not written in the code is not in the catalog, but for texts that are read from files."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in ("_", "ngettext"):
            texts = node.args[:2] if node.func.id == "ngettext" else node.args
            assert path in OF_DATA or all(isinstance(text, ast.Constant) for text in texts), node.lineno


def test_the_catalog_is_up_to_date():
    pytest.importorskip("babel")
    from viewimit.assets.build_catalog import template

    written = (ROOT / "assets" / "locale" / "viewimit.pot").read_text("utf-8")
    assert template() == written, "run python -m viewimit.assets.build_catalog"
