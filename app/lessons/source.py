"""Lessons from their files: the shipped ones in their order, or a lecturer's own.

Each is checked whole, so that a fault is told by file, line and field before anybody is taught.
"""

import math
import re
import stat
import zlib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
from viewimit.assets import ROOT

from .checks import faults
from .format import Lesson
from .trial import faults_in_session

FOLDER = ROOT / "lessons"
MOST_BYTES = 200_000
_HEAD = re.compile(r"^\s*\[+\s*([^\]]+?)\s*\]+\s*(#.*)?$")
_PATH = re.compile(r"\.?([A-Za-z_]\w*)|\[(\d+)\]")


@cache
def shipped() -> dict[str, Lesson]:
    """By the names of their files, in order."""
    return {path.stem.split("-", 1)[1]: load(path) for path in sorted(FOLDER.glob("[0-9]-*.toml"))}


def own(paths: Iterable[Path]) -> dict[str, Lesson]:
    """A lecturer's, each tried out. A name tells what is in the file, too: what was answered to another is no answer
    here. Raises as `load` does."""
    lessons = {}
    for path in paths:
        lesson = load(path, tried=True)
        stem = re.sub(r"[^a-z0-9]+", "-", path.stem.lower())[:16].strip("-")
        lessons[f"{stem}-{zlib.crc32(msgspec.msgpack.encode(lesson)):08x}"] = lesson
    return lessons


def load(path: Path, tried: bool = False) -> Lesson:
    """tried: in a session as well, which takes a moment. Raises ValueError that names file, line and field; OSError for
    a file that cannot be read."""
    text = _text_of(path)
    try:
        fields = msgspec.toml.decode(text)
    except RecursionError:
        raise ValueError(f"{path}: brackets within brackets, too many of them") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    for where in _not_finite(fields):
        raise ValueError(_located(path, text, where, "must be a finite number"))
    try:
        lesson = msgspec.convert(fields, Lesson)
    except msgspec.ValidationError as error:
        what, _, where = str(error).partition(" - at `$")
        raise ValueError(_located(path, text, where.rstrip("`"), what)) from None
    for check in (faults, faults_in_session) if tried else (faults,):
        for where, what in check(lesson):
            raise ValueError(_located(path, text, where, what))
    return lesson


def _text_of(path: Path) -> str:
    if not stat.S_ISREG(path.stat().st_mode):
        raise ValueError(f"{path}: is no file")
    with path.open("rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise ValueError(f"{path}: is larger than {MOST_BYTES // 1000} kB, which no lesson is")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise ValueError(f"{path}, line {line}: is not written in UTF-8") from None


def _not_finite(value: Any, where: str = "") -> Iterator[str]:
    """Where there are numbers that are none."""
    if isinstance(value, float) and not math.isfinite(value):
        yield where
    elif isinstance(value, dict):
        for name, inner in value.items():
            yield from _not_finite(inner, f"{where}.{name}")
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            yield from _not_finite(inner, f"{where}[{k}]")


def _located(path: Path, text: str, where: str, what: str) -> str:
    line, field = line_of(text, where), where.lstrip(".")
    return f"{path}, line {line}: {field + ': ' if field else ''}{what}"


def line_of(text: str, where: str) -> int:
    """The line, from 1, of a field such as .step[2].ask.kind, or of the nearest table that it is missing in."""
    keys = [name or int(number) for name, number in _PATH.findall(where)]
    best, depth = 1, 0
    counts: dict[tuple, int] = {}
    here: list = []
    for k, line in enumerate(text.splitlines(), 1):
        head = _HEAD.match(line)
        if head:
            here = _table(head[1], line.lstrip().startswith("[["), counts)
            found = here
        elif re.match(r"^\s*[A-Za-z_][\w-]*\s*=", line):
            found = [*here, line.split("=", 1)[0].strip()]
        else:
            continue
        same = next((i for i, (a, b) in enumerate(zip(found, keys)) if a != b), min(len(found), len(keys)))
        if same == len(found) and same > depth:
            best, depth = k, same
    return best


def _table(name: str, is_array: bool, counts: dict[tuple, int]) -> list:
    """Keys of a table's head, arrays of tables counted."""
    keys: list = []
    parts = [part.strip().strip('"') for part in name.split(".")]
    for i, part in enumerate(parts):
        keys.append(part)
        if is_array and i == len(parts) - 1:
            counts[tuple(keys)] = counts.get(tuple(keys), -1) + 1
        if tuple(keys) in counts:
            keys.append(counts[tuple(keys)])
    return keys
