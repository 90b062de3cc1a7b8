"""The documentation's own directives, for Sphinx: examples that are executed when they are read, the page's drawings
with links to their states, references made from the code itself."""

from importlib import import_module
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util.typing import ExtensionMetadata


def setup(app: Sphinx) -> ExtensionMetadata:
    for path in sorted(Path(__file__).parent.glob("[!_]*.py")):
        part = import_module(f"{__name__}.{path.stem}")
        if hasattr(part, "add_to"):
            part.add_to(app)
    return {"parallel_read_safe": False, "parallel_write_safe": True}
