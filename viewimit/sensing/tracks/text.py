"""Read and write tables of points as text: one of all four views, and one of a single view under common headings.

Cells are separated by commas, semicolons or tabs. Decimal commas are read unless commas separate the cells. Every
fault is named by file, line and column. COLMAP's text files are refused with a command that converts them.
"""

import csv
import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from ...estimation.views import VIEW_NAMES, VIEWS, view_of
from ..files import MEGABYTE, require_file
from .track import CERTAIN, MAX_PX, Row, Rows, Track, TrackedPoints, combine_views

MAX_FRAME = 2**53
MAX_LINE = 1 << 20  # characters
MAX_BYTES = 1024 * MEGABYTE  # rows are kept in a few bytes each
SEPARATORS = ",;\t"
SAID_SEPARATOR = re.compile(r'"?sep=(,|;|\t|\\t)"?', re.IGNORECASE)  # a first line of spreadsheets
MISSING = ("nan", "na", "n/a", "null", "none")  # of a number that is not there
WHOLE = re.compile(r"\.0*$")  # behind a whole number, as pandas writes one
COLUMNS = ("frame", "view", "point", "x", "y", "confidence")  # of a table of all four views
HEADINGS = {  # of a table of one view, in lower case without punctuation
    "frame": ("frame", "frameidx", "frameindex", "frameid", "framenumber", "image", "imageid", "imageidx", "t"),
    "point": ("point", "pointid", "pointname", "name", "id", "keypoint", "keypointid", "keypointname", "bodypart",
              "node", "nodename", "trackid", "point3did", "classid", "marker", "markerid", "label"),
    "x": ("x", "xpx", "u", "upx", "ptx", "px", "posx", "xpixel"),
    "y": ("y", "ypx", "v", "vpx", "pty", "py", "posy", "ypixel"),
    "confidence": ("confidence", "likelihood", "score", "probability", "prob", "visibility", "visible"),
}  # fmt: skip
REQUIRED = ("point", "x", "y")
COLMAP_FILES = {"# Image list": "images.txt", "# 3D point list": "points3D.txt", "# Camera list": "cameras.txt"}
COLMAP_NUMBERS = 9  # before the name in the first line of an image
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
        self._says_separator = False  # in a first line of its own, sep=;
        self._separator = self._detect_separator()
        self._decimal: str | None = None  # "," or ".", once an ambiguous number has been read

    def lines(self) -> Iterator[tuple[int, list[str]]]:
        """Yield line numbers from 1 and cells, without empty lines."""
        try:
            with self.path.open(newline="", encoding="utf-8-sig") as file:
                reader = csv.reader(self._bounded_lines(file), strict=True, delimiter=self._separator)
                for cells in reader:
                    if self._says_separator and reader.line_num == 1:
                        continue
                    if cells and (cells[0] or any(map(str.strip, cells))):
                        yield reader.line_num, cells
        except UnicodeDecodeError:
            raise ValueError(f"{self.path}: not a text file in UTF-8: save it as CSV in UTF-8") from None
        except csv.Error as error:
            raise ValueError(f"{self.path}: line {reader.line_num}: {error}") from None

    def filled(self, line: int, cells: list[str], columns: int) -> list[str]:
        """Return a line with the empty cells that were cut at its end. Raise ValueError for one that has too many."""
        cells = cells + [""] * (columns - len(cells))
        self.require_count(line, cells, columns)
        return cells

    def require_count(self, line: int, cells: list[str], columns: int) -> None:
        """Raise ValueError for a line that has another number of cells."""
        if len(cells) != columns:
            hint = "; with decimal commas separate columns by ;" if self._separator == "," else ""
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

    def whole(self, line: int, column: str, text: str) -> int:
        """Return a whole number, such as a frame's."""
        text = WHOLE.sub("", text.strip())
        if not text.isdecimal() or int(text) > MAX_FRAME:
            fault = f"{text!r} is not a whole number from 0"
            raise ValueError(f"{self.path}: line {line}, column {column}: {fault}")
        return int(text)

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
        """The separator that is most frequent in the first line."""
        try:
            with self.path.open(encoding="utf-8-sig") as file:
                first = next((line for line in self._bounded_lines(file) if line.strip()), "")
        except UnicodeDecodeError:
            raise ValueError(f"{self.path}: not a text file in UTF-8: save it as CSV in UTF-8") from None
        if not first:
            raise ValueError(f"{self.path}: the file is empty")
        said = SAID_SEPARATOR.fullmatch(first.strip("\r\n"))
        if said is not None:
            self._says_separator = True
            return "\t" if said[1] == "\\t" else said[1]
        count = Counter(first)
        return max(SEPARATORS, key=lambda separator: count[separator])


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


def read_tidy(path: Path) -> TrackedPoints:
    """Read a table of all four views: one row for each point visible in a picture.

    Columns are frame, view, point, x, y and, optionally, confidence. Views have their full names, such as demo_left,
    or the paper's, such as l.

    Raises ValueError that names the file, line and column, and OSError.
    """
    table = Table(path)
    lines = table.lines()
    at, cells = next(lines)
    heading = column_names(cells)
    missing = [name for name in COLUMNS[:-1] if name not in heading]
    refuse_colmap(path, ",".join(map(str.strip, cells)))
    if missing:
        hint = ""
        if "view" in missing:
            hint = ". Files of one view are given by --demo-left, --demo-right, --own-left and --own-right"
        fault = f"no column {', '.join(missing)}; the first line is {','.join(COLUMNS)}{hint}"
        raise ValueError(f"{path}: line {at}: {fault}")
    twice = [name for name in COLUMNS if heading.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: line {at}: two columns are named {twice[0]}: keep one of them")
    frame_at, view_at, point_at, x_at, y_at = (heading.index(name) for name in COLUMNS[:-1])
    confidence_at = heading.index(COLUMNS[-1]) if COLUMNS[-1] in heading else None
    names: dict[str, int] = {}
    rows, known = {view: Rows(names) for view in VIEWS}, dict[str, str]()
    for line, cells in lines:
        if len(cells) != len(heading):
            table.require_count(line, cells, len(heading))
        frame = table.whole(line, "frame", cells[frame_at])
        view, point = known.get(cells[view_at]), cells[point_at].strip()
        if view is None:
            try:
                view = known[cells[view_at]] = view_of(cells[view_at].strip())
            except ValueError as error:
                raise ValueError(f"{path}: line {line}, column view: {error}") from None
        if not point:
            raise ValueError(f"{path}: line {line}, column point: it is empty")
        x = table.number(line, "x", cells[x_at], empty=np.nan)
        y = table.number(line, "y", cells[y_at], empty=np.nan)
        confidence = CERTAIN
        if confidence_at is not None:
            confidence = table.number(line, COLUMNS[-1], cells[confidence_at], empty=CERTAIN)
        rows[view].add(line, frame, point, x, y, confidence)
    for view in VIEWS:
        rows[view].require_once(str(path), VIEW_NAMES[view])
    lacking = [VIEW_NAMES[view] for view in VIEWS if not rows[view].line]
    if lacking:
        needed = ", ".join(VIEW_NAMES.values())
        raise ValueError(f"{path}: no row of view {', '.join(lacking)}; all of {needed} are needed")
    return combine_views(
        {view: rows[view].track(str(path)).require_units(f"{path}: view {VIEW_NAMES[view]}") for view in VIEWS}
    )


def read_plain(path: Path) -> Track:
    """Read a table of one view, under any of HEADINGS, as OpenCV's keypoints or a spreadsheet have them.

    Without a column for the frame, all rows are of one frame. Raises ValueError that names the file, line and column,
    and OSError.
    """
    table = Table(path)
    lines = table.lines()
    line, heading = next(lines)
    at = _find_columns(path, line, heading)
    rows = Rows()
    for line, cells in lines:
        table.require_count(line, cells, len(heading))
        frame = table.whole(line, heading[at["frame"]], cells[at["frame"]]) if "frame" in at else 0
        point = cells[at["point"]].strip()
        if point in ("", "-1"):  # no keypoint, or one that COLMAP has not matched
            continue
        x, y = (table.number(line, heading[at[name]], cells[at[name]], empty=np.nan) for name in "xy")
        confidence = CERTAIN
        if "confidence" in at:
            confidence = table.number(line, heading[at["confidence"]], cells[at["confidence"]], empty=CERTAIN)
        rows.add(line, frame, point, x, y, confidence)
    rows.require_once(str(path))
    return rows.track(str(path))


def _find_columns(path: Path, line: int, heading: list[str]) -> dict[str, int]:
    """Column of each quantity. Raises ValueError if one is missing, or two columns could be meant."""
    plain = ["".join(filter(str.isalnum, name.lower())) for name in heading]
    at: dict[str, int] = {}
    for quantity, names in HEADINGS.items():
        found = [k for k, name in enumerate(plain) if name in names]
        exact = [k for k in found if plain[k] == quantity]
        if len(found) > 1 and len(exact) != 1:
            named = " or ".join(heading[k] for k in found)
            raise ValueError(f"{path}: line {line}: is {quantity} the column {named}? Keep one of them, as {quantity}")
        if found:
            at[quantity] = (exact or found)[0]
    missing = [name for name in REQUIRED if name not in at]
    if missing:
        spaces = len(heading) == 1 and len(heading[0].split()) >= len(REQUIRED)
        hint = ": separate columns by , or ; or tabs, not spaces" if spaces else ""
        raise ValueError(
            f"{path}: line {line}: no column {', '.join(missing)}{hint}; a table of one view begins with the line "
            "frame,point,x,y,confidence, where points of the same name in all views are the same"
        )
    return at


def refuse_colmap(path: Path, first: str) -> None:
    """Raise ValueError, with the command that converts it, if this is the first line of one of COLMAP's text files.

    One such file holds the images of all views, and names points by their place in space. So only a person knows
    which image is which view, and which points of the two arms correspond.
    """
    kind = next((kind for start, kind in COLMAP_FILES.items() if first.startswith(start)), None)
    if kind is None and _is_colmap_image(first.split(maxsplit=COLMAP_NUMBERS)):
        kind = "images.txt"
    if kind == "images.txt":
        raise ValueError(
            f"{path}: COLMAP's images.txt is not read, as it holds all views; write the points of each, here of "
            "demo_left.png, as CSV, and give the same names to the same points of both arms: "
            f"{COLMAP_COMMAND.format(file=path)}"
        )
    if kind is not None:
        raise ValueError(f"{path}: COLMAP's {kind} holds no points of images: take images.txt beside it")


def _is_colmap_image(cells: list[str]) -> bool:
    """Whether this is the first line of an image, in a file without a heading."""
    try:
        return len(cells) == COLMAP_NUMBERS + 1 and not any(math.isnan(float(cell)) for cell in cells[:COLMAP_NUMBERS])
    except ValueError:
        return False
