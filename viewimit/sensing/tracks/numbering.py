"""Numbers of frames, as tables write them: whole numbers, time stamps, and names of pictures."""

import re
from collections.abc import Sequence
from decimal import Decimal

import numpy as np
from numpy.typing import NDArray

from ..files import MAX_NAME_CHARS, escape

MAX_FRAME = 2**64 - 1
NUMBER = re.compile(r"\d+(?:[.,]\d*)?(?:[eE][+-]?\d{1,3})?")
PICTURE = re.compile(r"[^/]*\d[^/]*\.[A-Za-z]\w{1,4}|[A-Za-z][^/]*\d")
SUFFIX = re.compile(r"\.[A-Za-z]\w{1,4}$")
DIGITS = re.compile(r"\d+")
MAX_DIGITS = 20  # of a number in a name


def whole_number(text: str) -> int:
    """Return a whole number up to MAX_FRAME, also as 3.0 or 3e0. Raises ValueError that says what it is instead."""
    text = text.strip()
    if NUMBER.fullmatch(text):
        value = Decimal(text.replace(",", "."))
        if value > MAX_FRAME:
            raise ValueError(f"{escape(text, MAX_NAME_CHARS)!r} is not a whole number up to 2⁶⁴")
        if value == value.to_integral_value():
            return int(value)
    raise ValueError(f"{escape(text, MAX_NAME_CHARS)!r} is not a whole number from 0: number the frames 0, 1, 2, …")


class FrameLabels:
    """The different cells of a column that says which frame a row is of.

    Of several numbers in the names of pictures, the frame's is the one that tells the pictures apart.
    """

    def __init__(self) -> None:
        self._at: dict[str, int] = {}
        self._parts: list[tuple[int, ...]] = []

    def add(self, text: str) -> int:
        """Return the index of this cell among the different ones. Raises ValueError if it numbers no frame."""
        at = self._at.get(text)
        if at is None:
            parts = _parts(text)
            at = self._at[text] = len(self._at)
            self._parts.append(parts)
        return at

    def described(self, number: int) -> str:
        """Return the number of a frame, and the cells that say so if they are others."""
        same = [text for text, one in zip(self._at, self.numbers().tolist()) if one == number]
        names = " and ".join(escape(text, MAX_NAME_CHARS) for text in same[:2])
        return str(number) if names == str(number) else f"{number} ({names})"

    def numbers(self) -> NDArray[np.uint64]:
        """Return the number of each different cell."""
        n = min(map(len, self._parts), default=0)
        columns = list(zip(*(parts[len(parts) - n :] for parts in self._parts)))
        return np.array(columns[_frame_column(columns)] if columns else [], np.uint64)


def _frame_column(columns: Sequence[tuple[int, ...]]) -> int:
    """Which numbers of the names of pictures count them: those that tell all apart, of them the narrowest and last."""
    pictures = len(set(zip(*columns)))
    apart = [k for k, column in enumerate(columns) if len(set(column)) == pictures]
    if apart:
        return min(reversed(apart), key=lambda k: max(columns[k]) - min(columns[k]))
    varying = [k for k, column in enumerate(columns) if len(set(column)) > 1]
    return varying[-1]


def _parts(text: str) -> tuple[int, ...]:
    """The number of a frame, or the numbers in the name of its picture."""
    try:
        return (whole_number(text),)
    except ValueError as error:
        name = text.strip().replace("\\", "/").rsplit("/", 1)[-1]
        if not PICTURE.fullmatch(name):
            raise ValueError(f"{error}, or name pictures, img0003.png") from None
        digits = DIGITS.findall(SUFFIX.sub("", name))
        parts = tuple(int(one) for one in digits if len(one) < MAX_DIGITS)
        if not parts:
            raise ValueError(f"{name!r} is a picture without a number: name pictures img0003.png") from None
        return parts
