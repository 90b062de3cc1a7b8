"""Lessons from their files: the shipped ones in their order, or those of a lecturer. A file is checked whole when it is
read. An error names the file, the line and the field."""

import math
import re
import stat
import zlib
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import msgspec
from viewimit.assets import ROOT

from .checks import Faults, faults, faults_in_scenes, faults_of_questions
from .format import Lesson, Questions, Step

FOLDER = ROOT / "lessons"
ORDER = ("ray", "tour", "limits", "jacobian", "motion", "sign")
MAX_BYTES = 200_000
_HEAD = re.compile(r"^\s*\[+\s*([^\]]+?)\s*\]+\s*(#.*)?$")
_FIELD = re.compile(r"\.?([A-Za-z_]\w*)|\[(\d+)\]")
T = TypeVar("T")


@cache
def shipped() -> dict[str, Lesson]:
    """Return the shipped lessons by name, in their order."""
    return {name: load(FOLDER / f"{name}.toml") for name in ORDER}


@cache
def questions() -> Questions:
    """Return the eight questions that are asked before and after."""
    return _read(FOLDER / "questions.toml", Questions, lambda found: faults_of_questions(found, shipped()))


def load(path: Path, tried: bool = False) -> Lesson:
    """Read a lesson file. tried: check it in its scenes as well, which takes a moment. Raises ValueError for a file
    that is no lesson, naming file, line and field; OSError."""
    lesson = _read(path, Lesson, faults)
    if tried:
        for where, what in faults_in_scenes(lesson):
            raise ValueError(_located(path, _text_of(path), where, what))
    return lesson


def own(paths: Iterable[Path]) -> dict[str, Lesson]:
    """Read a lecturer's lessons, each checked in its scenes. Their names contain a checksum: a changed file is another
    lesson, and answers to the old one do not count."""
    lessons = {}
    for path in paths:
        lesson = load(path, tried=True)
        stem = re.sub(r"[^a-z0-9]+", "-", path.stem.lower())[:16].strip("-")
        lessons[f"{stem}-{zlib.crc32(msgspec.msgpack.encode(lesson)):08x}"] = lesson
    return lessons


def find(given: str) -> tuple[str, Lesson]:
    """Return name and lesson of what a command was given: a shipped one by name, or a file. Raises ValueError."""
    if given in ORDER:
        return given, shipped()[given]
    path = Path(given)
    if path.suffix != ".toml" and not path.exists():
        raise ValueError(f"no lesson {given!r}; there are {', '.join(ORDER)}, or give a .toml file")
    return next(iter(own([path]).items()))


def _read(path: Path, kind: type[T], check: Callable[[T], Faults]) -> T:
    text = _text_of(path)
    try:
        fields = msgspec.toml.decode(text)
    except RecursionError:
        raise ValueError(f"{path}: too many brackets within brackets") from None
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    for where in _not_finite(fields):
        raise ValueError(_located(path, text, where, "must be a finite number"))
    try:
        found = msgspec.convert(fields, kind)
    except msgspec.ValidationError as error:
        what, _, where = str(error).partition(" - at `$")
        raise ValueError(_located(path, text, where.rstrip("`"), _with_names(what, kind, where))) from None
    for where, what in check(found):
        raise ValueError(_located(path, text, where, what))
    return found


def _with_names(what: str, kind: type, where: str) -> str:
    """Add the fields that exist to a message about an unknown one, and the kinds to one about an unknown kind."""
    if "unknown field" in what and kind is Lesson:
        table = Step if where.startswith(".step") else Lesson
        if re.fullmatch(r"(\.step\[[\d.]*\])?`?", where):
            return f"{what}; there are {', '.join(table.__struct_fields__)}"
    if "Invalid value" in what and where.rstrip("`").endswith(".ask.kind"):
        return f"{what}; there are choice, place, number, do, pose, predict, bet"
    return what


def _text_of(path: Path) -> str:
    if not stat.S_ISREG(path.stat().st_mode):
        raise ValueError(f"{path}: is not a file")
    with path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise ValueError(f"{path}: is larger than {MAX_BYTES // 1000} kB, which no lesson is")
    try:
        return data.decode()
    except UnicodeDecodeError as error:
        line = data[: error.start].count(b"\n") + 1
        raise ValueError(f"{path}, line {line}: is not in UTF-8") from None


def _not_finite(value: Any, where: str = "") -> Iterator[str]:
    """Yield the fields of numbers that are not finite."""
    if isinstance(value, float) and not math.isfinite(value):
        yield where
    inside = {f".{name}": inner for name, inner in value.items()} if isinstance(value, dict) else {}
    inside |= {f"[{k}]": inner for k, inner in enumerate(value)} if isinstance(value, list) else {}
    for place, inner in inside.items():
        yield from _not_finite(inner, where + place)


def _located(path: Path, text: str, where: str, what: str) -> str:
    line, field = line_of(text, where), where.lstrip(".")
    return f"{path}, line {line}: {field + ': ' if field else ''}{what}"


def line_of(text: str, where: str) -> int:
    """Return the line, from 1, of a field such as .step[2].ask.kind, or of the nearest table around a missing one."""
    keys = [name or int(number) for name, number in _FIELD.findall(where)]
    best, depth = 1, 0
    counts: dict[tuple, int] = {}
    table: list = []
    for number, line in enumerate(text.splitlines(), 1):
        head = _HEAD.match(line)
        if head:
            found = table = _keys_of_table(head[1], line.lstrip().startswith("[["), counts)
        elif re.match(r"^\s*[A-Za-z_][\w-]*\s*=", line):
            found = [*table, line.split("=", 1)[0].strip()]
        else:
            continue
        same = next((i for i, (a, b) in enumerate(zip(found, keys)) if a != b), min(len(found), len(keys)))
        if same in (len(found), len(keys)) and same > depth:
            best, depth = number, same
    return best


def _keys_of_table(name: str, is_array: bool, counts: dict[tuple, int]) -> list:
    """Return the keys of a table's head, with the numbers of arrays of tables, which are counted in `counts`."""
    keys: list = []
    parts = [part.strip().strip('"') for part in name.split(".")]
    for i, part in enumerate(parts):
        keys.append(part)
        if is_array and i == len(parts) - 1:
            counts[tuple(keys)] = counts.get(tuple(keys), -1) + 1
        if tuple(keys) in counts:
            keys.append(counts[tuple(keys)])
    return keys
