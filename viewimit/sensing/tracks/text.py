"""Tables as text: cells separated by commas, semicolons or tabs, decimal commas where columns are separated otherwise.

All faults are named by file, line and column.
"""

import csv
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TextIO

import numpy as np

from ...estimation.views import VIEW_NAMES, VIEWS, view_of
from ..files import MEGABYTE, require_file
from .track import CERTAIN, MOST_PX, Row, Rows, Track, TrackedPoints, together

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


# A plain table of one view: a row a point, columns frame, point, x, y and confidence under whatever name they go, as
# OpenCV's keypoints, COLMAP's points of an image or a spreadsheet have them. Without a frame all rows are of one.

MEANT = {  # headings in small letters, without spaces, dots, underlines and brackets
    "frame": ("frame", "frameidx", "frameindex", "frameid", "framenumber", "image", "imageid", "imageidx", "t"),
    "point": ("point", "pointid", "pointname", "name", "id", "keypoint", "keypointid", "keypointname", "bodypart",
              "node", "nodename", "trackid", "point3did", "classid", "marker", "markerid", "label"),
    "x": ("x", "xpx", "u", "upx", "ptx", "px", "posx", "xpixel"),
    "y": ("y", "ypx", "v", "vpx", "pty", "py", "posy", "ypixel"),
    "confidence": ("confidence", "likelihood", "score", "probability", "prob", "visibility", "visible"),
}  # fmt: skip
NEEDED = ("point", "x", "y")


def read_plain(path: Path) -> Track:
    """Raises ValueError that names the file, and the line and column of what is wrong; OSError."""
    table = Table(path)
    lines = table.lines()
    line, heading = next(lines)
    at = _columns(path, line, heading)
    rows = Rows()
    for line, cells in lines:
        table.require_count(line, cells, len(heading))
        frame = table.whole(line, heading[at["frame"]], cells[at["frame"]]) if "frame" in at else 0
        point = cells[at["point"]].strip()
        if point in ("", "-1"):  # of no keypoint, or of none that COLMAP has matched
            continue
        x, y = (table.number(line, heading[at[name]], cells[at[name]], empty=np.nan) for name in "xy")
        sure = CERTAIN
        if "confidence" in at:
            sure = table.number(line, heading[at["confidence"]], cells[at["confidence"]], empty=CERTAIN)
        rows.add(line, frame, point, x, y, sure)
    rows.require_once(str(path))
    return rows.track(str(path))


def _columns(path: Path, line: int, heading: list[str]) -> dict[str, int]:
    """Which column is what. Raises ValueError for what is missing, or meant by two columns."""
    plain = ["".join(filter(str.isalnum, name.lower())) for name in heading]
    at: dict[str, int] = {}
    for wanted, names in MEANT.items():
        found = [k for k, name in enumerate(plain) if name in names]
        exact = [k for k in found if plain[k] == wanted]
        if len(found) > 1 and len(exact) != 1:
            said = " or ".join(heading[k] for k in found)
            raise ValueError(f"{path}: line {line}: is {wanted} the column {said}? Keep one of them, as {wanted}")
        if found:
            at[wanted] = (exact or found)[0]
    missing = [name for name in NEEDED if name not in at]
    if missing:
        spaces = len(heading) == 1 and len(heading[0].split()) >= len(NEEDED)
        hint = ": separate columns by , or ; or tabs, not spaces" if spaces else ""
        raise ValueError(
            f"{path}: line {line}: no column {', '.join(missing)}{hint}; a table of one view begins with the line "
            "frame,point,x,y,confidence, where points of the same name in all views are the same"
        )
    return at


# Tidy tables: frame, view, point, x, y, confidence; a row a point that was seen in a picture, of all four views.

COLUMNS = ("frame", "view", "point", "x", "y", "confidence")


def write_tidy(path: Path, rows: Mapping[str, Sequence[Row]]) -> None:
    """rows: by view, whose full name is written. Raises OSError."""
    with path.open("w", newline="", encoding="utf-8") as file:
        out = csv.writer(file)
        out.writerow(COLUMNS)
        for view in VIEWS:
            for frame, point, x, y, sure in rows.get(view, ()):
                out.writerow((frame, VIEW_NAMES[view], point, f"{x:.4f}", f"{y:.4f}", f"{sure:.4f}"))


def read_tidy(path: Path) -> TrackedPoints:
    """Views are called by their full names, demo_left, or by the paper's, l.

    Raises ValueError that names the file, and the line and column of what is wrong; OSError.
    """
    table = Table(path)
    lines = table.lines()
    at, cells = next(lines)
    heading = column_names(cells)
    missing = [name for name in COLUMNS[:-1] if name not in heading]
    if kind := colmap_kind(",".join(map(str.strip, cells))):
        raise ValueError(f"{path}: {converting(path, kind)}")
    if missing:
        one = (
            ". Files of one view are given by --demo-left, --demo-right, --own-left and --own-right"
            if "view" in missing
            else ""
        )
        said = f"no column {', '.join(missing)}; the first line is {','.join(COLUMNS)}{one}"
        raise ValueError(f"{path}: line {at}: {said}")
    twice = [name for name in COLUMNS if heading.count(name) > 1]
    if twice:
        raise ValueError(f"{path}: line {at}: two columns are named {twice[0]}: keep one of them")
    frame_at, view_at, point_at, x_at, y_at = (heading.index(name) for name in COLUMNS[:-1])
    sure_at = heading.index(COLUMNS[-1]) if COLUMNS[-1] in heading else None
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
        sure = CERTAIN if sure_at is None else table.number(line, COLUMNS[-1], cells[sure_at], empty=CERTAIN)
        rows[view].add(line, frame, point, x, y, sure)
    for view in VIEWS:
        rows[view].require_once(str(path), VIEW_NAMES[view])
    lacking = [VIEW_NAMES[view] for view in VIEWS if not rows[view].line]
    if lacking:
        needed = ", ".join(VIEW_NAMES.values())
        raise ValueError(f"{path}: no row of view {', '.join(lacking)}; all of {needed} are needed")
    where = {view: f"{path}: view {VIEW_NAMES[view]}" for view in VIEWS}
    return together({view: rows[view].track(str(path)).require_units(where[view]) for view in VIEWS})


# Models of COLMAP as text, which are not read: what converts the points of one of their images.
# One file holds the images of all views, in two lines each, and names points by their place in space, so that only a
# person knows which image is which view, and which points of the two arms are the same.

KINDS = {"# Image list": "images.txt", "# 3D point list": "points3D.txt", "# Camera list": "cameras.txt"}  # first lines
POSE, CELLS = 9, 10  # of an image: numbers, and its name behind them
COMMAND = (
    "python -c \"r = [s.split() for s in open('{file}') if s[0] != '#']; "
    "p = next(p for i, p in zip(r[::2], r[1::2]) if i[9] == 'demo_left.png'); print('point,x,y'); "
    "[print(p[k + 2], p[k], p[k + 1], sep=',') for k in range(0, len(p), 3) if p[k + 2] != '-1']\" > demo_left.csv"
)


def colmap_kind(first: str) -> str | None:
    """Which of its files begins with this line, if one does."""
    for start, kind in KINDS.items():
        if first.startswith(start):
            return kind
    return "images.txt" if _is_pose(first.split(maxsplit=POSE)) else None


def converting(path: Path, kind: str) -> str:
    """A sentence with the command."""
    if kind != "images.txt":
        return f"COLMAP's {kind} holds no points of images: take images.txt beside it"
    return (
        "COLMAP's images.txt is not read, as it holds all views; write the points of each of them, here of "
        "demo_left.png, as CSV, and give the same names to the same points of both arms: "
        f"{COMMAND.format(file=path)}"
    )


def _is_pose(cells: list[str]) -> bool:
    """An image's first line, where the heading was taken out."""
    if len(cells) != CELLS:
        return False
    try:
        return all(float(cell) == float(cell) for cell in cells[:POSE])
    except ValueError:
        return False
