"""The browser's part of a page in one file: modules as one script that needs no loader, and data as text."""

import base64
import re
import zlib
from pathlib import Path

from ...assets import ROOT

SCRIPTS = ROOT.parent / "app" / "lab"  # beside assets/, in a clone and where it is installed
IMPORT = re.compile(r'^import (\{[^}]*\}) from "(\./|\.\./)([^"]+)";\n', re.M)
REEXPORT = re.compile(r'^export (\{[^}]*\}) from "(\./|\.\./)([^"]+)";\n', re.M)
EXPORT = re.compile(r"^export (?:async )?(?:const|let|function|class) (\w+)", re.M)


def bundle(entry: str) -> str:
    """Return ES modules as one script: each becomes a function that returns its exports, in the order of imports.

    Parameters
    ----------
    entry
        The module that is run last, a path in app/lab/.

    Notes
    -----
    Modules import by name, from relative paths, at the top: `import {a, b as c} from "./x.js";`. They export
    declarations, one name each, or names of other modules. No module imports in a circle.
    """
    parts: dict[Path, str] = {}

    def add(path: Path) -> str:
        if path not in parts:
            text = re.sub(r"^ *(/\*\*.*?\*/|// .*?$)\n?", "", path.read_text("utf-8"), flags=re.M | re.S)
            names = EXPORT.findall(text)
            module = lambda match: add((path.parent / match[2] / match[3]).resolve())
            text = IMPORT.sub(lambda match: f"const {match[1].replace(' as ', ': ')} = {module(match)};\n", text)
            for match in REEXPORT.finditer(text):
                names += [name.strip() for name in match[1].strip("{}").split(",")]
            text = REEXPORT.sub(lambda match: f"const {match[1]} = {module(match)};\n", text)
            text = re.sub(r"^export ", "", text, flags=re.M)
            name = f"MODULES[{path.name!r}]"
            parts[path] = text if path == first else f"{name} = (() => {{\n{text}return {{{', '.join(names)}}};\n}})();"
        return f"MODULES[{path.name!r}]"

    first = (SCRIPTS / entry).resolve()
    add(first)
    return '"use strict";\nconst MODULES = {};\n' + "\n".join(parts.values())


def packed(data: bytes) -> str:
    """Return bytes, compressed, as text that a script element holds."""
    return base64.b64encode(zlib.compress(data, 9)).decode()
