"""Files that a person names: read only if they are files, and no further than a file of their kind may go."""

import errno
import os
import re
import stat
import struct
import tokenize
import zipfile
import zlib
from codecs import BOM_UTF8
from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

MEGABYTE = 1 << 20
MOST_TOML = MEGABYTE
MOST_ARRAYS = 128 * MEGABYTE  # unpacked
MOST_PARTS = 32  # of a name in TOML: the time that a parser takes grows with their square
_PART = rb"(?:\"[^\"\n]*\"|'[^'\n]*'|[\w-]+)[ \t]*"
LONG_NAME = re.compile(rb"(?<![\w-])(?:" + _PART + rb"\.[ \t]*){%d}" % MOST_PARTS)
_STRING = (  # of several lines or of one, with escapes or without; one that does not end is no TOML
    rb'"""[^"\\]*(?:(?:\\.|"(?!""))[^"\\]*)*"{0,5}',
    rb"'''[^']*(?:'(?!'')[^']*)*'{0,5}",
    rb'"[^"\\\n]*(?:\\.[^"\\\n]*)*"?',
    rb"'[^'\n]*'?",
)
PARTS_NOTHING = re.compile(
    b"|".join((rb"#[^\n]*", *_STRING)), re.DOTALL
)  # comments and strings, whatever dots they have
DAMAGED = (
    zipfile.BadZipFile, zlib.error, struct.error, tokenize.TokenError, EOFError, NotImplementedError, RuntimeError,
    SyntaxError, ValueError, TypeError, MemoryError,
)  # fmt: skip


class TooLarge(ValueError):
    """The message names the file, and what to do."""


def is_text(place: object) -> bool:
    """Whether it is what a file says, in place of a path: that ends with a line, and no path does."""
    return str(place).endswith("\n")


def file_name(place: str) -> str:
    """Of a path of any system; a name stays, and so does what a file says."""
    return place if is_text(place) else place.replace("\\", "/").rsplit("/", 1)[-1]


def require_file(path: Path, most_bytes: int) -> None:
    """Raises OSError for what is not there, ValueError for what is no file, or too large: nothing is opened, so that
    nobody waits for a pipe."""
    found = os.stat(path)
    if stat.S_ISDIR(found.st_mode):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        raise ValueError(f"{path}: a pipe or device, not a file: save what comes out of it as one")
    if found.st_size > most_bytes:
        raise ValueError(f"{path}: it has {found.st_size / MEGABYTE:,.0f} MB, more than {most_bytes / MEGABYTE:g}")


def read_bytes(path: Path, most_bytes: int) -> bytes:
    """All of a file. Raises as `require_file`, also where it grows meanwhile, or never ends."""
    require_file(path, most_bytes)
    with path.open("rb") as file:
        content = file.read(most_bytes + 1)
    if len(content) > most_bytes:
        raise ValueError(f"{path}: it has more than {most_bytes / MEGABYTE:g} MB")
    return content


def read_toml(path: Path) -> bytes:
    """A file for `parse_toml`. Raises as `read_bytes`."""
    return read_bytes(path, MOST_TOML)


def parse_toml(content: bytes, kind: type = dict):
    """Raises ValueError for what is none of that kind, or nests so that no parser should follow."""
    if LONG_NAME.search(PARTS_NOTHING.sub(_emptied, content)):
        raise ValueError(f"a name of more than {MOST_PARTS} parts")
    try:
        return msgspec.toml.decode(content.removeprefix(BOM_UTF8), type=kind)  # some editors begin a file with it
    except RecursionError:
        raise ValueError("it nests too deeply") from None


def _emptied(found: re.Match[bytes]) -> bytes:
    """A string as one part of a name, which it may be, and nothing of a comment."""
    return b"" if found[0].startswith(b"#") else b'""'


def read_npz(path: Path) -> dict[str, NDArray]:
    """Arrays by name. Raises OSError, ValueError for what is no .npz file of numbers, or too large once unpacked."""
    require_file(path, MOST_ARRAYS)
    try:
        with zipfile.ZipFile(path) as members:
            unpacked = sum(member.file_size for member in members.infolist())
        if unpacked > MOST_ARRAYS:
            raise TooLarge(f"{path}: it unpacks to {unpacked / MEGABYTE:,.0f} MB: keep fewer frames in a file")
        with np.load(path) as file:
            return {name: file[name] for name in file.files}
    except TooLarge:
        raise
    except DAMAGED:  # RecursionError is a RuntimeError
        raise ValueError(f"{path}: not an .npz file of numbers") from None


# What files say, as a terminal and a message may be given it.

MOST_SAID, MOST_NAME = 900, 80  # characters of a message that quotes what a file says, and of a name


def printable(text: str, most: int = MOST_SAID, keep: str = "") -> str:
    """Of what a file says no more than a person would read, and nothing that a terminal would obey: characters that do
    so are escaped, but those to keep."""
    if len(text) > most:
        text = f"{text[: most // 2]} … {text[-most // 2 :]}"
    return "".join(one if one.isprintable() or one in keep else ascii(one)[1:-1] for one in text)
