"""The examples can be imported, and are forgotten after each test."""

import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(autouse=True)
def examples(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLES))
    yield EXAMPLES
    for path in EXAMPLES.glob("*.py"):
        sys.modules.pop(path.stem, None)
