"""Tables as text: cells separated by commas, semicolons or tabs, decimal commas where columns are separated otherwise.

All faults are named by file, line and column.
"""

import csv
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TextIO

from ..files import MEGABYTE, require_file
from .track import MOST_PX

MOST_FRAME = 2**53
MOST_LINE = 1 << 20  # characters
MOST_BYTES = 1024 * MEGABYTE  # rows are kept in a few bytes each
SEPARATORS = ",;\t"


def column_names(cells: Sequence[str]) -> list[str]:
    """Of a heading, in small letters and without blanks around them: spreadsheets begin words with capitals."""
    return [name.strip().lower() for name in cells]


class Table:
    """path: of a text file. Raises OSError, and ValueError for what is no text in UTF-8 or no table."""

    def __init__(self, path: Path):
        require_file(path, MOST_BYTES)
        self.path = path
        self._separator = self._sniffed()
        self._decimal: str | None = None  # , or . as first met where both may be meant

    def lines(self) -> Iterator[tuple[int, list[str]]]:
        """Line numbers from 1 and cells, empty lines left out."""
        try:
            with self.path.open(newline="", encoding="utf-8-sig") as file:
                reader = csv.reader(self._text(file), strict=True, delimiter=self._separator)
                for cells in reader:
                    if cells and (cells[0] or any(map(str.strip, cells))):
                        yield reader.line_num, cells
        except UnicodeDecodeError:
            raise ValueError(f"{self.path}: not a text file in UTF-8: save it as CSV in UTF-8") from None
        except csv.Error as error:
            raise ValueError(f"{self.path}: line {reader.line_num}: {error}") from None

    def _text(self, file: TextIO) -> Iterator[str]:
        """Its lines. Raises ValueError for one that has no end."""
        for number, line in enumerate(iter(lambda: file.readline(MOST_LINE), ""), 1):
            if len(line) == MOST_LINE:
                raise ValueError(f"{self.path}: line {number} has more than {MOST_LINE:,} characters: no table")
            yield line

    def require_count(self, line: int, cells: list[str], columns: int) -> None:
        if len(cells) != columns:
            hint = "; with decimal commas separate columns by ;" if self._separator == "," else ""
            raise ValueError(f"{self.path}: line {line}: {len(cells)} cells, but {columns} columns{hint}")

    def number(self, line: int, column: str, text: str, empty: float) -> float:
        """A pixel or a share; `empty` for an empty cell, NaN for NaN."""
        try:
            value = math.inf if "_" in text else float(text)  # 1_000 is a number to Python only
            if -MOST_PX <= value <= MOST_PX and (self._separator == "," or "." not in text):
                return value
        except ValueError:
            value = math.inf
        text = text.strip()
        if not text:
            return empty
        if text.lower() == "nan":
            return math.nan
        if self._separator != "," and ("," in text or "." in text):
            value = self._with_decimal(line, column, text)
            if -MOST_PX <= value <= MOST_PX:
                return value
        what = f"is no pixel: beyond {MOST_PX:g}" if math.isfinite(value) else "is not a finite number"
        raise ValueError(f"{self.path}: line {line}, column {column}: {text!r} {what}")

    def whole(self, line: int, column: str, text: str) -> int:
        if not (text.isdecimal() or text.strip().isdecimal()) or int(text) > MOST_FRAME:
            said = f"{text.strip()!r} is not a whole number from 0"
            raise ValueError(f"{self.path}: line {line}, column {column}: {said}")
        return int(text)

    def _with_decimal(self, line: int, column: str, text: str) -> float:
        """Where columns are not separated by commas. Raises ValueError where , and . could each be the decimal."""
        here = "," if "," in text else "."
        if text.count(",") + text.count(".") > 1 or here != (self._decimal or here):
            raise ValueError(
                f"{self.path}: line {line}, column {column}: {text!r}: both , and . may be meant as the decimal point; "
                "write all numbers with one of them, and none for thousands"
            )
        self._decimal = here
        try:
            return float(text.replace(",", "."))
        except ValueError:
            return math.inf

    def _sniffed(self) -> str:
        """The separator that the first line has most of."""
        try:
            with self.path.open(encoding="utf-8-sig") as file:
                first = next((line for line in self._text(file) if line.strip()), "")
        except UnicodeDecodeError:
            raise ValueError(f"{self.path}: not a text file in UTF-8: save it as CSV in UTF-8") from None
        if not first:
            raise ValueError(f"{self.path}: the file is empty")
        count = Counter(first)
        return max(SEPARATORS, key=lambda separator: count[separator])
