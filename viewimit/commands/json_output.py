"""What --json prints: one object on one line, with rounded numbers and everything that repeats the result."""

import argparse
import json
import math
import re
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from .. import __version__
from ..loop.settings import Settings

FORMAT = 2  # of the object: it grows when a key or a value is renamed or changes its meaning
DIGITS = 6  # significant digits of a number below one, decimals of all others
UNPRINTABLE = re.compile(
    r"[\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff]"
)  # control characters, which may change a terminal
NOT_OPTIONS = {"command", "run", "json"}  # of the arguments


def print_json(args: argparse.Namespace, result: dict, settings: Settings | None = None) -> None:
    """Print a result with the version, the format's number, the command, all settings and the other options.

    NaN and infinity become null. A character that the console's encoding lacks is escaped.
    """
    head = {"version": __version__, "format": FORMAT, "command": args.command}
    among = set()
    if settings is not None:
        head["settings"] = msgspec.to_builtins(settings)
        among = {*settings.__struct_fields__}
    head["options"] = {name: _exact(value) for name, value in vars(args).items() if name not in NOT_OPTIONS | among}
    assert head.keys().isdisjoint(result), "a result that overwrites what it was made from"
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    escaped = not encoding.lower().startswith("utf")
    encoder = json.JSONEncoder(allow_nan=False, ensure_ascii=escaped)
    encode = lambda value: UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", encoder.encode(value))
    sys.stdout.write(encode(head)[:-1])
    sys.stdout.writelines(_pieces(result, encode))
    print("}")


def _pieces(result: dict, encode: Callable[[Any], str]) -> Iterator[str]:
    """The rest of a JSON object, in pieces. Lists and iterators come item by item, because they may be very long."""
    for key, value in result.items():
        yield f", {encode(str(key))}: "
        if isinstance(value, (list, Iterator)):
            yield "["
            for k, item in enumerate(value):
                yield (", " if k else "") + encode(plain(item))
            yield "]"
        else:
            yield encode(plain(value))


def rounded(value: float) -> float:
    """Round to DIGITS: 44.997659963130204 to 44.99766, 3.308722450212111e-24 to 3.30872e-24."""
    if value == 0 or abs(value) >= 1:
        return round(value, DIGITS)
    return round(value, DIGITS - 1 - math.floor(math.log10(abs(value))))


def plain(value: Any) -> Any:
    """Convert a value to JSON's types, with rounded numbers. NaN and infinity become None."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray) and value.dtype.kind == "f" and value.size > 1:
        return _array(value)
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return rounded(value) if math.isfinite(value) else None
    return value


def _array(values: NDArray) -> Any:
    """As `plain`, for an array: numbers of at least one, such as pixels, are rounded together."""
    flat = values.astype(float).ravel()
    found = np.round(flat, DIGITS).astype(object)
    for k in np.flatnonzero(~(np.abs(flat) >= 1) | np.isinf(flat)):
        found[k] = rounded(float(flat[k])) if np.isfinite(flat[k]) else None
    return found.reshape(values.shape).tolist()


def _exact(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return [_exact(item) for item in value]
    return str(value) if isinstance(value, Path) else value
