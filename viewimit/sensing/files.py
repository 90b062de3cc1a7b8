"""Read files that users name, within bounds, and escape their text for messages.

Only regular files are opened, and only up to the size that a file of that kind may have.
"""

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
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

MEGABYTE = 1 << 20
MAX_TOML_BYTES = MEGABYTE
MAX_ARRAY_BYTES = 128 * MEGABYTE  # decompressed
MAX_KEY_PARTS = 32  # parts of a dotted TOML key: parsing time grows with their square
MAX_QUOTED_CHARS, MAX_NAME_CHARS = 900, 80  # of a message that quotes a file, and of a name in it
_KEY_PART = rb"(?:\"[^\"\n]*\"|'[^'\n]*'|[\w-]+)[ \t]*"
LONG_KEY = re.compile(rb"(?<![\w-])(?:" + _KEY_PART + rb"\.[ \t]*){%d}" % MAX_KEY_PARTS)
_STRINGS = (  # multi-line and single-line, with escapes and without; unterminated ones are not TOML
    rb'"""[^"\\]*(?:(?:\\.|"(?!""))[^"\\]*)*"{0,5}',
    rb"'''[^']*(?:'(?!'')[^']*)*'{0,5}",
    rb'"[^"\\\n]*(?:\\.[^"\\\n]*)*"?',
    rb"'[^'\n]*'?",
)
STRINGS_AND_COMMENTS = re.compile(b"|".join((rb"#[^\n]*", *_STRINGS)), re.DOTALL)  # dots in them separate no parts
DAMAGED = (
    zipfile.BadZipFile, zlib.error, struct.error, tokenize.TokenError, EOFError, NotImplementedError, RuntimeError,
    SyntaxError, ValueError, TypeError, MemoryError,
)  # fmt: skip


class TooLarge(ValueError):
    """A file is too large. The message names the file and the remedy."""


def escape(text: str, max_chars: int = MAX_QUOTED_CHARS, keep: str = "") -> str:
    """Shorten text from a file, and escape control characters, which a terminal would obey.

    max_chars: longer text keeps its start and its end only; keep: control characters that stay, such as a newline.
    """
    if len(text) > max_chars:
        text = f"{text[: max_chars // 2]} … {text[-max_chars // 2 :]}"
    return "".join(one if one.isprintable() or one in keep else ascii(one)[1:-1] for one in text)


def is_text(place: object) -> bool:
    """Return whether this is the content of a file, which ends with a newline, and not a path."""
    return str(place).endswith("\n")


def file_name(place: str) -> str:
    """Return the last part of a path of any operating system. Content of a file is returned unchanged."""
    return place if is_text(place) else place.replace("\\", "/").rsplit("/", 1)[-1]


def require_file(path: Path, max_bytes: int) -> None:
    """Raise OSError if there is no such file, and ValueError if it is a pipe, a device or too large.

    The file is not opened, because opening a pipe would block.
    """
    found = os.stat(path)
    if stat.S_ISDIR(found.st_mode):
        raise OSError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        raise ValueError(f"{path}: a pipe or device, not a file: save what comes out of it as one")
    if found.st_size > max_bytes:
        raise ValueError(f"{path}: it has {found.st_size / MEGABYTE:,.0f} MB, more than {max_bytes / MEGABYTE:g}")


def read_bytes(path: Path, max_bytes: int) -> bytes:
    """Read a whole file. Raises as `require_file`, also if the file grows while it is read."""
    require_file(path, max_bytes)
    with path.open("rb") as file:
        content = file.read(max_bytes + 1)
    if len(content) > max_bytes:
        raise ValueError(f"{path}: it has more than {max_bytes / MEGABYTE:g} MB")
    return content


def read_toml(path: Path) -> bytes:
    """Read a file for `parse_toml`. Raises as `read_bytes`."""
    return read_bytes(path, MAX_TOML_BYTES)


def parse_toml(content: bytes, kind: type = dict) -> Any:
    """Parse TOML into an object of a type that msgspec can make.

    Raises ValueError if the content is no such object, or nests so deeply that parsing it would take too long.
    """
    without = STRINGS_AND_COMMENTS.sub(lambda found: b"" if found[0].startswith(b"#") else b'""', content)
    if LONG_KEY.search(without):
        raise ValueError(f"a name of more than {MAX_KEY_PARTS} parts")
    try:
        return msgspec.toml.decode(content.removeprefix(BOM_UTF8), type=kind)  # some editors write a byte order mark
    except RecursionError:
        raise ValueError("it nests too deeply") from None
    except msgspec.MsgspecError as error:  # a ValueError since msgspec 0.21
        raise ValueError(str(error)) from None


def read_npz(path: Path) -> dict[str, NDArray[Any]]:
    """Read all arrays of an .npz file, by name.

    Raises OSError, ValueError if it is no .npz file of numbers, and TooLarge if it is too large once decompressed.
    """
    require_file(path, MAX_ARRAY_BYTES)
    try:
        with zipfile.ZipFile(path) as members:
            size = sum(member.file_size for member in members.infolist())
        if size > MAX_ARRAY_BYTES:
            raise TooLarge(f"{path}: it unpacks to {size / MEGABYTE:,.0f} MB: keep fewer frames in a file")
        with np.load(path) as file:
            return {name: file[name] for name in file.files}
    except TooLarge:
        raise
    except DAMAGED:  # RecursionError is a RuntimeError
        raise ValueError(f"{path}: not an .npz file of numbers") from None
