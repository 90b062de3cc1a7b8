"""What the digits of a result depend on beside its settings: this library's code and numpy's version."""

import hashlib
from functools import cache
from pathlib import Path

import numpy as np

from ... import __version__
from ...assets import ROOT

LIBRARY = Path(__file__).parents[2]
NOT_OF_RESULTS = {"app", "assets", "commands", "drawing"}  # show what was found, and change no digit of it


class OtherCode(Exception):
    """Results from here would be of another library."""


@cache
def code() -> str:
    """Such as "viewimit 0.1.0 (3f0c9a81d2b4), numpy 2.1.0": of the sources and scenes of the library."""
    found = hashlib.sha256()
    sources = [path for path in LIBRARY.rglob("*.py") if path.relative_to(LIBRARY).parts[0] not in NOT_OF_RESULTS]
    for path in [*sorted(sources), *sorted(ROOT.rglob("*.toml")), *sorted(ROOT.rglob("*.urdf"))]:
        found.update(path.name.encode() + b"\0" + path.read_bytes().replace(b"\r\n", b"\n"))
    return f"viewimit {__version__} ({found.hexdigest()[:12]}), numpy {np.__version__}"


def require_code(expected: str) -> None:
    """Raises OtherCode for any but that."""
    if code() != expected:
        raise OtherCode(f"has {code()}, and the study is of {expected}: install the same there")
