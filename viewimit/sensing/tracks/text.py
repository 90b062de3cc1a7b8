"""Read and write tables of points as text: one of all four views, and one of a single view under common headings.

Cells are separated by commas, semicolons or tabs. Decimal commas are read unless commas separate the cells. Every
fault is named by file, line and column. COLMAP's text files are refused with a command that converts them.
"""

import csv
import math
import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import TextIO

import numpy as np

from ...estimation.views import VIEW_NAMES, VIEWS, view_of
from ..files import MAX_NAME_CHARS, MEGABYTE, escape, require_file
from .columns import Columns, Meaning, find_columns, meaning_of, name_unread, require_pixel_unit, word_as_number
from .names import point_name
from .numbering import FrameLabels, whole_number
from .track import MAX_PX, Row, Rows, Track, TrackedPoints, combine_views

MAX_LINE = 1 << 20  # characters
MAX_BYTES = 1024 * MEGABYTE  # rows are kept in a few bytes each
SEPARATORS = ",;\t"
SAID_SEPARATOR = re.compile(r'"?sep=(,|;|\t|\\t)"?', re.IGNORECASE)  # a first line of spreadsheets
MISSING = ("nan", "-nan", "na", "n/a", "#n/a", "<na>", "null", "none", "-", "--")  # of a number that is not there
COMMENT = ("#", "%", "//")  # in front of a line
COLUMNS = ("frame", "view", "point", "x", "y", "confidence")  # of a table of all four views
REQUIRED = (Meaning.POINT, Meaning.X, Meaning.Y)
PICTURE_NAME = re.compile(r"\.(?:png|jpe?g|tiff?|bmp|gif|avi|mp4)\b", re.IGNORECASE)
NAME_POINTS = "name points in a column point, and pictures in a column frame"
NO_POINT = ("", "-1")  # no keypoint, or one that COLMAP has not matched
COLMAP_FILES = {"# Image list": "images.txt", "# 3D point list": "points3D.txt", "# Camera list": "cameras.txt"}
COLMAP_IMAGE = re.compile(r"\s*(?:[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?\s+){9}\S")  # nine numbers and a name
COLMAP_COMMAND = (
    "python -c \"r = [s.split() for s in open('{file}') if s[0] != '#']; "
    "p = next(p for i, p in zip(r[::2], r[1::2]) if i[9] == 'demo_left.png'); print('point,x,y'); "
    "[print(p[k + 2], p[k], p[k + 1], sep=',') for k in range(0, len(p), 3) if p[k + 2] != '-1']\" > demo_left.csv"
)


class Table:
    """A text file of cells.

    Raises OSError, and ValueError if the file is not text in UTF-8 or is too large.
    """

    def __init__(self, path: Path):
        require_file(path, MAX_BYTES)
        self.path = path
        self.first = ""  # line that is not empty
        self.skipped = 0  # comments below the heading, once all lines have been read
        self._begins = 0  # line of the heading
        self._separator = self._detect_separator()
        self._decimal: str | None = None  # "," or ".", once an ambiguous number has been read

    def lines(self) -> Iterator[tuple[int, list[str]]]:
        """Yield line numbers from 1 and cells, without empty lines."""
        try:
            with self.path.open(newline="", encoding="utf-8-sig") as file:
                lines = islice(self._bounded_lines(file), self._begins - 1, None)
                reader = csv.reader(lines, strict=True, delimiter=self._separator)
                for cells in reader:
                    line = reader.line_num + self._begins - 1
                    if not cells or not (cells[0] or any(map(str.strip, cells))):
                        continue
                    if line == self._begins:
                        cells[0], columns = cells[0].lstrip("#%/ "), len(cells)
                        of_points = meaning_of(cells[0]) is Meaning.POINT  # whose names may begin with #
                    elif cells[0].lstrip().startswith(COMMENT) and not (of_points and len(cells) == columns):
                        self.skipped += 1
                        continue
                    yield line, cells
        except UnicodeDecodeError:
            raise ValueError(f"{self.path}: not a text file in UTF-8: save it as CSV in UTF-8") from None
        except csv.Error as error:
            raise ValueError(f"{self.path}: line {reader.line_num + self._begins - 1}: {error}") from None

    def filled(self, line: int, cells: list[str], columns: int) -> list[str]:
        """Return a line with the empty cells that were cut at its end. Raise ValueError for one that has too many."""
        cells = cells + [""] * (columns - len(cells))
        self.require_count(line, cells, columns)
        return cells

    def require_count(self, line: int, cells: list[str], columns: int) -> None:
        """Raise ValueError for a line that has another number of cells."""
        if len(cells) != columns:
            commas = self._separator == "," and len(cells) > columns
            hint = "; with decimal commas separate columns by ;" if commas else ""
            raise ValueError(f"{self.path}: line {line}: {len(cells)} cells, but {columns} columns{hint}")

    def number(self, line: int, column: str, text: str, empty: float) -> float:
        """Return a coordinate or confidence; `empty` for an empty cell, NaN for NaN."""
        try:
            value = math.inf if "_" in text else float(text)  # 1_000 is a number to Python only
            if -MAX_PX <= value <= MAX_PX and (self._separator == "," or "." not in text):
                return value
        except ValueError:
            value = math.inf
        text = text.strip()
        if not text:
            return empty
        if text.lower() in MISSING:
            return math.nan
        if self._separator != "," and ("," in text or "." in text):
            value = self._with_decimal(line, column, text)
            if -MAX_PX <= value <= MAX_PX:
                return value
        fault = f"is no pixel: beyond {MAX_PX:g}" if math.isfinite(value) else "is not a finite number"
        raise ValueError(f"{self.path}: line {line}, column {column}: {text!r} {fault}")

    def seen(self, line: int, column: str, meaning: Meaning, text: str) -> float:
        """Return what a column about that says of a point; inf for an empty cell."""
        number = word_as_number(meaning, text) if text.strip()[:1].isalpha() else None
        try:
            return self.number(line, column, text, math.inf) if number is None else number
        except ValueError as error:
            raise ValueError(f"{error}: write 1 or 0, yes or no, or a share in 0 … 1") from None

    def whole(self, line: int, column: str, text: str) -> int:
        """Return a whole number."""
        return self._read(whole_number, line, column, text)

    def frame(self, labels: FrameLabels, line: int, column: str, text: str) -> int:
        """Return the index of a frame's label."""
        return self._read(labels.add, line, column, text)

    def _read(self, read: Callable[[str], int], line: int, column: str, text: str) -> int:
        try:
            return read(text)
        except ValueError as error:
            raise ValueError(f"{self.path}: line {line}, column {column}: {error}") from None

    def _with_decimal(self, line: int, column: str, text: str) -> float:
        """A number with , or . where columns are not separated by commas. Raises ValueError if both occur."""
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

    def _bounded_lines(self, file: TextIO) -> Iterator[str]:
        for number, line in enumerate(iter(lambda: file.readline(MAX_LINE), ""), 1):
            if len(line) == MAX_LINE:
                raise ValueError(f"{self.path}: line {number} has more than {MAX_LINE:,} characters: no table")
            yield line

    def _detect_separator(self) -> str:
        """The separator that is said or most frequent in the heading: the first line that is no comment.

        If that is none, the last comment before it may be: numpy.savetxt writes its heading so.
        """
        comment, separator = None, ""
        try:
            with self.path.open(encoding="utf-8-sig") as file:
                for number, line in enumerate(self._bounded_lines(file), 1):
                    text = line.strip("\r\n")
                    if not text.strip():
                        continue
                    self.first = self.first or text
                    if said := SAID_SEPARATOR.fullmatch(text):
                        separator = "\t" if said[1] == "\\t" else said[1]
                        continue
                    if text.lstrip().startswith(COMMENT):
                        comment = (number, text)
                        continue
                    if comment is not None and not _is_heading(text) and _is_heading(comment[1]):
                        number, text = comment
                    self._begins = number
                    return separator or _most_frequent(text)
        except UnicodeDecodeError:
            raise ValueError(f"{self.path}: not a text file in UTF-8: save it as CSV in UTF-8") from None
        if comment is None:
            raise ValueError(f"{self.path}: the file is empty")
        self._begins, text = comment
        return separator or _most_frequent(text)


def _most_frequent(line: str) -> str:
    count = Counter(line)
    return max(SEPARATORS, key=lambda separator: count[separator])


def _is_heading(line: str) -> bool:
    """Whether a line names columns x and y, or is the first of a pose tracker's."""
    names = [name.strip(' "#%/') for name in re.split("[,;\t]", line)]
    return {Meaning.X, Meaning.Y} <= {*map(meaning_of, names)} or names[0] == "scorer" or "frame_idx" in names


def column_names(cells: Sequence[str]) -> list[str]:
    """Return headings in lower case without surrounding blanks: spreadsheets capitalise words."""
    return [name.strip().lower() for name in cells]


def write_tidy(path: Path, rows: Mapping[str, Sequence[Row]]) -> None:
    """Write a table of all four views, given the rows of each. Raises OSError."""
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(COLUMNS)
        for view in VIEWS:
            for frame, point, x, y, confidence in rows.get(view, ()):
                out.writerow((frame, VIEW_NAMES[view], point, f"{x:.4f}", f"{y:.4f}", f"{confidence:.4f}"))


def read_tidy(path: str | Path) -> TrackedPoints:
    """Read a table of all four views: one row for each point visible in a picture.

    Columns are frame, view, point, x, y and, optionally, confidence or the like. Views have their full names, such as
    demo_left, or the paper's, such as l.

    Raises ValueError that names the file, line and column, and OSError.
    """
    path = Path(path)
    tracks = _read_rows(path, (Meaning.FRAME, Meaning.VIEW, *REQUIRED))
    lacking = [VIEW_NAMES[view] for view in VIEWS if view not in tracks]
    if lacking:
        needed = ", ".join(VIEW_NAMES.values())
        raise ValueError(f"{path}: no row of view {', '.join(lacking)}; all of {needed} are needed")
    return combine_views(tracks).require_pixels(f"{path}: ")


def read_plain(path: Path) -> Track:
    """Read a table of one view, under the usual names of columns, as OpenCV's keypoints or a spreadsheet have them.

    Without a column for the frame, all rows are of one frame. Raises ValueError that names the file, line and column,
    and OSError.
    """
    return _read_rows(path, REQUIRED)[""]


def _read_rows(path: Path, required: Sequence[Meaning]) -> dict[str, Track]:
    """The rows of each view; of the view "" in a table without one."""
    table = Table(path)
    lines = table.lines()
    line, heading = next(lines)
    refuse_colmap(path, table.first)
    columns = find_columns(f"{path}: line {line}", heading)
    if missing := [meaning.value for meaning in required if meaning not in columns.at]:
        raise ValueError(f"{path}: line {line}: no column {_missing(missing, heading, Meaning.VIEW in required)}")
    read, nameless = _rows_by_view(table, lines, heading, columns)
    unread = [name_unread("column", columns.unread)]
    unread += [f"{nameless} row{'s' if nameless > 1 else ''} without a name of a point"] if nameless else []
    comments = f"{table.skipped} line{'s' if table.skipped > 1 else ''} of comment" if table.skipped else ""
    if not read:
        raise ValueError(f"{path}: no row of a point below the heading{comments and f', but {comments}'}")
    unread += [comments] if comments else []
    point_column = heading[columns.at[Meaning.POINT]]
    names = [name for rows in read.values() for name in rows.points()]
    if all(map(PICTURE_NAME.search, names)):
        picture = escape(names[0], MAX_NAME_CHARS)
        raise ValueError(f"{path}: column {point_column}: {picture!r} is a picture, not a point: {NAME_POINTS}")
    tracks = {}
    for view, rows in read.items():
        rows.require_once(str(path), VIEW_NAMES.get(view, ""), _hint(columns, rows, point_column))
        track = rows.track(f"{path}: view {VIEW_NAMES[view]}" if view else str(path))
        tracks[view] = replace(track, unread="; ".join(filter(None, unread)))
    return tracks


def _rows_by_view(
    table: Table, lines: Iterator[tuple[int, list[str]]], heading: list[str], columns: Columns
) -> tuple[dict[str, Rows], int]:
    """The rows of each view, and how many name no point. The view is "" in a table without one."""
    at = columns.at
    frame_at, view_at, point_at, x_at, y_at = (
        at.get(one, -1) for one in (Meaning.FRAME, Meaning.VIEW, Meaning.POINT, Meaning.X, Meaning.Y)
    )
    read: dict[str, Rows] = {}
    known, names, nameless, view = dict[str, str](), dict[str, str](), 0, ""
    for line, cells in lines:
        if len(cells) != len(heading):
            table.require_count(line, cells, len(heading))
        if view_at >= 0 and not (view := known.get(cells[view_at], "")):
            try:
                view = known[cells[view_at]] = view_of(cells[view_at].strip())
            except ValueError as error:
                raise ValueError(f"{table.path}: line {line}, column view: {error}") from None
        point = names.get(cells[point_at])
        if point is None:
            point = names[cells[point_at]] = point_name(cells[point_at])
        if point in NO_POINT:
            nameless += 1
            continue
        rows = read.get(view)
        if rows is None:
            rows = read[view] = Rows(FrameLabels(), [meaning for _, meaning in columns.seen])
        named = ("", "0") if frame_at < 0 else (heading[frame_at], cells[frame_at])
        label = table.frame(rows.labels, line, *named)
        x = table.number(line, heading[x_at], cells[x_at], np.nan)
        y = table.number(line, heading[y_at], cells[y_at], np.nan)
        rows.add(line, label, point, x, y, _seen(table, line, heading, cells, columns))
    return read, nameless


def _missing(names: list[str], heading: list[str], of_all_views: bool) -> str:
    """Which columns are missing, and how a table begins."""
    if of_all_views:
        hint = ". Files of one view are given by --demo-left, --demo-right, --own-left and --own-right"
        return f"{', '.join(names)}; the first line is {','.join(COLUMNS)}{hint * ('view' in names)}"
    spaces = len(heading) == 1 and len(heading[0].split()) >= len(REQUIRED)
    hint = ": separate columns by , or ; or tabs, not spaces" if spaces else ""
    begins = "frame,point,x,y,confidence, where points of the same name in all views are the same"
    return f"{', '.join(names)}{hint}; a table of one view begins with the line {begins}"


def _seen(table: Table, line: int, heading: list[str], cells: list[str], columns: Columns) -> list[float]:
    """What a row says of whether its point is seen. Raises ValueError for other words, and for a unit but the pixel."""
    for k in columns.units:
        require_pixel_unit(f"{table.path}: line {line}, column {heading[k]}", cells[k])
    return [table.seen(line, heading[k], meaning, cells[k]) for k, meaning in columns.seen]


def _hint(columns: Columns, rows: Rows, point_column: str) -> str:
    """What may be behind two rows of one point."""
    hints = [
        f"column {point_column} names one point in all rows: {NAME_POINTS}" if len(rows.points()) == 1 else "",
        "" if Meaning.FRAME in columns.at else "there is no column frame, so all rows are of one picture",
        f"not read: {name_unread('column', columns.unread)}" if columns.unread else "",
    ]
    return "".join(f"; {hint}" for hint in hints if hint)


def refuse_colmap(path: Path, first: str) -> None:
    """Raise ValueError, with the command that converts it, if this is the first line of one of COLMAP's text files.

    One such file holds the images of all views, and names points by their place in space. So only a person knows
    which image is which view, and which points of the two arms correspond.
    """
    kind = next((kind for start, kind in COLMAP_FILES.items() if first.startswith(start)), None)
    if kind is None and COLMAP_IMAGE.match(first):
        kind = "images.txt"
    if kind == "images.txt":
        raise ValueError(
            f"{path}: COLMAP's images.txt is not read, as it holds all views; write the points of each, here of "
            "demo_left.png, as CSV, and give the same names to the same points of both arms: "
            f"{COLMAP_COMMAND.format(file=path)}"
        )
    if kind is not None:
        raise ValueError(f"{path}: COLMAP's {kind} holds no points of images: take images.txt beside it")
