"""What --json prints: one object on one line, numbers as far as they are known, and all that repeats the result."""

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

FORMAT = 2  # of the object: it grows whenever a key or a word of it is renamed or changes its meaning
DIGITS = 6  # of a number below one, significant, so that nothing small becomes 0; behind the point of all others
UNPRINTABLE = re.compile(r"[\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff]")  # which terminals may obey
HOW_TOLD = {"command", "run", "json"}  # what is no option of the result


def print_json(args: argparse.Namespace, result: dict, settings: Settings | None = None) -> None:
    """The result with the version, the number of the format, the command, all settings by name, exact, and the options
    that are no settings.

    What is not a number becomes null. Where the console's encoding lacks a character it is escaped.
    """
    told = {"version": __version__, "format": FORMAT, "command": args.command}
    among = set()
    if settings is not None:
        told["settings"] = msgspec.to_builtins(settings)
        among = {*settings.__struct_fields__}
    told["options"] = {name: _exact(value) for name, value in vars(args).items() if name not in HOW_TOLD | among}
    assert told.keys().isdisjoint(result), "a result that overwrites what it was made from"
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    escaped = not encoding.lower().startswith("utf")
    encoder = json.JSONEncoder(allow_nan=False, ensure_ascii=escaped)
    encode = lambda value: UNPRINTABLE.sub(lambda found: f"\\u{ord(found[0]):04x}", encoder.encode(value))
    sys.stdout.write(encode(told)[:-1])
    sys.stdout.writelines(_pieces(result, encode))
    print("}")


def _pieces(result: dict, encode: Callable[[Any], str]) -> Iterator[str]:
    """Of an object that has begun. Of a list or an iterator an item at a time, for there may be very many."""
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
    """To DIGITS: 44.99766 of 44.997659963130204, 3.30872e-24 of 3.308722450212111e-24."""
    if value == 0 or abs(value) >= 1:
        return round(value, DIGITS)
    return round(value, DIGITS - 1 - math.floor(math.log10(abs(value))))


def plain(value: Any) -> Any:
    """Of what JSON has, each number rounded; None for what is not a number."""
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
    """As `plain`, of many numbers at once: those that are at least one, as pixels are, are rounded together."""
    flat = values.astype(float).ravel()
    found = np.round(flat, DIGITS).astype(object)
    for k in np.flatnonzero(~(np.abs(flat) >= 1) | np.isinf(flat)):
        found[k] = rounded(float(flat[k])) if np.isfinite(flat[k]) else None
    return found.reshape(values.shape).tolist()


def _exact(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        return [_exact(item) for item in value]
    return str(value) if isinstance(value, Path) else value
